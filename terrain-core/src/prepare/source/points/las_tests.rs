//! LAS and LAZ files written, read back and damaged.

use std::path::{Path, PathBuf};

use las::point::{Classification, Format};
use las::{Builder, Header, Point, Transform, Vector, Vlr, Writer};

use super::las_file::read;

/// Where a file's records say it lies.
enum Place {
    Nowhere,
    Keys(u16),
    Text(&'static str),
}

fn header(format: u8, compressed: bool, place: &Place) -> Header {
    let mut builder = Builder::from((1, 4));
    builder.point_format = Format::new(format).unwrap();
    builder.point_format.is_compressed = compressed;
    let axis = |offset: f64| Transform { scale: 0.01, offset };
    builder.transforms = Vector { x: axis(1_800_000.0), y: axis(5_900_000.0), z: axis(0.0) };
    let record = |record_id: u16, data: Vec<u8>| Vlr {
        user_id: "LASF_Projection".to_owned(),
        record_id,
        data,
        ..Vlr::default()
    };
    match place {
        Place::Nowhere => {}
        Place::Keys(epsg) => {
            let keys = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, *epsg];
            let bytes = keys.iter().flat_map(|key: &u16| key.to_le_bytes()).collect();
            builder.vlrs.push(record(34735, bytes));
        }
        Place::Text(text) => {
            builder.has_wkt_crs = true;
            builder.vlrs.push(record(2112, text.as_bytes().to_vec()));
        }
    }
    builder.into_header().unwrap()
}

/// Points on a line, of class 1, 2, 5, 1, 2, 5, ..; every tenth one withheld.
fn write(path: &Path, count: u32, header: Header) {
    let mut writer = Writer::from_path(path, header).unwrap();
    for index in 0..count {
        let point = Point {
            x: 1_800_000.25 + f64::from(index),
            y: 5_900_000.5,
            z: 10.0 + 0.25 * f64::from(index),
            classification: Classification::new([1, 2, 5][index as usize % 3]).unwrap(),
            is_withheld: index % 10 == 9,
            return_number: 1,
            number_of_returns: 1,
            gps_time: Some(0.0).filter(|_| writer.header().point_format().has_gps_time),
            ..Point::default()
        };
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
}

fn file(folder: &tempfile::TempDir, name: &str) -> PathBuf {
    folder.path().join(name)
}

#[test]
fn classes_are_chosen_and_withheld_points_left_out() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format, compressed) in
        [("a.las", 0, false), ("b.laz", 1, true), ("c.las", 6, false), ("d.laz", 6, true)]
    {
        let path = file(&folder, name);
        write(&path, 300, header(format, compressed, &Place::Keys(32632)));
        let ground = read(&path, &[]).unwrap();
        // 100 of each class, 10 of those withheld.
        assert_eq!((ground.points.len(), ground.epsg), (90, Some(32632)), "{name}");
        let [x, y, z] = ground.points[0];
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(x, 1_800_001.25) && near(y, 5_900_000.5) && near(z, 10.25), "{name}");
        assert!(ground.note.contains("90 of 270 points, those of class 2"), "{}", ground.note);
        assert_eq!(read(&path, &[5, 1]).unwrap().points.len(), 180);
        let error = read(&path, &[6]).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("class 6; it has 1 (90 points)"), "{error}");
    }
}

#[test]
fn without_ground_all_points_are_taken_and_without_points_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "one.las");
    write(&path, 1, header(0, false, &Place::Nowhere));
    let cloud = read(&path, &[]).unwrap();
    assert_eq!((cloud.points.len(), cloud.epsg), (1, None));
    assert!(cloud.note.contains("none is ground"), "{}", cloud.note);
    for compressed in [false, true] {
        let path = file(&folder, "none.laz");
        write(&path, 0, header(0, compressed, &Place::Nowhere));
        let error = read(&path, &[]).unwrap_err().to_string();
        assert!(error.contains("none.laz: holds no points"), "{error}");
    }
}

#[test]
fn the_crs_is_that_of_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "text.las");
    let text = r#"PROJCS["UTM",GEOGCS["w",AUTHORITY["EPSG","4326"]],AUTHORITY["EPSG","32632"]]"#;
    write(&path, 4, header(6, false, &Place::Text(text)));
    assert_eq!(read(&path, &[]).unwrap().epsg, Some(32632));
}

#[test]
fn damaged_files_are_errors_or_other_points_but_never_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    for (name, format, compressed) in [("a.las", 1, false), ("b.laz", 1, true), ("c.laz", 6, true)]
    {
        let path = file(&folder, name);
        write(&path, 60, header(format, compressed, &Place::Keys(32632)));
        let whole = std::fs::read(&path).unwrap();
        let points_at = u32::from_le_bytes(whole[96..100].try_into().unwrap()) as usize;
        let mut refused = 0;
        for at in (0..whole.len()).step_by(if compressed { 11 } else { 5 }) {
            std::fs::write(&path, &whole[..at]).unwrap();
            refused += u32::from(read(&path, &[]).is_err());
            // Among the points a size of 4 GiB is believed, and costs seconds before it is refused.
            let largest = if at < points_at { 0xff } else { whole[at] ^ 0x04 };
            for value in [0x00, largest, whole[at] ^ 0x01] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                std::fs::write(&path, &damaged).unwrap();
                refused += u32::from(read(&path, &[]).is_err());
            }
        }
        assert!(refused > 60, "{name}: {refused}");
    }
}
