use super::{FPS, FlightGround};
use crate::measure::{Flight, FlightError, Keyframe};

/// Keyframes on either side whose ground a keyframe clears, and over which heights are smoothed.
const REACH: usize = 2;
/// Most samples of the ground between two keyframes.
const MOST_SAMPLES: f64 = 512.0;

/// The flight of these keyframes with heights that follow the ground smoothly, never less than
/// `clearance_m` above any of it on the way.
///
/// Each keyframe is first lifted to the highest ground within [`REACH`] and one more keyframes; a mean
/// over no more than [`REACH`] of those is then still above the ground that each of them clears.
pub(super) fn above_ground(
    ground: &FlightGround,
    mut keyframes: Vec<Keyframe>,
    clearance_m: f64,
) -> Result<Flight, FlightError> {
    // The heights of this one do not matter: curves of x and y are their own.
    let way = Flight::new(ground.crs.clone(), FPS, keyframes.clone())?;
    let crests = crests_m(ground, &way);
    let last = keyframes.len() - 1;
    let near = |index: usize| index.saturating_sub(REACH)..=(index + REACH).min(last);
    let lifted = (0..=last)
        .map(|index| {
            let first = near(index).start().saturating_sub(1);
            let intervals = first..(near(index).end() + 1).min(last);
            crests[intervals].iter().copied().fold(f64::NEG_INFINITY, f64::max)
        })
        .collect::<Vec<_>>();
    for (index, keyframe) in keyframes.iter_mut().enumerate() {
        let around = &lifted[near(index)];
        keyframe.height = around.iter().sum::<f64>() / around.len() as f64 + clearance_m;
    }
    Flight::new(ground.crs.clone(), FPS, keyframes)
}

/// The same, all at the height that the highest ground asks for.
pub(super) fn level_above_ground(
    ground: &FlightGround,
    mut keyframes: Vec<Keyframe>,
    clearance_m: f64,
) -> Result<Flight, FlightError> {
    let way = Flight::new(ground.crs.clone(), FPS, keyframes.clone())?;
    let crest_m = crests_m(ground, &way).into_iter().fold(f64::NEG_INFINITY, f64::max);
    for keyframe in &mut keyframes {
        keyframe.height = crest_m + clearance_m;
    }
    Flight::new(ground.crs.clone(), FPS, keyframes)
}

/// The highest ground below each interval between two keyframes.
fn crests_m(ground: &FlightGround, way: &Flight) -> Vec<f64> {
    let place = |t: f64| way.view_at(t, [1, 1]).eye.truncate();
    let crest_m = |pair: &[Keyframe]| {
        let (start, end) = (pair[0].t, pair[1].t);
        let samples = (place(start).distance(place(end)) / ground.sample_m).ceil();
        let samples = samples.clamp(4.0, MOST_SAMPLES) as u32;
        let heights = (0..=samples).map(|step| {
            let t = start + (end - start) * f64::from(step) / f64::from(samples);
            ground.finest_m(place(t))
        });
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    way.keyframes().windows(2).map(crest_m).collect()
}
