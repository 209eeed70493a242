use super::texel_grid::{TexelGrid, TexelWindow};
use crate::synth::noise::{derived_seed, gradient_noise_3d};

/// Red, green and blue in linear light, and how rough the imagery is about here, all 0..=1.
pub type DetailTexel = [f32; 4];

/// Which part of a texel is roughness.
pub const ROUGHNESS: usize = 3;

/// Texels that a level's patch reaches beyond those over the next finer one.
pub const MARGIN: i64 = 2;

/// Cells of the lattice that a level's noise is made on, along a texel of the level: its waves are then mostly two to
/// four texels long, too fine for the level above it.
const CELLS_A_TEXEL: f64 = 1.0 / 1.73;
/// Makes the noise of an octave about 1 in the mean square.
const NOISE_GAIN: f32 = 4.3;
/// How strong the first octave of noise is, in parts of the light and of the roughness, and each further one in parts
/// of that before it.
const STRENGTH: f32 = 0.4;
const PERSISTENCE: f32 = 0.8;

/// A part of a level of imagery in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct DetailPatch {
    /// Which texels.
    pub window: TexelWindow,
    /// Row by row.
    pub texels: Vec<DetailTexel>,
}

/// A level that imagery is continued to.
pub struct DetailLevel {
    /// All its texels.
    pub grid: TexelGrid,
    /// Levels below the real imagery, at least 1.
    pub depth: u8,
    /// What its noise is made of.
    pub seed: u32,
}

impl DetailPatch {
    /// The texels of a window of the next finer level: this level's interpolated, and an octave of noise.
    ///
    /// 1. *Interpolation* is that of averages: of the quartics through the averages of five texels in a row, the
    ///    averages over the halves of the middle one (D. Donoho, "Smooth Wavelet Decompositions with Blocky
    ///    Coefficient Kernels", 1993), along rows and then along columns.
    /// 2. *Noise* is gradient noise at the texels' positions in space, less its mean over the four texels under one of
    ///    this level, times the light and the roughness there.
    /// 3. What the four texels differ by from this level's is scaled down, all four alike, until they are within
    ///    0..=1.
    ///
    /// So the mean of the four is this level's texel at every step. Mirrored windows come out mirrored to the bit.
    #[must_use]
    pub fn finer(&self, window: TexelWindow, level: &DetailLevel) -> Self {
        let parents = window.coarser(0);
        let fields = Slopes::of(self, parents);
        let children = TexelWindow {
            column: 2 * parents.column,
            row: 2 * parents.row,
            width: 2 * parents.width,
            height: 2 * parents.height,
        };
        let noise = octave_noise(children, level);
        let strength = STRENGTH * PERSISTENCE.powi(i32::from(level.depth) - 1);
        let mut texels = vec![DetailTexel::default(); window.len()];
        let skipped = [window.column - children.column, window.row - children.row];
        for row in 0..parents.height {
            for column in 0..parents.width {
                let quad = [0, 1].map(|down| {
                    let at = (2 * row + down) * children.width + 2 * column;
                    [noise[at], noise[at + 1]]
                });
                let texel = self.texel(parents, column, row);
                let [east, south, both] = fields.at(column, row);
                let four = divided(texel, [east, south, both], centred(quad), strength);
                for (down, line) in four.iter().enumerate() {
                    for (right, child) in line.iter().enumerate() {
                        let x = (2 * column + right) as i64 - skipped[0];
                        let y = (2 * row + down) as i64 - skipped[1];
                        let is_inside = (0..window.width as i64).contains(&x)
                            && (0..window.height as i64).contains(&y);
                        if is_inside {
                            texels[y as usize * window.width + x as usize] = *child;
                        }
                    }
                }
            }
        }
        Self { window, texels }
    }

    /// The texel at a column and row counted from those of another window.
    fn texel(&self, from: TexelWindow, column: usize, row: usize) -> &DetailTexel {
        let x = (from.column - self.window.column) as usize + column;
        let y = (from.row - self.window.row) as usize + row;
        &self.texels[y * self.window.width + x]
    }
}

/// Half of what the averages over a texel's halves differ by, to the east, to the south and to both.
struct Slopes {
    width: usize,
    slopes: Vec<[DetailTexel; 3]>,
}

