/// A rectangle of texels of one level: columns `west..east` and rows `north..south`, counted from the
/// root's north-west corner. Empty where either range is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TexelRect {
    /// First column.
    pub west: u32,
    /// First row.
    pub north: u32,
    /// Column after the last.
    pub east: u32,
    /// Row after the last.
    pub south: u32,
}

impl TexelRect {
    /// The rectangle with this north-west texel and size (width, height).
    pub fn new([west, north]: [u32; 2], [width, height]: [u32; 2]) -> Self {
        Self { west, north, east: west + width, south: north + height }
    }

    /// Columns; 0 where it is empty.
    pub fn width(&self) -> u32 {
        self.east.saturating_sub(self.west)
    }

    /// Rows; 0 where it is empty.
    pub fn height(&self) -> u32 {
        self.south.saturating_sub(self.north)
    }

    /// Texels.
    pub fn area(&self) -> u64 {
        u64::from(self.width()) * u64::from(self.height())
    }

    /// Whether it holds no texel.
    pub fn is_empty(&self) -> bool {
        self.area() == 0
    }

    /// The texels both hold.
    pub fn intersection(&self, other: &Self) -> Self {
        let both = Self {
            west: self.west.max(other.west),
            north: self.north.max(other.north),
            east: self.east.min(other.east),
            south: self.south.min(other.south),
        };
        if both.is_empty() { Self::default() } else { both }
    }

    /// Whether every texel of the other is in this one.
    pub fn covers(&self, other: &Self) -> bool {
        self.intersection(other) == *other || other.is_empty()
    }

    /// Whether the texel at this column and row is in it.
    pub fn holds(&self, [column, row]: [u32; 2]) -> bool {
        (self.west..self.east).contains(&column) && (self.north..self.south).contains(&row)
    }
}
