// Carries the changes of a mesh out: what was sent as one list goes to the vertices and triangles it is
// for.

// The numbers of vertices and triangles that follow; then five words a vertex: its number, then the
// vertex; then three words a triangle: its place and its three vertices in 24 bits each, lowest first.
@group(0) @binding(0) var<storage, read> changes: array<u32>;
@group(0) @binding(1) var<storage, read_write> vertices: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> indices: array<u32>;

const HEAD_WORDS: u32 = 2u;
const VERTEX_WORDS: u32 = 5u;
const TRIANGLE_WORDS: u32 = 3u;

@compute @workgroup_size(64)
fn update(@builtin(global_invocation_id) id: vec3<u32>) {
    let vertex_count = changes[0];
    let triangle_count = changes[1];
    if id.x < vertex_count {
        let at = HEAD_WORDS + id.x * VERTEX_WORDS;
        vertices[changes[at]] = vec4<u32>(changes[at + 1u], changes[at + 2u], changes[at + 3u], changes[at + 4u]);
    } else if id.x < vertex_count + triangle_count {
        let at = HEAD_WORDS + vertex_count * VERTEX_WORDS + (id.x - vertex_count) * TRIANGLE_WORDS;
        let words = vec3<u32>(changes[at], changes[at + 1u], changes[at + 2u]);
        let first = (words.x & 0xffffffu) * 3u;
        indices[first] = (words.x >> 24u) | ((words.y & 0xffffu) << 8u);
        indices[first + 1u] = (words.y >> 16u) | ((words.z & 0xffu) << 16u);
        indices[first + 2u] = words.z >> 8u;
    }
}
