//! The known word that a mistyped one comes nearest to.

/// The nearest of the known words, if one is near enough to be meant.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    known
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(&word, &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= candidate.chars().count().max(word.chars().count()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// `; did you mean `x`?` or nothing, to end a message with.
pub(crate) fn meant<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |known| format!("; did you mean `{known}`?"))
}

/// Words as a list for a message, cut after a dozen.
pub(crate) fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<&str> = words.into_iter().collect();
    match words.len() {
        0 => "none".into(),
        1..=12 => words.join(", "),
        n => format!("{}, … ({n} in all)", words[..12].join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_only() {
        let known = ["length", "angle"];
        assert_eq!(nearest("lenght", known), Some("length"));
        assert_eq!(nearest("Angle", known), Some("angle"));
        assert_eq!(nearest("mass", known), None);
        assert_eq!(nearest("j9", ["j1", "j2"]), None);
        assert_eq!(meant("angel", known), "; did you mean `angle`?");
        assert_eq!(listed(known), "length, angle");
        assert_eq!(listed([]), "none");
    }
}
