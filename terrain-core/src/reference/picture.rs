use glam::DVec3;

/// What a camera sees of the full-resolution data. All lists are row-major from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferencePicture {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// sRGB-encoded colour and alpha 255, as in the pictures the renderer draws.
    pub rgba: Vec<[u8; 4]>,
    /// Where the ray through the pixel's centre meets the surface: x, y in metres of the CRS and z
    /// as drawn, vertical exaggeration included. NaN where there is sky. Of a globe as
    /// [`Geodetic::of_seen`](crate::geodesy::Geodetic::of_seen) reads it.
    pub coordinates: Vec<DVec3>,
    /// Distance from the eye to that point in metres; infinite where there is sky.
    pub distance_m: Vec<f64>,
    /// Whether the edge of something nearer, against the ground behind it or the sky, runs through
    /// the pixel.
    pub silhouette: Vec<bool>,
}
