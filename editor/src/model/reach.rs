//! Walks along links.

use std::collections::BTreeSet;

/// Where one comes from some places by going on and on, they among them: nearest first, each once.
pub fn reach<P: Ord + Copy, N: IntoIterator<Item = P>>(
    from: impl IntoIterator<Item = P>,
    next: impl Fn(P) -> N,
) -> Vec<P> {
    let mut seen = BTreeSet::new();
    let mut found: Vec<P> = from.into_iter().filter(|place| seen.insert(*place)).collect();
    let mut at = 0;
    while let Some(place) = found.get(at).copied() {
        at += 1;
        found.extend(next(place).into_iter().filter(|place| seen.insert(*place)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_end_and_the_nearest_come_first() {
        let next = |n: i32| [n * 2 % 8, n * 3 % 8];
        assert_eq!(reach([1], next), [1, 2, 3, 4, 6, 0]);
        assert_eq!(reach([5, 5], |_| None), [5]);
        assert!(reach([], next).is_empty());
    }
}
