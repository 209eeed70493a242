// The second and third stage of finding visible pages: of what all pixels ask for, each page once. Only the list
// is read back.
//
// Departures from the paper: its second stage marks the finest pages under what is asked for, so that a coarse
// page comes up once for each of them, where here a page marks itself; and its third scans all marks, where here
// whoever sets a page's first mark puts it on the list, so that the cost does not grow with the texture.
// needs: common/page_table.wgsl common/page_marks.wgsl

// U1: what each pixel asks for.
@group(0) @binding(0) var requests: texture_2d<u32>;

// Pixels along the side of a block that one invocation looks through: 2^p.
const BLOCK_PX: u32 = 4u;
const NO_REQUEST: u32 = 0xffffffffu;

fn requested_page(request: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(request.y & 0xffffu, request.y >> 16u);
}

@compute @workgroup_size(8, 8)
fn mark_pages(@builtin(global_invocation_id) block: vec3<u32>) {
    let size = textureDimensions(requests);
    let first = block.xy * BLOCK_PX;
    let end = min(first + BLOCK_PX, size);
    // Neighbouring pixels mostly ask for the same.
    var before = vec2<u32>(NO_REQUEST);
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            let request = textureLoad(requests, vec2<u32>(x, y), 0).xy;
            if all(request == before) { continue; }
            before = request;
            if request.x != NO_REQUEST {
                mark_page(request.x & 0xffu, requested_page(request), request.x >> 8u);
            }
        }
    }
}

// Completes the list by the steps that were marked after a page came on it.
@compute @workgroup_size(64)
fn list_pages(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= min(atomicLoad(&list.count), MOST_LISTED) {
        return;
    }
    let page = list.pages[id.x];
    let address = page_address(page.x, requested_page(page));
    list.pages[id.x].x = page.x | (atomicLoad(&marks[address]) << 8u);
}
