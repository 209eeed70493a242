//! The contract of the renderer's encoding of places, on the CPU's twin of the shaders and on the GPU.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::convert::Infallible;

use glam::DVec3;
use terrain_core::CameraView;
use terrain_core::gpu::probe_depth;
use terrain_core::precision::depth::{DepthGrid, DepthKind};
use terrain_core::precision::encodings::{
    Contract, Encoding, EncodingErrors, SweepAxes, Verdict, decode_on_cpu, measure_encodings,
    spread, verdicts,
};
use terrain_core::precision::study::{StudyOptions, report_page, run_study, tables};
use terrain_tests::gpu;

fn on_cpu(axes: &SweepAxes) -> EncodingErrors {
    let decode = |_: &_, points: &[_]| Ok::<_, Infallible>(decode_on_cpu(points));
    measure_encodings(axes, decode).unwrap()
}

fn verdict(errors: &EncodingErrors, encoding: Encoding) -> Verdict {
    verdicts(errors, &Contract::SHIPPED).into_iter().find(|v| v.encoding == encoding).unwrap()
}

#[test]
fn the_shipped_encoding_keeps_the_contract_anywhere_on_earth() {
    let errors = on_cpu(&SweepAxes { points: 48, ..SweepAxes::full() });
    for encoding in Encoding::ALL {
        println!("{:?}", verdict(&errors, encoding));
    }
    let shipped = verdict(&errors, Encoding::Shipped);
    assert!(shipped.is_kept(), "{shipped:?}");
}

/// The contract is one that can be broken: the naive encodings break it, each where theory says.
#[test]
fn the_contract_tells_encodings_apart() {
    let errors = on_cpu(&SweepAxes::quick());
    assert!(!verdict(&errors, Encoding::AbsoluteFloat).holds[0]);
    assert!(!verdict(&errors, Encoding::AbsoluteFloat).holds[2]);
    assert!(!verdict(&errors, Encoding::FixedPoint).holds[0], "a unit is 4 cm on the Earth");
    assert!(!verdict(&errors, Encoding::FixedPoint).holds[2], "and several texels of level 24");
}

/// The last step of a vertex: the camera's matrix in f32, against f64, for a picture of 2160 rows.
#[test]
fn the_camera_s_matrix_keeps_a_point_within_a_sixteenth_of_a_pixel() {
    let mut worst_px = Vec::new();
    for fov_y_deg in [1.0, 10.0, 50.0, 90.0, 170.0] {
        let mut worst = 0.0_f64;
        for index in 0..20_000 {
            let part = |rate: f64| spread(index, rate);
            let view = CameraView {
                eye: DVec3::ZERO,
                heading_deg: 360.0 * part(0.618_034),
                pitch_deg: 180.0 * part(0.414_214) - 90.0,
                fov_y_deg,
                viewport_px: [3840, 2160],
            };
            let ray = view.ray_direction(3840.0 * part(0.732_051), 2160.0 * part(0.236_068));
            let relative = (ray * 10.0_f64.powf(7.0 * part(0.302_776))).as_vec3();
            let clip = view.clip_from_relative(0.1) * relative.extend(1.0);
            let drawn = [
                (f64::from(clip.x / clip.w) + 1.0) * 1920.0,
                (1.0 - f64::from(clip.y / clip.w)) * 1080.0,
            ];
            let exact = view.pixel_from_world(relative.as_dvec3()).unwrap();
            let off = (drawn[0] - exact[0]).hypot(drawn[1] - exact[1]);
            worst = worst.max(off);
        }
        worst_px.push((fov_y_deg, worst));
    }
    println!("pixels off after the camera's matrix, by field of view: {worst_px:.6?}");
    assert!(worst_px.iter().all(|(_, pixels)| *pixels < 0.0625), "{worst_px:?}");
}

/// The device's f32 is the CPU's: every number of every encoding, and the lookup's position, bit for bit.
/// An adapter that contracts or reorders may differ in the last steps; it must keep the contract all the
/// same.
#[test]
fn the_device_keeps_the_contract_and_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let study = run_study(Some(&gpu), &StudyOptions::quick(), &|_| ()).unwrap();
    let verdicts = study.encodings.gpu_verdicts.unwrap();
    let shipped = verdicts.iter().find(|v| v.encoding == Encoding::Shipped).unwrap();
    println!("on the device: {shipped:?}");
    assert!(shipped.is_kept(), "{shipped:?}");
    if gpu.is_software() {
        assert_eq!(study.encodings.positions_apart, 0);
        for twin in &study.encodings.twins {
            assert_eq!((twin.apart, twin.most_ulps), (0, 0), "{twin:?}");
        }
    }
}

#[test]
fn the_device_needs_the_bits_that_were_derived() {
    let Some(gpu) = gpu() else { return };
    let study = run_study(Some(&gpu), &StudyOptions::quick(), &|_| ()).unwrap();
    let mut compared = 0;
    for row in &study.spans {
        for tried in [row.gpu_f32, row.gpu_f64].into_iter().flatten() {
            let normal = f64::from(tried.normal_dot) - row.normal_dot_bits;
            let texture = f64::from(tried.texture) - row.texture_bits;
            assert!(normal.abs() <= 1.0 && texture.abs() <= 1.0, "{row:?}");
            compared += 1;
        }
    }
    assert!(compared >= study.spans.len(), "f32 is everywhere");
    for row in study.natives.iter().filter(|row| row.effective_bits.is_finite()) {
        let apart = row.effective_bits - f64::from(row.significant_bits);
        assert!(apart.abs() <= 1.0, "{row:?}");
    }
    let overflows = study.natives.iter().any(|row| row.measured_texels.is_infinite());
    let has_f16 = study.natives.iter().any(|row| row.significant_bits == 11);
    assert_eq!(overflows, has_f16, "only f16 overflows, at 256 heights");
}

/// Two surfaces a part in 2^21 of their distance apart, from the near plane to once round the Earth: half
/// a millimetre at a kilometre.
#[test]
fn the_device_tells_surfaces_apart_at_any_distance() {
    let Some(gpu) = gpu() else { return };
    let grid = DepthGrid::studied();
    let drawn = probe_depth(&gpu, DepthKind::ReverseFloat, &grid).unwrap();
    for (distance_m, gap_m) in grid.places_m().zip(grid.least_gaps_m(&drawn)) {
        assert!(gap_m <= distance_m * (-21.0_f64).exp2(), "{distance_m} m: {gap_m} m");
    }
    let usual = probe_depth(&gpu, DepthKind::UsualFloat, &grid).unwrap();
    let gaps = grid.least_gaps_m(&usual);
    let farthest = grid.places_m().zip(gaps).find(|(distance_m, _)| *distance_m > 1.0e5).unwrap();
    assert!(farthest.1 > 500.0, "the usual depth cannot: {farthest:?}");
}

#[test]
fn without_a_device_the_study_tells_what_the_cpu_can() {
    let study = run_study(None, &StudyOptions::quick(), &|_| ()).unwrap();
    assert!(study.adapter.is_none() && study.natives.is_empty() && study.floats.is_none());
    let page = report_page(&study, "a machine").unwrap();
    assert!(page.contains("No graphics adapter") && page.contains("<svg"));
    for table in tables(&study) {
        let csv = table.to_csv();
        let columns = csv.lines().map(|line| line.split(',').count());
        assert!(columns.clone().all(|count| count == table.header.len()), "{}", table.name);
        assert!(columns.count() > 1 || table.name == "native-floats", "{}", table.name);
    }
}
