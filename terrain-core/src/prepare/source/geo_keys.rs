use std::path::Path;

use glam::dvec2;

use super::{RasterGrid, SourceError};

/// The georeferencing tags of a GeoTIFF (OGC 19-008r4), as numbers.
#[derive(Clone, Debug, Default)]
pub struct GeoTags {
    /// ModelPixelScaleTag.
    pub pixel_scale: Option<Vec<f64>>,
    /// ModelTiepointTag.
    pub tie_points: Option<Vec<f64>>,
    /// ModelTransformationTag.
    pub transformation: Option<Vec<f64>>,
    /// GeoKeyDirectoryTag.
    pub key_directory: Option<Vec<u16>>,
}

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEODETIC_CRS: u16 = 2048;
const PROJECTED_CRS: u16 = 3072;
const RASTER_PIXEL_IS_POINT: u16 = 2;
/// Values from here on are private, 32767 means "defined by other keys".
const FIRST_PRIVATE: u16 = 32767;

impl GeoTags {
    /// The value of a key that is stored in the directory itself.
    fn key(&self, id: u16) -> Option<u16> {
        let directory = self.key_directory.as_deref()?;
        let mut keys = directory.get(4..)?.chunks_exact(4);
        keys.find(|key| key[0] == id && key[1] == 0).map(|key| key[3])
    }

    /// The EPSG code of the projected or, for a geographic model, the geodetic CRS.
    pub fn epsg(&self) -> Option<u32> {
        let geographic = self.key(MODEL_TYPE) == Some(2);
        let code = if geographic { self.key(GEODETIC_CRS) } else { self.key(PROJECTED_CRS) };
        code.filter(|&code| code > 0 && code < FIRST_PRIVATE).map(u32::from)
    }

    /// Whether the file says what CRS it has, but in a way that has no EPSG code.
    pub fn has_other_crs(&self) -> bool {
        self.epsg().is_none() && self.key(MODEL_TYPE).is_some()
    }

    /// Whether heights stand for points, not areas.
    pub fn is_pixel_is_point(&self) -> bool {
        self.key(RASTER_TYPE) == Some(RASTER_PIXEL_IS_POINT)
    }

    /// The grid of cells; `None` where the tags say nothing of it.
    ///
    /// With PixelIsPoint, raster position (0, 0) is the *centre* of the first cell, so the grid moves
    /// by half a cell to the north-west.
    pub fn grid(&self, path: &Path) -> Result<Option<RasterGrid>, SourceError> {
        let bad = |reason: &str| Err(SourceError::bad_georeference(path, reason));
        let mut grid = if let Some(matrix) = &self.transformation {
            let [a, b, _, x, c, e, _, y, ..] = matrix[..] else {
                return bad("the transformation is not a 4 x 4 matrix");
            };
            if b != 0.0 || c != 0.0 {
                return bad("the raster is rotated; `gdalwarp` can make it north-up");
            }
            RasterGrid { origin: dvec2(x, y), cell: dvec2(a, -e) }
        } else if let (Some(scale), Some(tie)) = (&self.pixel_scale, &self.tie_points) {
            let ([dx, dy, ..], [column, row, _, x, y, ..]) = (&scale[..], &tie[..]) else {
                return bad("the scale or the tie point is incomplete");
            };
            let origin = dvec2(x - column * dx, y + row * dy);
            RasterGrid { origin, cell: dvec2(*dx, *dy) }
        } else if self.tie_points.as_ref().is_some_and(|tie| tie.len() > 6) {
            return bad("ground control points only; `gdalwarp` can make it north-up");
        } else {
            return Ok(None);
        };
        if grid.cell.y < 0.0 {
            return bad("rows run from south to north; `gdalwarp` can make it north-up");
        }
        if self.is_pixel_is_point() {
            grid.origin += 0.5 * dvec2(-grid.cell.x, grid.cell.y);
        }
        Ok(Some(grid))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(raster_type: u16) -> GeoTags {
        GeoTags {
            pixel_scale: Some(vec![10.0, 20.0, 0.0]),
            tie_points: Some(vec![2.0, 1.0, 0.0, 500.0, 800.0, 0.0]),
            transformation: None,
            key_directory: Some(vec![
                1,
                1,
                0,
                3,
                1024,
                0,
                1,
                1,
                1025,
                0,
                1,
                raster_type,
                3072,
                0,
                1,
                32632,
            ]),
        }
    }

    #[test]
    fn point_and_area_differ_by_half_a_cell() {
        let area = tags(1).grid(Path::new("a")).unwrap().unwrap();
        assert_eq!(area.origin, dvec2(480.0, 820.0));
        let point = tags(2).grid(Path::new("a")).unwrap().unwrap();
        assert_eq!(point.origin, dvec2(475.0, 830.0));
        assert_eq!(point.cell, area.cell);
        assert_eq!(tags(1).epsg(), Some(32632));
    }

    #[test]
    fn a_matrix_says_the_same_and_a_rotated_one_is_refused() {
        let mut matrix = vec![0.0; 16];
        (matrix[0], matrix[3], matrix[5], matrix[7]) = (10.0, 480.0, -20.0, 820.0);
        let mut by_matrix = tags(1);
        by_matrix.transformation = Some(matrix.clone());
        assert_eq!(by_matrix.grid(Path::new("a")), tags(1).grid(Path::new("a")));
        matrix[1] = 0.5;
        by_matrix.transformation = Some(matrix);
        assert!(by_matrix.grid(Path::new("a")).is_err());
    }
}
