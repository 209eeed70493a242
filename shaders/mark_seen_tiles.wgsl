// Marks the tiles that pixels of the coordinate image saw. The twin is `SeenTiles` in the library, tile
// for tile; what counts as seen is told there.
// needs: common/whole_numbers.wgsl common/selection.wgsl common/seen_ground.wgsl common/coordinate_image.wgsl

// No tile is finer.
const FINEST_LEVEL: u32 = 24u;
// Ground between neighbouring pixels counts as seen while it is at most so many tiles across.
const MOST_TILES_ACROSS: u32 = 3u;

// A rectangle of ground in units; nothing where the first corner lies beyond the last.
struct Ground {
    first: vec2<i32>,
    last: vec2<i32>,
}

fn unit_at(offset_m: vec2<f32>) -> vec2<i32> {
    let unit = params.anchor + vec2<i32>(floor(units_from_anchor(offset_m)));
    return clamp(unit, vec2<i32>(0), vec2<i32>(1073741823));
}

fn mark(level: u32, row: u32, column: u32) {
    let key = tile_key(level, row, column, params.eye_ground);
    if key == 0u {
        atomicStore(&seen[SEEN_OVERFLOW], 1u);
        return;
    }
    var slot = first_slot(key);
    while atomicLoad(&seen[SEEN_OVERFLOW]) == 0u {
        let word = SEEN_HEADER + slot;
        let there = atomicLoad(&seen[word]);
        if there == key { return; }
        if there != 0u {
            slot = next_slot(slot);
            continue;
        }
        let claim = atomicCompareExchangeWeak(&seen[word], 0u, key);
        if claim.exchanged {
            if atomicAdd(&seen[SEEN_TILES], 1u) >= MOST_SEEN_TILES {
                atomicStore(&seen[SEEN_OVERFLOW], 1u);
            }
            return;
        }
        // Another has claimed the slot, or it was a failure without a reason: looked at again.
    }
}

// Marks the tiles of the ground, level by level as far as subdivision could split them. False where
// the ground is too many tiles across.
fn mark_ground(ground: Ground) -> bool {
    for (var level = 1u; level <= FINEST_LEVEL; level++) {
        let side = vec2<u32>(30u - level);
        let first = vec2<u32>(ground.first) >> side;
        let last = vec2<u32>(ground.last) >> side;
        if any(last - first >= vec2<u32>(MOST_TILES_ACROSS)) {
            return false;
        }
        var is_split = false;
        for (var row = first.y; row <= last.y; row++) {
            for (var column = first.x; column <= last.x; column++) {
                let distance = squared_distance(level - 1u, row / 2u, column / 2u);
                if is_less(distance, params.split_below[level - 1u]) {
                    mark(level, row, column);
                    is_split = true;
                }
            }
        }
        if !is_split { break; }
    }
    return true;
}

@compute @workgroup_size(16, 16)
fn mark_seen_tiles(@builtin(global_invocation_id) pixel: vec3<u32>) {
    let own = pixel_at(pixel.xy);
    var ground = Ground(vec2<i32>(2147483647), vec2<i32>(-1));
    for (var corner = 0u; corner < 4u; corner++) {
        let there = pixel_at(pixel.xy + vec2<u32>(corner % 2u, corner / 2u));
        if there.is_ground {
            let unit = unit_at(there.offset_m);
            ground.first = min(ground.first, unit);
            ground.last = max(ground.last, unit);
        }
    }
    if all(ground.first <= ground.last) && !mark_ground(ground) && own.is_ground {
        let unit = unit_at(own.offset_m);
        mark_ground(Ground(unit, unit));
    }
}
