use glam::{DVec2, dvec2};

/// Where the cells of a raster lie, in the units of its CRS (degrees or metres): a north-up grid of
/// areas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RasterGrid {
    /// North-west corner of the north-western cell.
    pub origin: DVec2,
    /// Width and height of a cell, both positive.
    pub cell: DVec2,
}

/// A rectangle of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub column: u32,
    /// First row.
    pub row: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl Window {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether the window holds no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl RasterGrid {
    /// The position of a place given in cells from the north-west corner, columns and rows.
    pub fn position(&self, columns_rows: DVec2) -> DVec2 {
        self.origin + dvec2(columns_rows.x * self.cell.x, -columns_rows.y * self.cell.y)
    }

    /// Columns and rows from the north-west corner of a position (cell centres at .5).
    pub fn columns_rows(&self, position: DVec2) -> DVec2 {
        dvec2(position.x - self.origin.x, self.origin.y - position.y) / self.cell
    }

    /// The south-west and north-east corner of a raster of this size.
    pub fn bounds(&self, size: [u32; 2]) -> (DVec2, DVec2) {
        let far = self.position(dvec2(f64::from(size[0]), f64::from(size[1])));
        (dvec2(self.origin.x, far.y), dvec2(far.x, self.origin.y))
    }

    /// Why the grid cannot be true for a raster of this size, if so. `geographic` tells degrees from
    /// metres.
    pub fn fault(&self, size: [u32; 2], geographic: bool) -> Option<String> {
        let (min, max) = self.bounds(size);
        if !(min.is_finite() && max.is_finite() && self.cell.is_finite()) {
            return Some("a coordinate is not a finite number".to_owned());
        }
        if self.cell.min_element() <= 0.0 {
            return Some(format!("a cell measures {} x {}", self.cell.x, self.cell.y));
        }
        if geographic {
            // A node-registered globe reaches half a cell beyond the pole and the date line.
            let margin = self.cell.max_element();
            let lost = max.y > 90.0 + margin || min.y < -90.0 - margin;
            if lost || min.x < -360.0 - margin || max.x > 540.0 || max.x - min.x > 360.0 + margin {
                return Some(format!("degrees from {min} to {max} are not on Earth"));
            }
        } else if min.abs().max(max.abs()).max_element() > 1.0e9 || self.cell.min_element() < 1e-4 {
            return Some(format!("metres from {min} to {max}, cells of {}", self.cell));
        }
        None
    }
}
