use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use serde::Serialize;

use super::build::limit_for;
use super::dataset_ground::{node_heights_m, texture_window};
use super::file::{LimitFileHeader, LimitFileWriter};
use super::{
    ColourBuild, ConvergedQuadrature, DistanceSet, HeightPyramid, KnotBudget, KnotRule, LimitGrid,
    LimitMemory, LimitRelief, LimitSurfaceError, MipTexture,
};
use crate::dataset::TileSource;
use crate::progress::Progress;
use crate::tiling::Extent;

/// Name of the file of a dataset's limit-triangulated surface, in the dataset's folder.
pub const LIMIT_FILE: &str = "limit.surface";

/// The colour of ground without imagery: a middle grey, linear light.
pub const BARE_COLOUR: Vec3 = Vec3::splat(0.214);

/// How a limit-triangulated surface is made of a dataset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitRequest {
    /// The ground to take; all there is without.
    pub area: Option<Extent>,
    /// Apex angle of the cone, radians: the admissible angular error.
    pub admissible_angle_rad: f64,
    /// The part of that angle which a triangle spans from the least distance; within 0..=1.
    pub triangle_share: f64,
    /// The least distance D_min in metres; without, the one for which a triangle's short sides are a
    /// texel of the finest imagery.
    pub least_distance_m: Option<f64>,
    /// The farthest distance over the least.
    pub reach: f64,
    /// Distances in a doubling.
    pub per_doubling: u32,
    /// How many knots triangles keep.
    pub rule: KnotRule,
    /// Factor on all heights.
    pub vertical_exaggeration: f64,
}

impl Default for LimitRequest {
    /// For 16 rays a pixel in a picture 720 pixels high with a field of view of 50 degrees.
    fn default() -> Self {
        Self {
            area: None,
            admissible_angle_rad: 0.5 * 1.295e-3,
            triangle_share: 0.5,
            least_distance_m: None,
            reach: 32.0,
            per_doubling: 2,
            rule: KnotRule::ColourError(4.0),
            vertical_exaggeration: 1.0,
        }
    }
}

/// What was made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitPrepareSummary {
    /// What the file says of the surface.
    pub header: LimitFileHeader,
    /// What the surface takes in memory.
    pub memory: LimitMemory,
    /// Bytes of the file.
    pub file_bytes: u64,
}

/// Makes the limit-triangulated surface of a dataset and writes it to a file.
///
/// Bands of 64 rows of cells are read, integrated on all processors, reduced and written one after
/// another, so that memory does not grow with the area's height. Under a memory limit all is
/// integrated twice: the first time only to count. The file appears when it is whole.
///
/// # Errors
/// [`LimitSurfaceError`] where the settings make no surface, a tile cannot be read, the file cannot
/// be written, or `cancel` is set.
pub fn prepare_limit_surface(
    source: &dyn TileSource,
    request: &LimitRequest,
    path: &Path,
    progress: &dyn Progress,
    cancel: &AtomicBool,
) -> Result<LimitPrepareSummary, LimitSurfaceError> {
    let plan = Plan::new(source, request)?;
    let bands = Bands { source, request, plan: &plan, progress, cancel };
    let limit_steps = match request.rule {
        KnotRule::ColourError(limit_steps) => limit_steps,
        KnotRule::Memory(most_bytes) => limit_for(&bands.budget()?, most_bytes)?,
    };
    let header = LimitFileHeader {
        crs: source.manifest().crs.clone(),
        grid: plan.grid,
        distances_m: plan.distances.as_slice().to_vec(),
        admissible_angle_rad: request.admissible_angle_rad,
        vertical_exaggeration: request.vertical_exaggeration,
        limit_steps,
    };
    let mut writer = LimitFileWriter::create(path, &header)?;
    let memory = bands.write(limit_steps, &mut writer)?;
    let file_bytes = writer.finish()?;
    Ok(LimitPrepareSummary { header, memory, file_bytes })
}

struct Plan {
    grid: LimitGrid,
    distances: DistanceSet,
    /// Cells by which the largest footprint reaches beyond its triangle.
    halo: u32,
}

impl Plan {
    fn new(source: &dyn TileSource, request: &LimitRequest) -> Result<Self, LimitSurfaceError> {
        let wrong = |reason: &str| Err(LimitSurfaceError::Setting(reason.to_owned()));
        let manifest = source.manifest();
        let Some(colours) = &manifest.colours else {
            return wrong("the dataset has no imagery to take colours from");
        };
        if !(request.admissible_angle_rad > 0.0 && request.admissible_angle_rad < 1.0) {
            return wrong("the admissible angle must be above 0 and below 1 radian");
        }
        if !(request.triangle_share > 0.0 && request.triangle_share <= 1.0) {
            return wrong(
                "a triangle's part of the admissible angle must be above 0 and at most 1",
            );
        }
        let area = match request.area {
            None => manifest.data_extent,
            Some(area) => match area.intersection(&manifest.data_extent) {
                Some(common) => common,
                None => return wrong("the area lies beside the dataset's ground"),
            },
        };
        let triangle_angle_rad = request.admissible_angle_rad * request.triangle_share;
        let texel_m = colours.layout.texel_size_m(&manifest.scheme, colours.layout.finest_level());
        let least_m = request
            .least_distance_m
            .unwrap_or_else(|| LimitGrid::least_distance_m_for(texel_m, triangle_angle_rad));
        let cell_m = LimitGrid::cell_m_for(least_m, triangle_angle_rad);
        let grid = LimitGrid::over(&area, cell_m)?;
        let distances =
            DistanceSet::geometric(least_m, least_m * request.reach, request.per_doubling)?;
        let radius_m = distances.farthest_m() * (0.5 * request.admissible_angle_rad).tan();
        Ok(Self { grid, distances, halo: (radius_m / cell_m).ceil() as u32 + 1 })
    }
}

