//! Square neighbourhoods of even and odd size.

use crate::lazy::{LevelView, Pixel};

/// A square window of pixels around a centre. With an even size there is one pixel more before the centre than after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Pixels along an edge, 1 to 32.
    pub size: i32,
}

impl Window {
    /// Pixels before the centre, along columns and rows alike.
    pub fn before(self) -> i32 {
        self.size / 2
    }

    /// Pixels after the centre.
    pub fn after(self) -> i32 {
        self.size - 1 - self.before()
    }

    /// Pixels in all.
    pub fn pixels(self) -> usize {
        (self.size * self.size) as usize
    }

    /// The offsets of the pixels from the centre (column, row), row by row.
    pub fn offsets(self) -> impl Iterator<Item = (i32, i32)> {
        let range = -self.before()..self.size - self.before();
        range.clone().flat_map(move |row| range.clone().map(move |column| (column, row)))
    }

    /// The range of columns and of rows that can be centres: anything if the picture continues at its edges, else
    /// where the whole window lies inside. First and last, both included.
    pub fn centres(self, view: &LevelView) -> [(i32, i32); 2] {
        [view.width, view.height]
            .map(|n| if view.tileable { (0, n - 1) } else { (self.before(), n - 1 - self.after()) })
    }

    /// Whether the window fits into the view at all.
    pub fn fits(self, view: &LevelView) -> bool {
        self.size >= 1 && self.size <= view.width.min(view.height)
    }

    /// All centres, row by row.
    pub fn pixels_of(self, view: &LevelView) -> Vec<Pixel> {
        let [(left, right), (top, bottom)] = self.centres(view);
        (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x | y << 8) as Pixel)).collect()
    }

    /// The centre nearest to a place.
    pub fn centre(self, view: &LevelView, x: i32, y: i32) -> Pixel {
        let [(left, right), (top, bottom)] = self.centres(view);
        let (x, y) = if view.tileable {
            (x.rem_euclid(view.width), y.rem_euclid(view.height))
        } else {
            (x.clamp(left, right), y.clamp(top, bottom))
        };
        (x | y << 8) as Pixel
    }

    /// The samples of a window, row by row, four channels each.
    pub fn samples(self, view: &LevelView, centre: Pixel, out: &mut Vec<i16>) {
        let (x, y) = (i32::from(centre & 255), i32::from(centre >> 8));
        out.clear();
        for (dx, dy) in self.offsets() {
            out.extend(view.texel(x + dx, y + dy).map(i16::from));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_and_odd_windows_lie_inside() {
        let view =
            LevelView { width: 9, height: 7, tileable: false, texels: vec![[0; 4]; 63], barred: Vec::new() };
        for size in 1..=7 {
            let window = Window { size };
            assert_eq!(window.offsets().count(), window.pixels());
            let centres = window.pixels_of(&view);
            assert_eq!(centres.len(), ((9 - size + 1) * (7 - size + 1)) as usize);
            for centre in centres {
                for (dx, dy) in window.offsets() {
                    let (x, y) = (i32::from(centre & 255) + dx, i32::from(centre >> 8) + dy);
                    assert!((0..9).contains(&x) && (0..7).contains(&y));
                }
            }
        }
        assert_eq!(Window { size: 8 }.offsets().next(), Some((-4, -4)));
        assert_eq!(Window { size: 8 }.offsets().last(), Some((3, 3)));
    }
}
