//! Which samples lie in a triangle, and its plane.

use glam::{DVec2, dvec2};

/// How far outside a triangle, in samples, one still counts as on its edge. Samples are at least
/// 1 / length apart from an edge between samples, so only rounding is taken in.
const EDGE_SLACK: f64 = 1e-9;

/// Calls `visit` with the row and the columns, first and past the last, of the samples in a triangle,
/// edges included, within a grid of `columns` x `rows`. Corners are in samples.
pub fn visit_rows(
    corners: [DVec2; 3],
    [columns, rows]: [usize; 2],
    mut visit: impl FnMut(usize, usize, usize),
) {
    let [a, b, c] = corners;
    let top = (a.y.min(b.y).min(c.y) - EDGE_SLACK).ceil().max(0.0);
    let bottom = (a.y.max(b.y).max(c.y) + EDGE_SLACK).floor().min(rows as f64 - 1.0);
    let mut y = top;
    while y <= bottom {
        let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if let Some([low, high]) = crossing(from, to, y) {
                west = west.min(low);
                east = east.max(high);
            }
        }
        let start = (west - EDGE_SLACK).ceil().max(0.0);
        let last = (east + EDGE_SLACK).floor().min(columns as f64 - 1.0);
        if start <= last {
            visit(y as usize, start as usize, last as usize + 1);
        }
        y += 1.0;
    }
}

/// Smallest and largest x at which an edge meets a row.
fn crossing(from: DVec2, to: DVec2, y: f64) -> Option<[f64; 2]> {
    let (low, high) = (from.y.min(to.y), from.y.max(to.y));
    if y < low - EDGE_SLACK || y > high + EDGE_SLACK {
        return None;
    }
    if high - low <= EDGE_SLACK {
        return Some([from.x.min(to.x), from.x.max(to.x)]);
    }
    let part = ((y - from.y) / (to.y - from.y)).clamp(0.0, 1.0);
    let x = from.x + part * (to.x - from.x);
    Some([x, x])
}

/// How a triangle rises along x and y, per sample; `None` for one without area.
pub fn plane_slope([a, b, c]: [DVec2; 3], heights_m: [f64; 3]) -> Option<DVec2> {
    let (ab, ac) = (b - a, c - a);
    let [rise_b, rise_c] = [1, 2].map(|corner| heights_m[corner] - heights_m[0]);
    let area = ab.perp_dot(ac);
    (area != 0.0)
        .then(|| dvec2(rise_b * ac.y - rise_c * ab.y, rise_c * ab.x - rise_b * ac.x) / area)
}
