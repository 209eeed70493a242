use glam::Vec3;

use super::DistanceSet;
use super::colour_codes::linear_from_srgb;

/// The colour of every triangle as a function of the distance it is seen from, T = {(C_1, d_1), ..,
/// (C_N, d_N)} of formula (2), each triangle with knots of its own.
///
/// A triangle is one 32-bit word. One-coloured: the colour itself. Else the place of its run of knots,
/// each a word too: colour in the low 24 bits (sRGB, red lowest), number of its distance in the next
/// seven, and the highest bit set on the last of the run. So a ray reads one word, or one word and
/// then neighbouring ones.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleColours {
    distances: DistanceSet,
    words: Vec<u32>,
    knots: Vec<u32>,
}

/// A knot of a triangle's colour function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knot {
    /// Number of its distance in the set.
    pub distance: u8,
    /// sRGB colour at that distance.
    pub srgb: [u8; 3],
}

/// What a look-up read: the colour and how much memory it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourRead {
    /// Linear light.
    pub linear: Vec3,
    /// 32-bit words read.
    pub words: u32,
    /// Separate places in memory they were read from.
    pub places: u32,
}

/// Set in a triangle's word where the rest is the place of a run of knots.
const IS_RUN: u32 = 1 << 31;
/// A triangle that is not there: its ground holds no data.
const ABSENT: u32 = 1 << 30;
/// Set on the last knot of a run.
const IS_LAST: u32 = 1 << 31;

impl TriangleColours {
    /// Bytes of a triangle's word, and of each knot of a triangle that has more than one.
    pub const WORD_BYTES: u64 = 4;

    /// No triangles yet.
    pub fn new(distances: DistanceSet) -> Self {
        Self { distances, words: Vec::new(), knots: Vec::new() }
    }

    /// Adds a triangle by its knots, in the order of their distances. Without knots it is absent.
    pub fn push(&mut self, knots: &[Knot]) {
        match knots {
            [] => self.words.push(ABSENT),
            [only] => self.words.push(colour_word(only.srgb)),
            [.., last] => {
                self.words.push(IS_RUN | self.knots.len() as u32);
                self.knots.extend(knots.iter().map(|knot| knot_word(*knot)));
                let end = self.knots.len() - 1;
                self.knots[end] = IS_LAST | knot_word(*last);
            }
        }
    }

    /// Of words and knots as they lie in memory, checked: every run lies within the knots and ends,
    /// its distances increase and are in the set.
    ///
    /// # Errors
    /// One line on what does not fit.
    pub fn from_words(
        distances: DistanceSet,
        words: Vec<u32>,
        knots: Vec<u32>,
    ) -> Result<Self, String> {
        let made = Self { distances, words, knots };
        for (triangle, &word) in made.words.iter().enumerate() {
            if word & IS_RUN != 0 {
                let start = (word & !IS_RUN) as usize;
                made.check_run(start).map_err(|what| format!("triangle {triangle}: {what}"))?;
            } else if word != ABSENT && word >> 24 != 0 {
                return Err(format!("triangle {triangle}: word {word:#x} means nothing"));
            }
        }
        Ok(made)
    }

    fn check_run(&self, start: usize) -> Result<(), String> {
        let mut before = None;
        for &word in self.knots.get(start..).unwrap_or_default() {
            let knot = knot_of(word);
            if usize::from(knot.distance) >= self.distances.count() {
                return Err(format!("no distance {}", knot.distance));
            }
            if before.is_some_and(|before| before >= knot.distance) {
                return Err("its distances do not increase".to_owned());
            }
            if word & IS_LAST != 0 {
                return Ok(());
            }
            before = Some(knot.distance);
        }
        Err("its knots do not end".to_owned())
    }

    /// Appends the triangles of another with the same distances.
    pub fn append(&mut self, other: &Self) {
        let shift = self.knots.len() as u32;
        let moved = |&word: &u32| if word & IS_RUN != 0 { word + shift } else { word };
        self.words.extend(other.words.iter().map(moved));
        self.knots.extend(&other.knots);
    }

    /// The distances.
    pub fn distances(&self) -> &DistanceSet {
        &self.distances
    }

    /// How many triangles there are, absent ones counted.
    pub fn triangle_count(&self) -> usize {
        self.words.len()
    }

    /// Knots of all triangles; one for each that has one colour.
    pub fn knot_count(&self) -> usize {
        let single = self.words.iter().filter(|&&word| word & (IS_RUN | ABSENT) == 0).count();
        single + self.knots.len()
    }

    /// Bytes of all colours in memory.
    pub fn byte_len(&self) -> u64 {
        Self::WORD_BYTES * (self.words.len() + self.knots.len()) as u64
    }

    /// The words of triangles and of knots, as they go to the GPU.
    pub fn as_words(&self) -> (&[u32], &[u32]) {
        (&self.words, &self.knots)
    }

    /// A triangle's knots; none where it is absent or not of this surface.
    pub fn knots(&self, triangle: usize) -> Vec<Knot> {
        match self.words.get(triangle) {
            None | Some(&ABSENT) => Vec::new(),
            Some(&word) if word & IS_RUN == 0 => vec![Knot { distance: 0, srgb: srgb_of(word) }],
            Some(&word) => {
                let run = &self.knots[(word & !IS_RUN) as usize..];
                let length = run.iter().take_while(|&&knot| knot & IS_LAST == 0).count() + 1;
                run.iter().take(length).map(|&knot| knot_of(knot)).collect()
            }
        }
    }

