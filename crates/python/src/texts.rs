//! Columns of texts.

use std::collections::HashMap;
use truepose_io::MemoryColumn;

/// A column of texts, each stored once.
pub fn texts_of<S: Into<String> + AsRef<str>>(texts: impl Iterator<Item = Option<S>>) -> MemoryColumn {
    let mut words: Vec<String> = Vec::new();
    let mut known: HashMap<String, u32> = HashMap::new();
    let mut rows = Vec::new();
    for text in texts {
        rows.push(text.map(|text| {
            if let Some(&word) = known.get(text.as_ref()) {
                return word;
            }
            let word = words.len() as u32;
            words.push(text.into());
            known.insert(words[words.len() - 1].clone(), word);
            word
        }));
    }
    MemoryColumn::Texts { words, rows }
}
