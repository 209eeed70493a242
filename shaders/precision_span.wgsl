// Tries a number of bits for the dot products behind a texture coordinate at every phase of the
// rounding grid, as terrain-core/src/precision/span/brute_force.rs does on the CPU.
// needs: common/real_f32.wgsl

const PHASES: u32 = 16u;

struct Trial {
    // Ground distance over height.
    range: f32,
    half_pixel_rad: f32,
    texel_part: f32,
    bits: u32,
}

// The worst of all phases, each over its bound: up to 1 the bits suffice.
struct Outcome {
    moved: f32,
    level: f32,
    texture: f32,
}

@group(2) @binding(0) var<storage, read> trials: array<Trial>;
@group(2) @binding(1) var<storage, read_write> outcomes: array<Outcome>;

// Large enough to fail every bound, small enough for every float.
const FAILED: f32 = 1.0e4;

fn quantised(value: real, steps_to_one: real, phase: real) -> real {
    return (round(value * steps_to_one + phase) - phase) / steps_to_one;
}

@compute @workgroup_size(64)
fn try_bits(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&trials) {
        return;
    }
    let trial = trials[id.x];
    let one = real(1.0);
    let range = real(trial.range);
    let slant_square = one + range * range;
    let normal = one / sqrt(slant_square);
    let axis = range * normal;
    let footprint = real(2.0) * real(trial.half_pixel_rad) * slant_square;
    let texel = real(trial.texel_part) * footprint;
    let steps_to_one = real(f32(1u << (trial.bits - 1u)));
    var worst = Outcome(0.0, 0.0, 0.0);
    for (var i = 0u; i < PHASES; i++) {
        let rounded = quantised(normal, steps_to_one, real(f32(i) / f32(PHASES)));
        if rounded <= real(0.0) {
            worst = Outcome(FAILED, FAILED, FAILED);
            break;
        }
        let moved = abs(axis / rounded - range) / (real(0.5) * footprint);
        let ratio = normal / rounded;
        worst.moved = max(worst.moved, f32(moved));
        // 2 |log2(ratio)| over half a level.
        worst.level = max(worst.level, 4.0 * abs(log2(f32(ratio))));
        for (var j = 0u; j < PHASES; j++) {
            let rounded_axis = quantised(axis, steps_to_one, real(f32(j) / f32(PHASES)));
            worst.texture = max(worst.texture, f32(abs(rounded_axis / rounded - range) / texel));
        }
    }
    outcomes[id.x] = worst;
}
