//! Breaklines as GeoJSON (H. Butler et al., RFC 7946, "The GeoJSON Format", 2016).

use std::path::Path;

use glam::dvec2;
use serde_json::Value;

use super::SourceError;
use crate::geodesy::{CoordinateSystem, CoordinateTransform};
use crate::surface::tin::{Breakline, BreaklinePoint};

/// Deepest nesting of collections that is followed.
const DEEPEST: usize = 16;

/// Reads every line and the rings of every polygon, brought into the ground's CRS.
///
/// A third coordinate is a height. Coordinates are in the CRS that a member `crs` names, as files from
/// before 2016 have it and GIS programs still write it; else longitude and latitude. Where
/// the ground's CRS is not known they are taken as they are.
///
/// # Errors
/// Where the file cannot be read, is no GeoJSON, holds no line, or lies where the CRS cannot show it.
pub fn read_breaklines(
    path: &Path,
    ground: Option<&CoordinateSystem>,
) -> Result<Vec<Breakline>, SourceError> {
    let text = std::fs::read_to_string(path).map_err(|error| SourceError::io(path, &error))?;
    let bad = |reason: String| SourceError::bad_breaklines(path, reason);
    let json: Value =
        serde_json::from_str(&text).map_err(|error| bad(format!("no GeoJSON: {error}")))?;
    let mut lines = Vec::new();
    collect(&json, &mut lines, 0).map_err(bad)?;
    lines.retain(|line: &Breakline| line.points.len() >= 2);
    if lines.is_empty() {
        return Err(bad("holds no LineString or Polygon of two points or more".to_owned()));
    }
    let Some(ground) = ground else { return Ok(lines) };
    let own = CoordinateSystem::from_epsg(epsg_of(&json).map_err(bad)?)
        .map_err(|error| bad(error.to_string()))?;
    let transform = CoordinateTransform::new(&own, ground);
    for point in lines.iter_mut().flat_map(|line| &mut line.points) {
        let [x, y] = point.position.to_array();
        let in_degrees = x.abs() <= 540.0 && y.abs() <= 90.0;
        point.position = transform
            .apply(point.position)
            .filter(|_| !own.is_geographic() || in_degrees)
            .ok_or_else(|| {
                bad(format!(
                    "{x}, {y} is no place in {}; name the file's CRS in its member \"crs\"",
                    own.name()
                ))
            })?;
    }
    Ok(lines)
}

/// The code of the member `crs`, that of longitude and latitude where there is none.
fn epsg_of(json: &Value) -> Result<u32, String> {
    let Some(name) = json.pointer("/crs/properties/name").and_then(Value::as_str) else {
        return Ok(CoordinateSystem::WGS84);
    };
    match name.rsplit(':').next() {
        Some("CRS84") => Ok(CoordinateSystem::WGS84),
        Some(code) if name.to_ascii_uppercase().contains("EPSG") => {
            code.parse().map_err(|_| format!("its CRS {name:?} has no EPSG code"))
        }
        _ => Err(format!("its CRS {name:?} has no EPSG code")),
    }
}

/// Appends the lines of a geometry, a feature or a collection.
fn collect(json: &Value, lines: &mut Vec<Breakline>, depth: usize) -> Result<(), String> {
    if depth > DEEPEST {
        return Err(format!("collections more than {DEEPEST} deep"));
    }
    let members = |name: &str| json[name].as_array().map_or(&[][..], Vec::as_slice);
    let mut each =
        |name: &str| members(name).iter().try_for_each(|member| collect(member, lines, depth + 1));
    match json["type"].as_str() {
        Some("FeatureCollection") => each("features"),
        Some("GeometryCollection") => each("geometries"),
        Some("Feature") if json["geometry"].is_null() => Ok(()),
        Some("Feature") => collect(&json["geometry"], lines, depth + 1),
        Some("LineString") => add_lines(&json["coordinates"], 0, lines),
        Some("MultiLineString" | "Polygon") => add_lines(&json["coordinates"], 1, lines),
        Some("MultiPolygon") => add_lines(&json["coordinates"], 2, lines),
        Some("Point" | "MultiPoint") => Ok(()),
        Some(other) => Err(format!("{other:?} is no kind of GeoJSON geometry")),
        None => Err("no GeoJSON: a member \"type\" is missing".to_owned()),
    }
}

