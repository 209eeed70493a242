use glam::DVec3;

/// The part of a ray from its origin on that lies within the box from `low` to `high`, in lengths of
/// its direction; `None` where it misses the box. Borders count as in.
pub(super) fn part_within_box(
    origin: DVec3,
    direction: DVec3,
    [low, high]: [DVec3; 2],
) -> Option<[f64; 2]> {
    let (mut from, mut to) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            if origin[axis] < low[axis] || origin[axis] > high[axis] {
                return None;
            }
            continue;
        }
        let a = (low[axis] - origin[axis]) / direction[axis];
        let b = (high[axis] - origin[axis]) / direction[axis];
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (from <= to).then_some([from, to])
}
