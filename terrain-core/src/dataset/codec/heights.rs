use super::linear_predictor::{TAPS, Weights, fit, predict};
use super::{DamagedPayload, PayloadHeader, PayloadKind, deflate_mask, inflate_mask};
use crate::dataset::{HeightRange, HeightSamples, HeightTile};
use crate::tiling::TileId;

/// Marks a sample without data among steps.
pub const NO_DATA_STEPS: i32 = i32::MIN;

/// Range of steps that 16-bit words can hold beside the word for "no data".
const WORD_RANGE: i32 = 65534;

/// Steps beyond this are not exact in f32.
pub const EXACT_STEPS: i32 = 1 << 24;

/// Encodes a square of heights in steps of `step_m` metres; [`NO_DATA_STEPS`] where there is none.
/// Steps stay within [`EXACT_STEPS`] of 0.
pub fn encode_height_steps(steps: &[i32], size_texels: u32, step_m: f32) -> Vec<u8> {
    let size = size_texels as usize;
    let held = || steps.iter().filter(|&&step| step != NO_DATA_STEPS);
    let range = held()
        .min()
        .zip(held().max())
        .map(|(&min, &max)| HeightRange { min_m: min as f32 * step_m, max_m: max as f32 * step_m });
    let missing = steps.contains(&NO_DATA_STEPS);
    // Heights that came as whole metres, say, are multiples of many steps: their zero bits go first,
    // or the predictor would fill them with noise.
    let shift = held().fold(0, |bits, &step| bits | step).trailing_zeros() % 32;
    let filled = carry_forward(steps, shift);
    let weights = fit(&filled, size);
    let residuals: Vec<i32> = (0..filled.len())
        .map(|index| {
            if steps[index] == NO_DATA_STEPS {
                return 0;
            }
            filled[index].wrapping_sub(predict(&filled, index, size, &weights))
        })
        .collect();
    let mask = missing.then(|| deflate_mask(steps.iter().map(|&step| step == NO_DATA_STEPS)));
    let mut body = step_m.to_le_bytes().to_vec();
    body.push(shift as u8);
    body.extend(weights.iter().flat_map(|weight| weight.to_le_bytes()));
    append_mask(&mut body, mask.as_deref());
    body.extend(compress(&residuals));
    let kind = PayloadKind::HeightSteps;
    PayloadHeader { kind, stored_size_texels: size as u16, range }.seal(&body)
}

/// Encodes a square of heights in metres without loss; NaN where there is none.
pub fn encode_heights_m(heights_m: &[f32], size_texels: u32) -> Vec<u8> {
    let held = || heights_m.iter().copied().filter(|height| !height.is_nan());
    let range = held().reduce(f32::min).zip(held().reduce(f32::max));
    let range = range.map(|(min_m, max_m)| HeightRange { min_m, max_m });
    let mask = heights_m
        .iter()
        .any(|height| height.is_nan())
        .then(|| deflate_mask(heights_m.iter().map(|height| height.is_nan())));
    let mut last = 0.0;
    let filled: Vec<f32> = heights_m
        .iter()
        .map(|&height| {
            last = if height.is_nan() { last } else { height };
            last
        })
        .collect();
    let mut body = Vec::new();
    append_mask(&mut body, mask.as_deref());
    body.extend(compress(&filled));
    let kind = PayloadKind::HeightMetres;
    PayloadHeader { kind, stored_size_texels: size_texels as u16, range }.seal(&body)
}

/// Decodes either form into a tile of `size_texels` a side.
pub fn decode_heights(
    payload: &[u8],
    id: TileId,
    size_texels: u32,
) -> Result<HeightTile, DamagedPayload> {
    let (header, body) = PayloadHeader::open(payload)?;
    if u32::from(header.stored_size_texels) != size_texels {
        let size = header.stored_size_texels;
        return Err(DamagedPayload::new(format!("{size} texels a side, not {size_texels}")));
    }
    let samples = match header.kind {
        PayloadKind::HeightSteps => decode_steps(body, size_texels as usize)?,
        PayloadKind::HeightMetres => decode_metres(body, size_texels as usize)?,
        other => return Err(DamagedPayload::new(format!("{other:?} is no height tile"))),
    };
    Ok(HeightTile { id, stored_size_texels: size_texels, samples, range: header.range })
}

