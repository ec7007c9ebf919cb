//! A document on a page.

use super::Page;
use crate::document::{Block, Document, Only};
use crate::figure::escape;
use crate::layout::Alignment;

impl Page {
    /// The blocks of a document; lines of a list that follow each other become one list.
    pub(crate) fn document(&mut self, document: &Document) {
        let mut items: Vec<String> = Vec::new();
        for (_, block) in document.blocks.iter().filter(|(only, _)| *only != Only::Terminal) {
            if let Block::Item(text) | Block::Warning(text) = block {
                items.push(text.clone());
                continue;
            }
            self.items(&mut items);
            match block {
                Block::Verdict(text) => self.raw(&format!("<p class=\"verdict\">{}</p>", escape(text))),
                Block::Sentence(text) => self.text(text),
                Block::Judged { word, sentence } => self.raw(&format!(
                    "<p><span class=\"badge {}\">{word}</span> {}</p>",
                    word.replace(' ', "_"),
                    escape(sentence)
                )),
                Block::Note(text) => self.note(text.trim()),
                Block::Table { caption, head, sides, rows } => {
                    let head: Vec<&str> = head.iter().map(String::as_str).collect();
                    self.table(&capital(caption), &head, rows, sides.contains(&Alignment::Right));
                }
                Block::Item(_) | Block::Warning(_) | Block::Gap => {}
            }
        }
        self.items(&mut items);
    }

    fn items(&mut self, items: &mut Vec<String>) {
        if !items.is_empty() {
            self.list(&std::mem::take(items));
        }
    }
}

/// With a capital letter at the beginning.
fn capital(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}
