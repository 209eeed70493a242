//! The sweeps carried out: every point encoded, decoded and compared with the truth.

use glam::{DVec2, dvec2};
use serde::Serialize;

use super::{
    Decoded, EYE_FRACTIONS, EncodedLayer, EncodedPoint, Encoding, EncodingScene, GroundCell,
    PlaceCell, PointError, PositionCell, SweepAxes, SweepPoint, ground_points, pixel_angle_rad,
    place_points, position_points,
};
use crate::tiling::TilingScheme;

/// A root the length of the equator, in the scale of Web Mercator; its south-west corner is at 0, 0.
pub const EARTH: TilingScheme =
    TilingScheme { origin: dvec2(0.0, 40_075_016.685_578_49), root_size_m: 40_075_016.685_578_49 };

/// What every encoding makes of one point, in the order of [`Encoding::ALL`].
pub type DecodedEvery = [Decoded; Encoding::ALL.len()];

/// Worst error of an encoding in a cell of the sweep over positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PositionRow {
    /// The encoding.
    pub encoding: Encoding,
    /// The cell.
    pub cell: PositionCell,
    /// Metres.
    pub worst_m: f64,
    /// Parts of the footprint of a pixel across the direction of view.
    pub worst_pixels: f64,
}

/// Worst error of an encoding in a cell of the sweep over places in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlaceRow {
    /// The encoding.
    pub encoding: Encoding,
    /// The cell.
    pub cell: PlaceCell,
    /// Texels of the cell's level.
    pub worst_texels: f64,
}

/// Worst error of an encoding in a cell of the sweep over ground close to the eye.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroundRow {
    /// The encoding.
    pub encoding: Encoding,
    /// The cell.
    pub cell: GroundCell,
    /// Metres by which the heights' texels are shifted.
    pub shift_m: f64,
    /// What that does to the height of the steepest ground that such texels can hold, metres.
    pub height_m: f64,
}

/// Everything the sweeps measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EncodingErrors {
    /// A row an encoding and cell.
    pub positions: Vec<PositionRow>,
    /// A row an encoding and cell.
    pub places: Vec<PlaceRow>,
    /// A row an encoding and cell.
    pub grounds: Vec<GroundRow>,
    /// Points that were compared.
    pub points: usize,
}

/// The twin of the GPU's decoding.
pub fn decode_on_cpu(points: &[EncodedPoint]) -> Vec<DecodedEvery> {
    points.iter().map(|point| Encoding::ALL.map(|encoding| point.decode(encoding))).collect()
}

/// Runs the three sweeps over the Earth. `decode` is given all points of one eye at a time.
///
/// # Errors
/// What `decode` fails with.
pub fn measure_encodings<E>(
    axes: &SweepAxes,
    mut decode: impl FnMut(&EncodingScene, &[EncodedPoint]) -> Result<Vec<DecodedEvery>, E>,
) -> Result<EncodingErrors, E> {
    let mut errors = EncodingErrors::default();
    for magnitude_m in axes.magnitudes_m.iter().copied() {
        let eye = DVec2::splat(magnitude_m) + DVec2::from(EYE_FRACTIONS);
        let scene = EncodingScene::new(EARTH, EncodedLayer::IMAGERY, eye);

        let mut cells = Vec::new();
        let points = position_points(&scene, magnitude_m, axes, &mut cells);
        let worst = worst_of_cells(&scene, &points, cells.len(), &mut decode)?;
        errors.positions.extend(position_rows(&cells, &worst));
        errors.points += points.len();

        let mut cells = Vec::new();
        let points = place_points(&scene, magnitude_m, axes, &mut cells);
        let worst = worst_of_cells(&scene, &points, cells.len(), &mut decode)?;
        errors.places.extend(place_rows(&cells, &worst));
        errors.points += points.len();

        let scene = EncodingScene::new(EARTH, EncodedLayer::HEIGHTS, eye);
        let mut cells = Vec::new();
        let points = ground_points(&scene, magnitude_m, axes, &mut cells);
        let worst = worst_of_cells(&scene, &points, cells.len(), &mut decode)?;
        errors.grounds.extend(ground_rows(&cells, &worst));
        errors.points += points.len();
    }
    Ok(errors)
}

/// Worst errors of a cell, in the order of [`Encoding::ALL`].
type CellErrors = [PointError; Encoding::ALL.len()];

fn worst_of_cells<E>(
    scene: &EncodingScene,
    points: &[SweepPoint],
    cells: usize,
    decode: &mut impl FnMut(&EncodingScene, &[EncodedPoint]) -> Result<Vec<DecodedEvery>, E>,
) -> Result<Vec<CellErrors>, E> {
    let encoded = points
        .iter()
        .filter_map(|point| Some((*point, scene.encode(point.world, point.level)?)))
        .collect::<Vec<_>>();
    let raw = encoded.iter().map(|(_, encoded)| *encoded).collect::<Vec<_>>();
    let mut worst = vec![CellErrors::default(); cells];
    for ((point, encoded), decoded) in encoded.iter().zip(decode(scene, &raw)?) {
        for (index, encoding) in Encoding::ALL.into_iter().enumerate() {
            let place = (point.world, point.level);
            let error = scene.error(encoding, place, encoded, &decoded[index]);
            let cell = &mut worst[point.cell][index];
            cell.position_m = cell.position_m.max(error.position_m);
            cell.place_texels = cell.place_texels.max(error.place_texels);
        }
    }
    Ok(worst)
}

fn position_rows(cells: &[PositionCell], worst: &[CellErrors]) -> Vec<PositionRow> {
    let rows = cells.iter().zip(worst).flat_map(|(cell, errors)| {
        Encoding::ALL.into_iter().zip(errors).map(|(encoding, error)| PositionRow {
            encoding,
            cell: *cell,
            worst_m: error.position_m,
            worst_pixels: error.position_m / (cell.distance_m * pixel_angle_rad(cell.fov_deg)),
        })
    });
    rows.collect()
}

fn place_rows(cells: &[PlaceCell], worst: &[CellErrors]) -> Vec<PlaceRow> {
    let rows = cells.iter().zip(worst).flat_map(|(cell, errors)| {
        Encoding::ALL.into_iter().zip(errors).map(|(encoding, error)| PlaceRow {
            encoding,
            cell: *cell,
            worst_texels: error.place_texels,
        })
    });
    rows.collect()
}

/// Metres by which no mountain exceeds the ground about it.
const RELIEF_M: f64 = 9_000.0;

fn ground_rows(cells: &[GroundCell], worst: &[CellErrors]) -> Vec<GroundRow> {
    let rows = cells.iter().zip(worst).flat_map(|(cell, errors)| {
        // No slope between texels' centres is steeper than 1, nor than a mountain across one.
        let steepest = (RELIEF_M / cell.texel_m).min(1.0);
        Encoding::ALL.into_iter().zip(errors).map(move |(encoding, error)| {
            let shift_m = error.place_texels * cell.texel_m;
            GroundRow { encoding, cell: *cell, shift_m, height_m: shift_m * steepest }
        })
    });
    rows.collect()
}
