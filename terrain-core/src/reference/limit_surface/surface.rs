use glam::DVec2;
use serde::Serialize;

use super::{LimitRelief, LimitSurfaceError, TriangleColours};

/// A textured limit-triangulated surface: triangles and their colours over distance.
///
/// A triangle's colours belong to the triangle, not to a place in space: when the surface changes
/// shape they go with it.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitSurface {
    relief: LimitRelief,
    colours: TriangleColours,
    admissible_angle_rad: f64,
}

/// What a surface takes in memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitMemory {
    /// Triangles, absent ones counted.
    pub triangles: u64,
    /// Knots of all triangles.
    pub knots: u64,
    /// Bytes of colours.
    pub colour_bytes: u64,
    /// Bytes of heights and of the ranges by which rays skip.
    pub shape_bytes: u64,
}

impl LimitMemory {
    /// Bytes of colours a triangle.
    pub fn colour_bytes_per_triangle(&self) -> f64 {
        self.colour_bytes as f64 / self.triangles.max(1) as f64
    }

    /// Knots a triangle.
    pub fn knots_per_triangle(&self) -> f64 {
        self.knots as f64 / self.triangles.max(1) as f64
    }
}

impl LimitSurface {
    /// Of a shape and as many colours as it has triangles, integrated with the angle in radians.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where the numbers differ.
    pub fn new(
        relief: LimitRelief,
        colours: TriangleColours,
        admissible_angle_rad: f64,
    ) -> Result<Self, LimitSurfaceError> {
        let (triangles, coloured) = (relief.grid().triangle_count(), colours.triangle_count());
        if triangles != coloured {
            let reason = format!("{coloured} colours for {triangles} triangles");
            return Err(LimitSurfaceError::Setting(reason));
        }
        Ok(Self { relief, colours, admissible_angle_rad })
    }

    /// The triangles' shape.
    pub fn relief(&self) -> &LimitRelief {
        &self.relief
    }

    /// The triangles' colours.
    pub fn colours(&self) -> &TriangleColours {
        &self.colours
    }

    /// Apex angle of the cones the colours were integrated with, radians.
    pub fn admissible_angle_rad(&self) -> f64 {
        self.admissible_angle_rad
    }

    /// The same triangles with the same colours and each node at another height, given its place
    /// and its height.
    ///
    /// # Errors
    /// [`LimitSurfaceError::Setting`] where a new height is infinite.
    pub fn deformed(
        &self,
        height_m: impl Fn(DVec2, f32) -> f32,
    ) -> Result<Self, LimitSurfaceError> {
        let relief = self.relief.deformed(height_m)?;
        Ok(Self { relief, ..self.clone() })
    }

    /// What it takes in memory.
    pub fn memory(&self) -> LimitMemory {
        LimitMemory {
            triangles: self.colours.triangle_count() as u64,
            knots: self.colours.knot_count() as u64,
            colour_bytes: self.colours.byte_len(),
            shape_bytes: self.relief.byte_len(),
        }
    }
}
