// Heights as they are stored and sent, and the slopes between them.

const NO_DATA_M: f32 = -1.0e30;
const NO_DATA_WORD: u32 = 65535u;
// Floats larger than this are no heights.
const MOST_HEIGHT_M: f32 = 1.0e6;
// The steepest slope a half float holds, and a cliff by any measure.
const STEEPEST: f32 = 65504.0;

// The samples sent in a frame, those of each tile or part of one from a whole word on.
@group(0) @binding(1) var<storage, read> payload: array<u32>;

struct StoredSamples {
    // Index of the first u32 in the payload.
    first_word: u32,
    // 1: float32 samples; 0: 16-bit steps, two a u32, low half first.
    is_float: u32,
    base_steps: i32,
    step_m: f32,
}

// Height of a sample in metres, or NO_DATA_M.
fn stored_height(samples: StoredSamples, index: u32) -> f32 {
    if samples.is_float != 0u {
        let bits = payload[samples.first_word + index];
        // Compared as bits, which order floats by size and put NaN last: NaN comparisons may be optimised away.
        let is_height = (bits & 0x7fffffffu) <= bitcast<u32>(MOST_HEIGHT_M);
        return select(NO_DATA_M, bitcast<f32>(bits), is_height);
    }
    let pair = payload[samples.first_word + index / 2u];
    let word = (pair >> ((index & 1u) * 16u)) & 0xffffu;
    return select(f32(samples.base_steps + i32(word)) * samples.step_m, NO_DATA_M, word == NO_DATA_WORD);
}

// Half the difference of the two neighbours over the texel size, or of one neighbour where the other
// holds no data or is not known.
fn slope_along(centre_m: f32, before_m: f32, after_m: f32, texel_size_m: f32) -> f32 {
    let has_before = before_m > NO_DATA_M;
    let has_after = after_m > NO_DATA_M;
    let low = select(centre_m, before_m, has_before);
    let high = select(centre_m, after_m, has_after);
    let steps = f32(has_before) + f32(has_after);
    return clamp((high - low) / (max(steps, 1.0) * texel_size_m), -STEEPEST, STEEPEST);
}