    /// Formula (4): the colour of a triangle from a distance in metres. Between two knots it runs
    /// linearly in linear light; beyond the outer ones it stays. `None` where the triangle is absent.
    pub fn colour(&self, triangle: usize, distance_m: f64) -> Option<ColourRead> {
        let word = *self.words.get(triangle)?;
        if word == ABSENT {
            return None;
        }
        if word & IS_RUN == 0 {
            let linear = linear_from_srgb(srgb_of(word));
            return Some(ColourRead { linear, words: 1, places: 1 });
        }
        let run = self.knots.get((word & !IS_RUN) as usize..)?;
        let distances_m = self.distances.as_slice();
        let mut near = *run.first()?;
        for (read, &far) in (2..).zip(run) {
            let far_m = distances_m[usize::from(knot_of(far).distance)];
            if distance_m < far_m {
                let near_m = distances_m[usize::from(knot_of(near).distance)];
                let span_m = far_m - near_m;
                let part = if span_m > 0.0 { (distance_m - near_m) / span_m } else { 0.0 };
                let [start, end] = [near, far].map(|knot| linear_from_srgb(srgb_of(knot)));
                let linear = start.lerp(end, part.max(0.0) as f32);
                return Some(ColourRead { linear, words: read, places: 2 });
            }
            near = far;
            if far & IS_LAST != 0 {
                let linear = linear_from_srgb(srgb_of(far));
                return Some(ColourRead { linear, words: read, places: 2 });
            }
        }
        None
    }
}

fn colour_word([red, green, blue]: [u8; 3]) -> u32 {
    u32::from_le_bytes([red, green, blue, 0])
}

fn knot_word(knot: Knot) -> u32 {
    colour_word(knot.srgb) | u32::from(knot.distance) << 24
}

fn srgb_of(word: u32) -> [u8; 3] {
    let [red, green, blue, _] = word.to_le_bytes();
    [red, green, blue]
}

fn knot_of(word: u32) -> Knot {
    Knot { distance: (word >> 24) as u8 & 0x7f, srgb: srgb_of(word) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot(distance: u8, code: u8) -> Knot {
        Knot { distance, srgb: [code, 0, 255 - code] }
    }

    fn distances() -> DistanceSet {
        DistanceSet::new(vec![10.0, 20.0, 40.0, 80.0]).unwrap()
    }

    fn three() -> TriangleColours {
        let mut colours = TriangleColours::new(distances());
        colours.push(&[knot(2, 77)]);
        colours.push(&[]);
        colours.push(&[knot(0, 10), knot(2, 200), knot(3, 100)]);
        colours
    }

    #[test]
    fn knots_come_back_and_memory_is_counted() {
        let colours = three();
        assert_eq!(colours.knots(0), [knot(0, 77)]);
        assert_eq!(colours.knots(1), []);
        assert_eq!(colours.knots(2), [knot(0, 10), knot(2, 200), knot(3, 100)]);
        assert_eq!((colours.triangle_count(), colours.knot_count()), (3, 4));
        assert_eq!(colours.byte_len(), 4 * (3 + 3));
    }

    #[test]
    fn colours_follow_formula_4_and_stay_beyond_the_ends() {
        let colours = three();
        let linear = |code| linear_from_srgb(knot(0, code).srgb);
        let at = |d: f64| colours.colour(2, d).unwrap();
        assert_eq!(at(1.0).linear, linear(10));
        assert_eq!(at(10.0).linear, linear(10));
        assert_eq!(at(40.0).linear, linear(200));
        assert_eq!(at(1.0e9).linear, linear(100));
        for (d, from, to, part) in [(17.5, 10, 200, 0.25), (70.0, 200, 100, 0.75)] {
            let expected = linear(from) + (linear(to) - linear(from)) * part;
            assert!((at(d).linear - expected).length() < 1e-6, "{d}");
        }
        assert_eq!(colours.colour(0, 33.0).unwrap().words, 1);
        assert_eq!((at(30.0).words, at(30.0).places), (3, 2));
        assert_eq!(colours.colour(1, 33.0), None);
        assert_eq!(colours.colour(3, 33.0), None);
    }

    #[test]
    fn appended_triangles_keep_their_knots() {
        let mut colours = three();
        colours.append(&three());
        for triangle in 0..6 {
            assert_eq!(colours.knots(triangle), three().knots(triangle % 3));
        }
    }

    #[test]
    fn words_that_mean_nothing_are_refused() {
        let (words, knots) = (three().words, three().knots);
        let read = |words: &[u32], knots: &[u32]| {
            TriangleColours::from_words(distances(), words.to_vec(), knots.to_vec())
        };
        assert_eq!(read(&words, &knots), Ok(three()));
        assert!(read(&[IS_RUN | 7], &knots).is_err(), "a run outside");
        assert!(read(&words, &knots[..2]).is_err(), "a run without end");
        assert!(read(&words, &[knots[1], knots[0], knots[2]]).is_err(), "distances fall");
        assert!(read(&[IS_RUN], &[IS_LAST | 9 << 24]).is_err(), "a distance that is none");
        assert!(read(&[1 << 29], &[]).is_err(), "a word that means nothing");
    }
}