fn decode_steps(body: &[u8], size: usize) -> Result<HeightSamples, DamagedPayload> {
    const PARAMETERS: usize = 5 + 2 * TAPS;
    let cut = || DamagedPayload::new("the body is cut short");
    let (parameters, rest) = body.split_at_checked(PARAMETERS).ok_or_else(cut)?;
    let step_m = f32::from_le_bytes([parameters[0], parameters[1], parameters[2], parameters[3]]);
    let mut weights: Weights = [0; TAPS];
    for (weight, bytes) in weights.iter_mut().zip(parameters[5..].chunks_exact(2)) {
        *weight = i16::from_le_bytes([bytes[0], bytes[1]]);
    }
    let (mask, compressed) = split_mask(rest, size * size)?;
    let mut steps = decompress::<i32>(compressed, size * size)?;
    restore(&mut steps, mask.as_deref(), size, &weights);
    let shift = parameters[4];
    for step in &mut steps {
        let shifted = i64::from(*step) << shift.min(31);
        *step = i32::try_from(shifted)
            .ok()
            .filter(|step| step.abs() < EXACT_STEPS)
            .ok_or_else(|| DamagedPayload::new(format!("a height of {shifted} steps")))?;
    }
    Ok(samples_of_steps(&steps, mask.as_deref(), step_m))
}

/// Turns residuals into steps in place. Samples without data hold what the encoder carried forward,
/// so that both sides predict from the same values.
fn restore(values: &mut [i32], mask: Option<&[bool]>, size: usize, weights: &Weights) {
    let mut last = 0;
    for index in 0..values.len() {
        if mask.is_some_and(|mask| mask[index]) {
            values[index] = last;
        } else {
            values[index] = values[index].wrapping_add(predict(values, index, size, weights));
            last = values[index];
        }
    }
}

fn samples_of_steps(steps: &[i32], mask: Option<&[bool]>, step_m: f32) -> HeightSamples {
    let is_held = |index: &usize| mask.is_none_or(|mask| !mask[*index]);
    let held = || (0..steps.len()).filter(is_held).map(|index| steps[index]);
    let base_steps = held().min().unwrap_or(0);
    let top_steps = held().max().unwrap_or(0);
    if top_steps.wrapping_sub(base_steps) <= WORD_RANGE {
        let word = |index: usize| match is_held(&index) {
            true => (steps[index] - base_steps) as u16,
            false => HeightSamples::NO_DATA_WORD,
        };
        HeightSamples::Steps { base_steps, step_m, words: (0..steps.len()).map(word).collect() }
    } else {
        let metres = |index: usize| match is_held(&index) {
            true => steps[index] as f32 * step_m,
            false => f32::NAN,
        };
        HeightSamples::Metres((0..steps.len()).map(metres).collect())
    }
}

fn decode_metres(body: &[u8], size: usize) -> Result<HeightSamples, DamagedPayload> {
    let (mask, compressed) = split_mask(body, size * size)?;
    let mut heights_m = decompress::<f32>(compressed, size * size)?;
    for (height, missing) in heights_m.iter_mut().zip(mask.into_iter().flatten()) {
        if missing {
            *height = f32::NAN;
        }
    }
    Ok(HeightSamples::Metres(heights_m))
}

/// The steps without their `shift` lowest bits. Samples without data take the value of the last one
/// with data before them (0 before the first).
fn carry_forward(steps: &[i32], shift: u32) -> Vec<i32> {
    let mut last = 0;
    steps
        .iter()
        .map(|&step| {
            last = if step == NO_DATA_STEPS { last } else { step >> shift };
            last
        })
        .collect()
}

fn append_mask(body: &mut Vec<u8>, mask: Option<&[u8]>) {
    let mask = mask.unwrap_or_default();
    body.extend((mask.len() as u32).to_le_bytes());
    body.extend(mask);
}

