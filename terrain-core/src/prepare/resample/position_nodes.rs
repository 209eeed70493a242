use glam::{DVec2, dvec2};

/// Texels between two nodes. Over this distance every supported projection is straight to within a
/// few hundredths of a cell.
const SPACING: usize = 8;

/// Source positions of a block's texels: computed at nodes, interpolated between them.
pub struct PositionNodes {
    columns: usize,
    nodes: Vec<Option<DVec2>>,
}

impl PositionNodes {
    /// `position` takes a texel of the block (its centre; whole numbers are texels) to columns and
    /// rows of the source. `columns_round` is how many columns go once round the Earth: positions
    /// are then brought to the turn nearest to the source of `source_columns`, all to the same one.
    pub fn new(
        width: usize,
        height: usize,
        position: impl Fn(f64, f64) -> Option<DVec2>,
        columns_round: Option<f64>,
        source_columns: f64,
    ) -> Self {
        let columns = width.div_ceil(SPACING) + 1;
        let rows = height.div_ceil(SPACING) + 1;
        let mut nodes: Vec<Option<DVec2>> = (0..columns * rows)
            .map(|index| {
                let node = dvec2((index % columns) as f64, (index / columns) as f64);
                let texel = node * SPACING as f64;
                position(texel.x, texel.y)
            })
            .collect();
        if let Some(round) = columns_round {
            let turned = |x: f64, near: f64| x - round * ((x - near) / round).round();
            let middle = nodes[nodes.len() / 2].or_else(|| nodes.iter().flatten().next().copied());
            let near = middle.map(|middle| turned(middle.x, 0.5 * source_columns));
            for node in nodes.iter_mut().flatten() {
                node.x = turned(node.x, near.unwrap_or(node.x));
            }
        }
        Self { columns, nodes }
    }

    /// The same positions so many columns farther on.
    #[must_use]
    pub fn moved(&self, columns: f64) -> Self {
        let moved = |node: &Option<DVec2>| node.map(|node| node + dvec2(columns, 0.0));
        Self { columns: self.columns, nodes: self.nodes.iter().map(moved).collect() }
    }

    /// The least and greatest columns and rows; `None` where no node has a position.
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let known = || self.nodes.iter().flatten().copied();
        Some((known().reduce(DVec2::min)?, known().reduce(DVec2::max)?))
    }

    /// Position of the centre of a texel; `None` where a node around it has none.
    pub fn position(&self, column: usize, row: usize) -> Option<DVec2> {
        let at = row / SPACING * self.columns + column / SPACING;
        let along = |index: usize| (index % SPACING) as f64 / SPACING as f64;
        let (x, y) = (along(column), along(row));
        let north = self.nodes[at]?.lerp(self.nodes[at + 1]?, x);
        let south = self.nodes[at + self.columns]?.lerp(self.nodes[at + self.columns + 1]?, x);
        Some(north.lerp(south, y))
    }

    /// Whether columns depend on x alone and rows on y alone.
    pub fn has_separate_axes(&self) -> bool {
        const SLACK_CELLS: f64 = 1e-6;
        self.nodes.iter().enumerate().all(|(index, node)| {
            let west = self.nodes[index - index % self.columns];
            let north = self.nodes[index % self.columns];
            match (node, north, west) {
                (Some(node), Some(north), Some(west)) => {
                    (node.x - north.x).abs() < SLACK_CELLS && (node.y - west.y).abs() < SLACK_CELLS
                }
                _ => false,
            }
        })
    }

    /// How many source cells a texel spans at the most, along either axis.
    pub fn cells_a_texel(&self) -> f64 {
        let pairs = self.nodes.iter().zip(self.nodes.iter().skip(1)).enumerate();
        let steps = pairs
            .filter(|(index, _)| (index + 1) % self.columns != 0)
            .filter_map(|(_, (west, east))| Some((east.as_ref()? - west.as_ref()?).abs()));
        let down = self.nodes.iter().zip(self.nodes.iter().skip(self.columns));
        let falls =
            down.filter_map(|(north, south)| Some((south.as_ref()? - north.as_ref()?).abs()));
        let greatest = steps.chain(falls).fold(0.0, |most: f64, step| most.max(step.max_element()));
        greatest / SPACING as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_affine_map_is_reproduced_and_measured() {
        let map = |x: f64, y: f64| Some(dvec2(1.5 * x + 0.25 * y, 100.0 - 0.5 * y));
        let nodes = PositionNodes::new(21, 13, map, None, 0.0);
        for (column, row) in [(0, 0), (7, 8), (20, 12), (16, 3)] {
            let expected = map(column as f64, row as f64).unwrap();
            assert!((nodes.position(column, row).unwrap() - expected).length() < 1e-12);
        }
        assert!((nodes.cells_a_texel() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn positions_beyond_the_date_line_stay_together() {
        let map = |x: f64, _: f64| Some(dvec2((350.0 + x).rem_euclid(360.0), 5.0));
        let nodes = PositionNodes::new(24, 1, map, Some(360.0), 360.0);
        for column in 0..24 {
            assert_eq!(nodes.position(column, 0).unwrap().x, 350.0 + column as f64);
        }
    }
}
