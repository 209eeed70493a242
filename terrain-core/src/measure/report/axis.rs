use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// Most ticks with a label on an axis.
const MOST_TICKS: f64 = 8.0;
/// Logarithmic axes over less than this many decades get ticks at 2 and 5 as well.
const FEW_DECADES: f64 = 2.5;
/// Magnitudes beyond are left out: differences of them would overflow.
const MOST_MAGNITUDE: f64 = 1.0e150;

/// One axis of a plot. A *place* is where a value lies along it: the value itself, or its decimal
/// logarithm on a logarithmic axis.
#[derive(Clone)]
pub(super) struct Axis {
    /// Whether places are logarithms.
    is_log: bool,
    /// First and last place; the last is greater.
    places: [f64; 2],
    /// Places of the ticks that have a label.
    ticks: Vec<f64>,
}

impl Axis {
    /// An axis over the values, with some room at its ends. Values that have no place are passed
    /// over; without any the axis runs from 0 to 1 (1 to 10 if logarithmic).
    pub fn over(values: impl Iterator<Item = f64>, is_log: bool) -> Self {
        let places = values.filter_map(|value| place(value, is_log));
        let (low, high) = places
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let (low, high) = if is_log { log_room(low, high) } else { linear_room(low, high) };
        let ticks = if is_log { log_ticks(low, high) } else { linear_ticks(low, high) };
        Self { is_log, places: [low, high], ticks }
    }

    /// Where the value lies; `None` where it has no place: not finite, or not positive on a
    /// logarithmic axis.
    pub fn place(&self, value: f64) -> Option<f64> {
        place(value, self.is_log)
    }

    /// The text of a tick.
    fn label(&self, place: f64) -> String {
        if self.is_log {
            let value = 10.0_f64.powf(place);
            return short_number(value, value);
        }
        let step = self.ticks.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
        short_number(place, step)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (start, end): (i32, i32)) -> i32 {
        let [low, high] = self.places;
        let part = (place - low) / (high - low);
        start + (part * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // Light lines, between the ticks, are none.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.places[0]..self.places[1]
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, place: &f64) -> String {
        self.label(*place)
    }
}

fn place(value: f64, is_log: bool) -> Option<f64> {
    let place = if is_log { value.log10() } else { value };
    (place.is_finite() && place.abs() < MOST_MAGNITUDE).then_some(place)
}

fn linear_room(low: f64, high: f64) -> (f64, f64) {
    let span = high - low;
    if span <= low.abs().max(high.abs()) * 1.0e-12 {
        let half = if low == 0.0 { 0.5 } else { 0.1 * low.abs() };
        return (low - half, high + half);
    }
    let room = 0.04 * span;
    // Zero is worth showing where it is near, and no worth leaving where nothing lies below it.
    let low_with_room = if (0.0..0.35 * span).contains(&low) { 0.0 } else { low - room };
    let high_with_room = if high <= 0.0 && -high < 0.35 * span { 0.0 } else { high + room };
    (low_with_room, high_with_room)
}

fn log_room(low: f64, high: f64) -> (f64, f64) {
    let room = (0.04 * (high - low)).max(0.05);
    (low - room, high + room)
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / MOST_TICKS;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * decade)
        .into_iter()
        .find(|&step| step >= rough)
        .unwrap_or(10.0 * decade);
    let first = (low / step).ceil();
    let count = ((high / step).floor() - first).clamp(0.0, 2.0 * MOST_TICKS) as u32;
    (0..=count).map(|index| (first + f64::from(index)) * step).collect()
}

/// Decades, thinned where there are many, with 2 and 5 between them where there are few.
fn log_ticks(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let factors: &[f64] = if high - low < FEW_DECADES { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = ((high - low) / MOST_TICKS).ceil().max(1.0) as i32;
    let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let ticks = decades
        .flat_map(|decade| factors.iter().map(move |factor| f64::from(decade) + factor.log10()))
        .filter(|tick| (low..=high).contains(tick))
        .collect::<Vec<_>>();
    // Values that hardly differ may lie between two ticks.
    if ticks.len() < 2 { linear_in_log(low, high) } else { ticks }
}

fn linear_in_log(low: f64, high: f64) -> Vec<f64> {
    let values = linear_ticks(10.0_f64.powf(low), 10.0_f64.powf(high));
    values.into_iter().filter(|&value| value > 0.0).map(f64::log10).collect()
}

/// The number with as many digits as steps of this size need; powers of ten outside
/// 0.0001 .. 999 999.
fn short_number(value: f64, step: f64) -> String {
    if value.abs() < 1.0e-9 * step.abs() {
        return "0".to_owned();
    }
    let magnitude = value.abs().max(step.abs());
    if !(1.0e-4..1.0e6).contains(&magnitude) {
        let decade = magnitude.log10().floor();
        let scale = 10.0_f64.powf(decade);
        let mantissa = short_number(value / scale, (step / scale).min(1.0));
        let exponent = superscript(decade as i32);
        return match mantissa.as_str() {
            "1" => format!("10{exponent}"),
            _ => format!("{mantissa}·10{exponent}"),
        };
    }
    let decimals = (-(step.abs().log10() + 1.0e-9).floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{value:.decimals$}");
    text.replace('-', "\u{2212}")
}

fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = number.to_string();
    digits.chars().map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64], is_log: bool) -> Vec<String> {
        let axis = Axis::over(values.iter().copied(), is_log);
        axis.ticks.iter().map(|&tick| axis.label(tick)).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        assert_eq!(labels(&[0.0, 60.0], false), ["0", "10", "20", "30", "40", "50", "60"]);
        assert_eq!(labels(&[-1.0, 1.0], false), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels(&[0.0, 0.004], false), ["0", "0.001", "0.002", "0.003", "0.004"]);
        let far = labels(&[0.0, 4.0e6], false);
        assert_eq!(far[1..3], ["10⁶", "2·10⁶"]);
    }

    #[test]
    fn log_ticks_are_decades_and_parts_of_them_where_there_are_few() {
        assert_eq!(labels(&[1.0, 1000.0], true), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&[1.0, 10.0], true), ["1", "2", "5", "10"]);
        assert_eq!(labels(&[1.0e-6, 1.0e-2], true)[..2], ["10⁻⁶", "10⁻⁵"]);
        assert!(labels(&[1.0e-20, 1.0e20], true).len() <= 10);
        assert!(labels(&[3.01, 3.02], true).len() >= 2);
    }

    #[test]
    fn values_without_a_place_do_not_stretch_the_axis() {
        let axis = Axis::over([f64::NAN, 2.0, f64::INFINITY, 4.0].into_iter(), false);
        assert!(axis.places[0] < 2.0 && axis.places[1] < 5.0);
        let axis = Axis::over([-3.0, 0.0, 10.0].into_iter(), true);
        assert!(axis.places[0] < 1.0 && axis.places[1] > 1.0);
        assert_eq!(axis.place(0.0), None);
        assert_eq!(axis.place(100.0), Some(2.0));
    }

    #[test]
    fn every_axis_has_a_length() {
        let cases: [&[f64]; 7] =
            [&[], &[0.0], &[5.0], &[-5.0], &[1.0e200, -1.0e200], &[1.0e-300], &[1.0e16, 1.0e16]];
        for values in cases {
            for is_log in [false, true] {
                let axis = Axis::over(values.iter().copied(), is_log);
                let [low, high] = axis.places;
                assert!(low < high && (high - low).is_finite(), "{values:?} {low} {high}");
                assert!(axis.ticks.len() < 20, "{values:?}");
            }
        }
    }
}