impl Slopes {
    /// Of a window of the patch that leaves [`MARGIN`] texels round it.
    fn of(patch: &DetailPatch, window: TexelWindow) -> Self {
        let margin = MARGIN as usize;
        let tall =
            TexelWindow { row: window.row - MARGIN, height: window.height + 2 * margin, ..window };
        let wide = TexelWindow { column: tall.column - MARGIN, ..tall };
        let east: Vec<DetailTexel> = (0..tall.len())
            .map(|index| {
                let (column, row) = (index % tall.width, index / tall.width);
                slope([0, 1, 3, 4].map(|tap| patch.texel(wide, column + tap, row)))
            })
            .collect();
        let slopes = (0..window.len())
            .map(|index| {
                let (column, row) = (index % window.width, index / window.width);
                let taps = [0, 1, 3, 4];
                let south = slope(taps.map(|tap| patch.texel(tall, column, row + tap)));
                let both = slope(taps.map(|tap| &east[(row + tap) * tall.width + column]));
                [east[(row + margin) * tall.width + column], south, both]
            })
            .collect();
        Self { width: window.width, slopes }
    }

    fn at(&self, column: usize, row: usize) -> [DetailTexel; 3] {
        self.slopes[row * self.width + column]
    }
}

/// What the average over a texel's farther half is above the texel's own, from the two texels before it and the two
/// after it.
fn slope([a, b, d, e]: [&DetailTexel; 4]) -> DetailTexel {
    std::array::from_fn(|part| {
        (22.0 * (d[part] - b[part]) - 3.0 * (e[part] - a[part])) * (1.0 / 128.0)
    })
}

/// Noise at a window's texels, row by row.
fn octave_noise(window: TexelWindow, level: &DetailLevel) -> Vec<f32> {
    let positions = level.grid.positions(window);
    let seed = derived_seed(level.seed, u32::from(level.depth));
    let mut noise = Vec::with_capacity(window.len());
    for row in 0..window.height {
        let places = positions.row(row);
        noise.extend(places.map(|place| gradient_noise_3d(place * CELLS_A_TEXEL, seed)));
    }
    noise
}

/// The noise of the four texels under one, less its mean.
fn centred(quad: [[f32; 2]; 2]) -> [[f32; 2]; 2] {
    let mean = 0.25 * ((quad[0][0] + quad[0][1]) + (quad[1][0] + quad[1][1]));
    quad.map(|line| line.map(|noise| NOISE_GAIN * (noise - mean)))
}

/// The four texels under one, by rows. Colours are scaled alike in all parts, so that none turns to another.
fn divided(
    texel: &DetailTexel,
    slopes: [DetailTexel; 3],
    noise: [[f32; 2]; 2],
    strength: f32,
) -> [[DetailTexel; 2]; 2] {
    let noise_here = strength * texel[ROUGHNESS];
    let steps: [_; 4] = std::array::from_fn(|part| {
        // Roughness itself has none.
        let noise_here = if part == ROUGHNESS { 0.0 } else { noise_here * texel[part] };
        steps_of(slopes.map(|slope| slope[part]), noise, noise_here)
    });
    let rooms: [f32; 4] = std::array::from_fn(|part| room(texel[part], &steps[part]));
    let colour_room = rooms[..ROUGHNESS].iter().copied().fold(1.0, f32::min);
    let mut four = [[*texel; 2]; 2];
    for (part, steps) in steps.iter().enumerate() {
        let scale = if part == ROUGHNESS { rooms[part] } else { colour_room };
        for (line, steps) in four.iter_mut().zip(steps) {
            for (child, step) in line.iter_mut().zip(steps) {
                child[part] = texel[part] + scale * step;
            }
        }
    }
    four
}

/// What the four texels under one are above it, by rows.
fn steps_of([east, south, both]: [f32; 3], noise: [[f32; 2]; 2], noise_here: f32) -> [[f32; 2]; 2] {
    let step = |x: f32, y: f32, noise: f32| x * east + y * (south + x * both) + noise_here * noise;
    [
        [step(-1.0, -1.0, noise[0][0]), step(1.0, -1.0, noise[0][1])],
        [step(-1.0, 1.0, noise[1][0]), step(1.0, 1.0, noise[1][1])],
    ]
}

/// How much of the steps from a value can be gone within 0..=1, at the most all of them.
fn room(value: f32, steps: &[[f32; 2]; 2]) -> f32 {
    let (mut least, mut most) = (0.0_f32, 0.0_f32);
    for step in steps.as_flattened() {
        least = least.min(*step);
        most = most.max(*step);
    }
    let below = if least < -value { value / -least } else { 1.0 };
    let above = if most > 1.0 - value { (1.0 - value) / most } else { 1.0 };
    below.min(above)
}
