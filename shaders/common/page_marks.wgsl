// Pages marked as needed, each on a list once, whoever finds that they are: the paper's U2 and U3.
// needs page_table.wgsl

// U2: a word a page, the bits of the steps that it is wanted at (`PageRequest` in the library).
@group(1) @binding(0) var<storage, read_write> marks: array<atomic<u32>>;

// U3.
struct PageList {
    // Pages found; more than MOST_LISTED where not all are on the list.
    count: atomic<u32>,
    padding: u32,
    pages: array<vec2<u32>>,
}

@group(1) @binding(1) var<storage, read_write> list: PageList;

const MOST_LISTED: u32 = 16384u;

// Marks a page (column, row) of a level by these steps.
fn mark_page(level: u32, page: vec2<u32>, steps: u32) {
    let address = page_address(level, page);
    if (atomicLoad(&marks[address]) & steps) == steps {
        return;
    }
    if atomicOr(&marks[address], steps) == 0u {
        let place = atomicAdd(&list.count, 1u);
        if place < MOST_LISTED {
            list.pages[place] = vec2<u32>(level, (page.y << 16u) | page.x);
        }
    }
}