/// Appends lines out of lists of lists, `depth` of them round each line.
fn add_lines(json: &Value, depth: usize, lines: &mut Vec<Breakline>) -> Result<(), String> {
    let list = json.as_array().ok_or("coordinates that are no list")?;
    if depth > 0 {
        return list.iter().try_for_each(|part| add_lines(part, depth - 1, lines));
    }
    let points = list.iter().map(point).collect::<Result<_, _>>()?;
    lines.push(Breakline { points });
    Ok(())
}

fn point(json: &Value) -> Result<BreaklinePoint, String> {
    let number = |index: usize| json.get(index).and_then(Value::as_f64);
    match (number(0), number(1)) {
        (Some(x), Some(y)) => Ok(BreaklinePoint { position: dvec2(x, y), height_m: number(2) }),
        _ => Err(format!("{json} is no point")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, epsg: Option<u32>) -> Result<Vec<Breakline>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines.geojson");
        std::fs::write(&path, text).unwrap();
        let ground = epsg.map(|epsg| CoordinateSystem::from_epsg(epsg).unwrap());
        read_breaklines(&path, ground.as_ref()).map_err(|error| error.to_string())
    }

    #[test]
    fn lines_and_rings_are_found_at_any_depth() {
        let text = r#"{"type": "FeatureCollection",
            "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}},
            "features": [
            {"type": "Feature", "geometry": null, "properties": {}},
            {"type": "Feature", "properties": {}, "geometry": {"type": "GeometryCollection", "geometries": [
                {"type": "Point", "coordinates": [1, 2]},
                {"type": "LineString", "coordinates": [[500000, 6800000, 12.5], [500010, 6800000]]},
                {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]], [[5, 5], [6, 6]]]}]}}]}"#;
        let lines = read(text, Some(32632)).unwrap();
        assert_eq!(lines.iter().map(|line| line.points.len()).collect::<Vec<_>>(), [2, 4, 2]);
        let [first, second] = lines[0].points[..] else { panic!("two points") };
        assert_eq!((first.position, first.height_m), (dvec2(500_000.0, 6_800_000.0), Some(12.5)));
        assert_eq!(second.height_m, None);
    }

    #[test]
    fn without_a_crs_they_are_longitude_and_latitude() {
        let text = r#"{"type": "LineString", "coordinates": [[8.286, 61.512], [8.3, 61.5]]}"#;
        let lines = read(text, Some(32632)).unwrap();
        let expected = dvec2(462_006.373_691, 6_820_026.478_034);
        assert!((lines[0].points[0].position - expected).length() < 1e-3);
        let metres =
            r#"{"type": "LineString", "coordinates": [[462006, 6820026], [462007, 6820027]]}"#;
        assert!(read(metres, Some(32632)).unwrap_err().contains("\"crs\""));
        assert!(read(metres, None).is_ok());
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, cause) in [
            ("", "no GeoJSON"),
            ("{}", "\"type\" is missing"),
            (r#"{"type": "Circle"}"#, "Circle"),
            (r#"{"type": "Point", "coordinates": [1, 2]}"#, "holds no LineString"),
            (r#"{"type": "LineString", "coordinates": [[1, 2]]}"#, "holds no LineString"),
            (r#"{"type": "LineString", "coordinates": [[1, 2], ["a", 3]]}"#, "is no point"),
            (r#"{"type": "LineString", "coordinates": 7}"#, "no list"),
        ] {
            let error = read(text, None).unwrap_err();
            assert!(error.contains(cause) && error.contains("lines.geojson"), "{error}");
        }
    }
}
