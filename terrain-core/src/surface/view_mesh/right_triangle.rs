use glam::IVec2;

/// A right isosceles triangle of the bisection, its corners counter-clockwise as seen from above.
/// Points count units to the east (x) and to the south (y).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RightTriangle {
    /// The corner with the right angle.
    pub apex: IVec2,
    /// The corner after the apex.
    pub left: IVec2,
    /// The corner before the apex.
    pub right: IVec2,
}

impl RightTriangle {
    /// The two halves of a square: first the one whose apex lies in the north. The square is cut from
    /// north-west to south-east where its row and column are both even or both odd, else the other
    /// way: so the cuts of a tile's four quarters all end at its middle.
    pub fn halves(corner: IVec2, size: i32, (row, column): (u32, u32)) -> [Self; 2] {
        let at = |east: i32, south: i32| corner + IVec2::new(east, south) * size;
        let [north_west, north_east] = [at(0, 0), at(1, 0)];
        let [south_west, south_east] = [at(0, 1), at(1, 1)];
        if (row + column).is_multiple_of(2) {
            [
                Self { apex: north_east, left: north_west, right: south_east },
                Self { apex: south_west, left: south_east, right: north_west },
            ]
        } else {
            [
                Self { apex: north_west, left: south_west, right: north_east },
                Self { apex: south_east, left: north_east, right: south_west },
            ]
        }
    }

    /// Which half of its square a triangle of even depth is: 0 with its apex in the north, else 1.
    pub fn half(&self) -> u32 {
        u32::from(self.apex.y == self.left.y.max(self.right.y))
    }

    /// The middle of the longest edge, where the triangle is cut; `None` where it is no whole unit.
    pub fn middle(&self) -> Option<IVec2> {
        // A root side is 2^30 units: the sum of two places still fits.
        let sum = self.left.as_i64vec2() + self.right.as_i64vec2();
        (sum % 2 == glam::I64Vec2::ZERO).then(|| (sum / 2).as_ivec2())
    }

    /// A point inside, away from every edge, unless the triangle is a few units small.
    pub fn inner_point(&self) -> IVec2 {
        let sum = 2 * self.apex.as_i64vec2() + self.left.as_i64vec2() + self.right.as_i64vec2();
        (sum / 4).as_ivec2()
    }

    /// The two triangles a cut at the middle of the longest edge leaves: first the one at the left
    /// corner.
    pub fn children(&self, middle: IVec2) -> [Self; 2] {
        [
            Self { apex: middle, left: self.apex, right: self.left },
            Self { apex: middle, left: self.right, right: self.apex },
        ]
    }

    /// Parts of the two legs, towards the left and the right corner, that lead from the apex to the
    /// point: both at least 0 and together at most 1 within the triangle.
    pub fn parts(&self, point: IVec2) -> [f32; 2] {
        let [to_left, to_right] = [self.left - self.apex, self.right - self.apex];
        let from_apex = point - self.apex;
        let square = to_left.length_squared() as f32;
        [from_apex.dot(to_left) as f32 / square, from_apex.dot(to_right) as f32 / square]
    }
}
