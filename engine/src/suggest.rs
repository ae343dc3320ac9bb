//! "Did you mean": the known name closest to a misspelt one.

/// The closest of the known names, if one is close enough to be meant.
pub fn closest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let similarity = |candidate: &str| {
        let (a, b) = (name.to_lowercase(), candidate.to_lowercase());
        // `candidates` for `lazy.candidates` is meant even though half of the letters are missing.
        let tail = b.rsplit('.').next().unwrap_or(&b);
        // Jaro-Winkler is made for longer names: it finds `ot` and `out` unlike.
        let one_edit = a.len() > 1 && b.len() > 1 && strsim::damerau_levenshtein(&a, &b) == 1;
        let one_edit = if one_edit { 0.8 } else { 0.0 };
        strsim::jaro_winkler(&a, &b).max(0.98 * strsim::jaro_winkler(&a, tail)).max(one_edit)
    };
    known
        .into_iter()
        .map(|candidate| (similarity(candidate), candidate))
        .filter(|(score, _)| *score >= 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0).then_with(|| b.1.cmp(a.1)))
        .map(|(_, candidate)| candidate.to_owned())
}

#[cfg(test)]
mod tests {
    use super::closest;

    #[test]
    fn near_names_are_suggested_and_far_ones_not() {
        assert_eq!(closest("exemplr", ["mesh", "exemplar"]).as_deref(), Some("exemplar"));
        assert_eq!(closest("candidates", ["lazy.candidates", "io.read"]).as_deref(), Some("lazy.candidates"));
        assert_eq!(closest("zzz", ["mesh", "exemplar"]), None);
        assert_eq!(closest("ot", ["out", "in"]).as_deref(), Some("out"));
        assert_eq!(closest("c", ["a", "b"]), None);
        assert_eq!(closest("x", []), None);
    }
}