/// The mask at the start of the bytes (`None` where every sample holds data), and what follows it.
fn split_mask(bytes: &[u8], count: usize) -> Result<(Option<Vec<bool>>, &[u8]), DamagedPayload> {
    let cut = || DamagedPayload::new("the coverage is cut short");
    let (length, rest) = bytes.split_first_chunk::<4>().ok_or_else(cut)?;
    let length = u32::from_le_bytes(*length) as usize;
    let (mask, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
    let mask = if length == 0 { None } else { Some(inflate_mask(mask, count)?) };
    Ok((mask, rest))
}

fn compress<T: pco::data_types::Number>(values: &[T]) -> Vec<u8> {
    // The configuration is the default one, which is valid, and the target is a vector.
    pco::standalone::simple_compress(values, &pco::ChunkConfig::default()).unwrap_or_default()
}

fn decompress<T: pco::data_types::Number + Default>(
    bytes: &[u8],
    count: usize,
) -> Result<Vec<T>, DamagedPayload> {
    let mut values = vec![T::default(); count];
    let progress = pco::standalone::simple_decompress_into(bytes, &mut values)
        .map_err(|error| DamagedPayload::new(error.to_string()))?;
    if progress.n_processed == count && progress.finished {
        Ok(values)
    } else {
        Err(DamagedPayload::new(format!("{} of {count} samples", progress.n_processed)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn hills(size: usize, amplitude: f64, seed: u32) -> Vec<i32> {
        let phase = f64::from(seed);
        (0..size * size)
            .map(|index| {
                let (row, column) = ((index / size) as f64, (index % size) as f64);
                let wave = (0.11 * row + phase).sin() + (0.07 * column - 0.03 * row).cos();
                (amplitude * wave) as i32 + (index * 7919 % 5) as i32
            })
            .collect()
    }

    fn decoded_steps(tile: &HeightTile, step_m: f32) -> Vec<i32> {
        (0..(tile.stored_size_texels * tile.stored_size_texels) as usize)
            .map(|index| {
                tile.samples.height_m(index).map_or(NO_DATA_STEPS, |h| (h / step_m) as i32)
            })
            .collect()
    }

    #[test]
    fn steps_come_back_exactly_narrow_and_wide() {
        for amplitude in [0.0, 300.0, 20_000.0, 2.0e6] {
            let steps = hills(24, amplitude, 3);
            let payload = encode_height_steps(&steps, 24, 0.25);
            let tile = decode_heights(&payload, TileId::ROOT, 24).unwrap();
            assert_eq!(decoded_steps(&tile, 0.25), steps, "amplitude {amplitude}");
            let wide = matches!(tile.samples, HeightSamples::Metres(_));
            assert_eq!(wide, amplitude > 1e5);
        }
    }

    #[test]
    fn whole_metres_cost_no_more_for_a_finer_step() {
        let metres = hills(136, 500.0, 2);
        let eighths: Vec<i32> = metres.iter().map(|height| 8 * height).collect();
        let coarse = encode_height_steps(&metres, 136, 1.0).len();
        assert_eq!(encode_height_steps(&eighths, 136, 0.125).len(), coarse);
    }

    #[test]
    fn smooth_terrain_takes_less_than_a_byte_a_sample() {
        let steps = hills(136, 4_000.0, 1);
        let payload = encode_height_steps(&steps, 136, 0.25);
        assert!(payload.len() < steps.len() / 2, "{} bytes", payload.len());
    }

    proptest! {
        #[test]
        fn any_steps_and_any_gaps_come_back(
            values in prop::collection::vec(prop::option::weighted(0.8, -4_000_000..4_000_000_i32), 64)
        ) {
            let steps: Vec<i32> = values.iter().map(|v| v.unwrap_or(NO_DATA_STEPS)).collect();
            let payload = encode_height_steps(&steps, 8, 0.125);
            let tile = decode_heights(&payload, TileId::ROOT, 8).unwrap();
            prop_assert_eq!(decoded_steps(&tile, 0.125), steps);
            let held: Vec<i32> = values.iter().flatten().copied().collect();
            prop_assert_eq!(tile.range.map(|r| (8.0 * r.min_m) as i32), held.iter().min().copied());
        }

        #[test]
        fn any_metres_come_back(
            values in prop::collection::vec(prop::option::weighted(0.8, -1.0e4..9.0e3_f32), 64)
        ) {
            let heights_m: Vec<f32> = values.iter().map(|v| v.unwrap_or(f32::NAN)).collect();
            let payload = encode_heights_m(&heights_m, 8);
            let tile = decode_heights(&payload, TileId::ROOT, 8).unwrap();
            for (index, value) in values.iter().enumerate() {
                prop_assert_eq!(tile.samples.height_m(index), *value);
            }
        }

        #[test]
        fn damaged_bytes_never_panic(seed in 0_u32..50, at in 0_usize..400, to in 0_u8..255) {
            let steps = hills(16, 900.0, seed);
            let mut payload = encode_height_steps(&steps, 16, 1.0);
            let length = payload.len();
            payload[at % length] = to;
            let _ = decode_heights(&payload, TileId::ROOT, 16);
            let _ = decode_steps(&payload[PayloadHeader::LEN..], 16);
        }
    }
}
