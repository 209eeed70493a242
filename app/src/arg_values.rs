//! Values of arguments that several commands take.

use glam::dvec2;
use terrain_core::tiling::Extent;

/// A parser of numbers from `least` to `most`.
pub fn number_within(
    least: f64,
    most: f64,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.trim().parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("give a number from {least} to {most}"))
    }
}

/// A parser of finite numbers above 0.
pub fn positive() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    |text| {
        let number = text.trim().parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
        number.ok_or_else(|| "give a number above 0".to_owned())
    }
}

/// The parser of a factor on all heights: the range that is drawn.
pub fn exaggeration() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number_within(0.01, 1000.0)
}

/// A part of the ground: west, south, east, north in metres or degrees, with commas between them.
pub fn parse_extent(text: &str) -> Result<Extent, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[west, south, east, north])
            if west < east
                && south < north
                && [west, south, east, north].iter().all(|n| n.is_finite()) =>
        {
            Ok(Extent::new(dvec2(west, south), dvec2(east, north)))
        }
        _ => Err("give west,south,east,north with west < east and south < north".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use terrain_core::RendererSettings;

    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        let parse = number_within(0.5, 2.0);
        assert_eq!((parse("0.5"), parse(" 2")), (Ok(0.5), Ok(2.0)));
        for text in ["0.49", "2.01", "-1", "nan", "inf", "-inf", "", "x", "1e999"] {
            assert_eq!(parse(text), Err("give a number from 0.5 to 2".to_owned()), "{text}");
        }
    }

    #[test]
    fn an_exaggeration_taken_is_drawn_as_it_is() {
        for text in ["0.01", "1", "1000"] {
            let vertical_exaggeration = exaggeration()(text).unwrap();
            let settings = RendererSettings { vertical_exaggeration, ..Default::default() };
            assert_eq!(settings.checked().vertical_exaggeration, vertical_exaggeration);
        }
        for text in ["0.009", "1001", "0", "-1", "nan"] {
            assert!(exaggeration()(text).is_err(), "{text}");
        }
    }

    #[test]
    fn an_extent_is_four_numbers_in_order() {
        let extent = parse_extent("-180, -90,180,90").unwrap();
        assert_eq!((extent.min, extent.max), (dvec2(-180.0, -90.0), dvec2(180.0, 90.0)));
        for text in [
            "10,0,5,1",
            "1,2,3",
            "1,2,x,3,4",
            "1,2,3,4,5",
            "1,2,3,nan",
            "0,0,1,inf",
            "",
            "1,2,3,4,",
        ] {
            assert!(parse_extent(text).is_err(), "{text}");
        }
    }
}
