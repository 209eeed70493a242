use glam::{DVec2, dvec2};

/// How many rays are cast through a pixel, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayPattern {
    rays: u32,
}

impl RayPattern {
    /// Of so many rays, at least 1.
    pub fn of(rays: u32) -> Self {
        Self { rays: rays.max(1) }
    }

    /// Rays a pixel.
    pub fn rays(self) -> u32 {
        self.rays
    }

    /// Angle between neighbouring rays as a part of a pixel's: each stands for an equal share of it.
    pub fn spacing_px(self) -> f64 {
        1.0 / f64::from(self.rays).sqrt()
    }

    /// Places in the pixel, 0..1 right and down: a golden-ratio lattice. Along either axis the rays
    /// are evenly spaced, so that an edge near the pixel's columns or rows is crossed by one after
    /// another, where a square lattice is crossed in groups. Under a line of any slope the part of the
    /// rays differs from the part of the pixel by at most 0.145 with 16 and 0.07 with 64.
    pub fn places(self) -> impl Iterator<Item = DVec2> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let rays = f64::from(self.rays);
        (0..self.rays).map(move |ray| {
            let index = f64::from(ray);
            dvec2((index + 0.5) / rays, (index * GOLDEN + 0.5).fract())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ray_goes_through_the_middle() {
        assert_eq!(RayPattern::of(1).places().collect::<Vec<_>>(), [dvec2(0.5, 0.5)]);
        assert_eq!(RayPattern::of(0).rays(), 1);
    }

    /// The part of rays on one side of any line is near the part of the pixel there.
    #[test]
    fn rays_count_areas_under_any_line() {
        for (rays, bound) in [(16, 0.145), (64, 0.07)] {
            let mut worst = 0.0_f64;
            for step in 0..180 {
                let angle = f64::from(step).to_radians();
                let normal = dvec2(angle.cos(), angle.sin());
                for offset in -7..=7 {
                    let offset = 0.1 * f64::from(offset);
                    let beyond = |place: DVec2| (place - 0.5).dot(normal) > offset;
                    let counted = RayPattern::of(rays).places().filter(|&p| beyond(p)).count();
                    let fine = RayPattern::of(40_000).places().filter(|&p| beyond(p)).count();
                    let error = counted as f64 / f64::from(rays) - fine as f64 / 40_000.0;
                    worst = worst.max(error.abs());
                }
            }
            println!("{rays} rays: {worst:.4}");
            assert!(worst < bound, "{rays} rays: {worst}");
        }
    }
}
