use glam::DVec2;

use super::HeightTile;
use crate::tiling::{LayerLayout, TilingScheme};

impl HeightTile {
    /// Height in metres at a point of the tile, bilinear between its samples in f64; of the samples
    /// that hold data where some do not. `None` where none does, or beyond the tile's gutter.
    pub fn height_at_m(
        &self,
        scheme: &TilingScheme,
        layout: &LayerLayout,
        point: DVec2,
    ) -> Option<f64> {
        self.held_height_at_m(scheme, layout, point).map(|(height_m, _)| height_m)
    }

    /// [`Self::height_at_m`] with the part of the four samples around the point, by their bilinear
    /// weights, that hold data.
    pub fn held_height_at_m(
        &self,
        scheme: &TilingScheme,
        layout: &LayerLayout,
        point: DVec2,
    ) -> Option<(f64, f64)> {
        let corner = layout.stored_extent(scheme, self.id);
        let texel_m = layout.texel_size_m(scheme, self.id.level);
        let place = DVec2::new(point.x - corner.min.x, corner.max.y - point.y) / texel_m - 0.5;
        let size = f64::from(self.stored_size_texels);
        if !(place.cmpge(DVec2::ZERO).all() && place.cmple(DVec2::splat(size - 1.0)).all()) {
            return None;
        }
        let low = place.floor().min(DVec2::splat(size - 2.0));
        let part = place - low;
        let (row, column) = (low.y as usize, low.x as usize);
        let corners = [
            (0, 0, (1.0 - part.x) * (1.0 - part.y)),
            (0, 1, part.x * (1.0 - part.y)),
            (1, 0, (1.0 - part.x) * part.y),
            (1, 1, part.x * part.y),
        ];
        let (mut sum, mut weight) = (0.0, 0.0);
        for (down, right, share) in corners {
            let index = (row + down) * self.stored_size_texels as usize + column + right;
            if let Some(height_m) = self.samples.height_m(index) {
                sum += share * f64::from(height_m);
                weight += share;
            }
        }
        (weight > 0.0).then(|| (sum / weight, weight))
    }
}