struct Bands<'a> {
    source: &'a dyn TileSource,
    request: &'a LimitRequest,
    plan: &'a Plan,
    progress: &'a dyn Progress,
    cancel: &'a AtomicBool,
}

/// Rows of cells made at a time.
const BAND_ROWS: u32 = 64;

impl Bands<'_> {
    fn budget(&self) -> Result<KnotBudget, LimitSurfaceError> {
        let mut budget = KnotBudget::default();
        for rows in self.bands() {
            let ground = self.ground(&rows)?;
            budget.add(&self.build(&ground, |build| build.budget(ground.own_rows.clone()))?);
            self.tell("count", &rows);
        }
        Ok(budget)
    }

    fn write(
        &self,
        limit_steps: f32,
        writer: &mut LimitFileWriter,
    ) -> Result<LimitMemory, LimitSurfaceError> {
        let (mut triangles, mut knots, mut colour_bytes) = (0, 0, 0);
        for rows in self.bands() {
            let ground = self.ground(&rows)?;
            let own = ground.own_rows.clone();
            let colours = self.build(&ground, |build| build.colours(own.clone(), limit_steps))?;
            // The row of nodes below a band is the first of the next.
            let last = u32::from(rows.end == self.plan.grid.rows);
            let band = ground.relief.grid();
            let nodes = band.node_index(own.start, 0)..band.node_index(own.end + last, 0);
            writer.add(rows.end - rows.start, &ground.relief.heights_m()[nodes], &colours)?;
            triangles += colours.triangle_count() as u64;
            knots += colours.knot_count() as u64;
            colour_bytes += colours.byte_len();
            self.tell("integrate", &rows);
        }
        let grid = &self.plan.grid;
        let shape_bytes = 4 * grid.node_count() as u64 + HeightPyramid::byte_len_of(grid);
        Ok(LimitMemory { triangles, knots, colour_bytes, shape_bytes })
    }

    fn bands(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        let rows = self.plan.grid.rows;
        (0..rows.div_ceil(BAND_ROWS))
            .map(move |band| band * BAND_ROWS..((band + 1) * BAND_ROWS).min(rows))
    }

    fn tell(&self, phase: &str, rows: &Range<u32>) {
        self.progress.advanced(phase, u64::from(rows.end), u64::from(self.plan.grid.rows));
    }

    /// The ground of a band with what its footprints reach beyond it.
    fn ground(&self, rows: &Range<u32>) -> Result<BandGround, LimitSurfaceError> {
        let (grid, halo) = (&self.plan.grid, self.plan.halo);
        let first = rows.start.saturating_sub(halo);
        let end = rows.end.saturating_add(halo).min(grid.rows);
        let band = LimitGrid { origin: grid.node(first, 0), rows: end - first, ..*grid };
        let exaggeration = self.request.vertical_exaggeration;
        let heights_m = node_heights_m(self.source, &band, 0..band.rows + 1, exaggeration)?;
        let seen = band.extent().grown(f64::from(halo) * grid.cell_m);
        let texture = texture_window(self.source, &seen)?;
        Ok(BandGround {
            relief: LimitRelief::new(band, heights_m)?,
            texture: texture.unwrap_or_else(|| {
                // A plan without imagery is refused; one grey texel stands for none.
                MipTexture::new(band.origin, grid.cell_m, [1, 1], vec![[0; 4]])
            }),
            own_rows: rows.start - first..rows.end - first,
        })
    }

    fn build<T>(
        &self,
        ground: &BandGround,
        each: impl FnOnce(&ColourBuild<'_>) -> Result<T, LimitSurfaceError>,
    ) -> Result<T, LimitSurfaceError> {
        let integral = ConvergedQuadrature {
            texture: &ground.texture,
            relief: &ground.relief,
            tolerance: 0.002,
            bare_colour: BARE_COLOUR,
        };
        each(&ColourBuild {
            relief: &ground.relief,
            distances: &self.plan.distances,
            admissible_angle_rad: self.request.admissible_angle_rad,
            integral: &integral,
            cancel: self.cancel,
        })
    }
}

struct BandGround {
    relief: LimitRelief,
    texture: MipTexture,
    /// The band's own rows among those of the relief.
    own_rows: Range<u32>,
}
