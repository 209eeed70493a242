// What a pixel asks for of a virtual texture: a page, and how fine it wants it. The twin is `PageRequest` in
// the library, where the words are explained.
// needs page_table.wgsl

// What a pixel holds that asks for nothing.
const NO_REQUEST: u32 = 0xffffffffu;
// Steps that a level is told apart in, and steps below level 0.
const STEPS: i32 = 8;
const STEPS_BELOW: i32 = 16;

fn page_request(place: TexturePlace, footprint: PageFootprint) -> vec2<u32> {
    let wanted = max(i32(floor((footprint.level + pages.request_bias) * f32(STEPS))), -STEPS_BELOW);
    let level = u32(max(wanted, 0) / STEPS);
    if level >= pages.first_resident_level {
        return vec2<u32>(NO_REQUEST);
    }
    let page = finest_page(place) >> vec2<u32>(level);
    let step = u32(wanted - i32(level) * STEPS + STEPS_BELOW);
    return vec2<u32>(level | ((1u << step) << 8u), (page.y << 16u) | page.x);
}
