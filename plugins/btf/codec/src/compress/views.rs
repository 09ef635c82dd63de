//! The upper levels: rows over elevations and azimuths of the view.

use super::basis::{Basis, Book, Features, dot};

/// Rows of references to a level below, each with a scale; compared as the colours that they give.
#[derive(Clone, Default)]
pub(super) struct Rows {
    pub(super) columns: usize,
    pub(super) index: Vec<u32>,
    pub(super) scale: Vec<f32>,
    /// Sum of the squares of a row's colours.
    pub(super) squares: Vec<f32>,
    pub(super) book: Book,
    pub(super) basis: Basis,
}

/// Colours to be represented by a row with a scale.
pub(super) struct Goal<'a> {
    pub(super) colours: &'a [f32],
    pub(super) features: Features,
}

impl Rows {
    pub(super) fn new(columns: usize) -> Self {
        Self { columns, ..Self::default() }
    }

    pub(super) fn len(&self) -> usize {
        self.squares.len()
    }

    pub(super) fn row(&self, row: u32) -> (&[u32], &[f32]) {
        let range = row as usize * self.columns..(row as usize + 1) * self.columns;
        (&self.index[range.clone()], &self.scale[range])
    }

    pub(super) fn goal<'a>(&self, colours: &'a [f32]) -> Goal<'a> {
        let square = dot(colours, colours);
        Goal { colours, features: self.features(colours, square) }
    }

    /// A goal whose features are known.
    pub(super) fn goal_with<'a>(&self, colours: &'a [f32], features: Features) -> Goal<'a> {
        Goal { colours, features }
    }

    /// Of the vector of length 1, so that scales don't count.
    fn features(&self, colours: &[f32], square: f32) -> Features {
        let length = square.sqrt().max(1e-6);
        self.basis.features(colours).map(|feature| feature / length)
    }

    /// Among the rows from `first` on, that which comes nearest with its best scale, and the scale,
    /// if the root mean square error is within `limit`; `decode` gives a row's colours.
    pub(super) fn nearest(
        &self,
        goal: &Goal,
        first: usize,
        limit: f32,
        decode: impl Fn(u32, &mut [f32]),
    ) -> Option<(u32, f32)> {
        let mut best = (limit * limit * goal.colours.len() as f32, None);
        let mut colours = vec![0.0; goal.colours.len()];
        for row in self.book.near(&goal.features, first) {
            decode(row, &mut colours);
            let square = self.squares[row as usize];
            let scale = best_scale(goal.colours, &colours, square);
            let error = error(goal.colours, &colours, scale);
            if error <= best.0 {
                best = (error, Some((row, scale)));
            }
        }
        best.1
    }

    pub(super) fn push(&mut self, entries: &[(u32, f32)], colours: &[f32]) -> u32 {
        self.index.extend(entries.iter().map(|entry| entry.0));
        self.scale.extend(entries.iter().map(|entry| entry.1));
        self.squares.push(0.0);
        self.book.push(Features::default());
        let row = self.len() as u32 - 1;
        self.set_colours(row, colours);
        row
    }

    /// Tells what a row's colours are.
    pub(super) fn set_colours(&mut self, row: u32, colours: &[f32]) {
        let square = dot(colours, colours);
        self.squares[row as usize] = square;
        let features = self.features(colours, square);
        self.book.set(row as usize, features);
    }
}

/// The scale of `colours` that comes nearest to `goal`.
pub(super) fn best_scale(goal: &[f32], colours: &[f32], square: f32) -> f32 {
    if square > 0.0 { (dot(goal, colours) / square).max(0.0) } else { 0.0 }
}

/// Sum of squares.
pub(super) fn error(goal: &[f32], colours: &[f32], scale: f32) -> f32 {
    let (goals, goal_tail) = goal.as_chunks::<8>();
    let (colour_chunks, colour_tail) = colours.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (goal, colours) in goals.iter().zip(colour_chunks) {
        for lane in 0..8 {
            let difference = goal[lane] - scale * colours[lane];
            sums[lane] += difference * difference;
        }
    }
    let tail = goal_tail.iter().zip(colour_tail).map(|(g, c)| (g - scale * c).powi(2));
    sums.iter().sum::<f32>() + tail.sum::<f32>()
}
