//! A result as a document: blocks of words and figures, each formed once, which the terminal and the page render.
//!
//! [`Document`] displays itself as lines for a terminal; [`Page::document`](crate::page::Page::document) makes paragraphs and tables of the same
//! blocks.

use crate::layout::{Alignment, table};
use std::fmt;

/// Where a block is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Only {
    /// Everywhere.
    Both,
    /// In the terminal: the page has the same figures in a picture or a table.
    Terminal,
    /// On the page: the terminal has the same figures in a line.
    Page,
}

/// A part of a document.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Block {
    /// The sentence that stands first.
    Verdict(String),
    /// A sentence.
    Sentence(String),
    /// A sentence that begins with a word of two or three: `pass`, `fail`, `not decided`.
    Judged { word: &'static str, sentence: String },
    /// What a reader has to be warned of.
    Warning(String),
    /// Small print of what stands above.
    Note(String),
    /// A line of a list.
    Item(String),
    /// A blank line of the terminal.
    Gap,
    /// A table: caption, heads and alignments of the columns, cells of each row.
    Table { caption: String, head: Vec<String>, sides: Vec<Alignment>, rows: Vec<Vec<String>> },
}

/// Blocks in the order in which they are read.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Document {
    pub blocks: Vec<(Only, Block)>,
}

impl Document {
    /// Adds a block.
    pub(crate) fn push(&mut self, only: Only, block: Block) {
        self.blocks.push((only, block));
    }

    /// Adds the sentence that stands first.
    pub(crate) fn verdict(&mut self, text: impl Into<String>) {
        self.push(Only::Both, Block::Verdict(text.into()));
    }

    /// Adds a sentence; nothing for an empty text, and several for a text of several lines.
    pub(crate) fn sentence(&mut self, text: &str) {
        text.lines().for_each(|line| self.push(Only::Both, Block::Sentence(line.into())));
    }

    /// Adds sentences.
    pub(crate) fn sentences<T: AsRef<str>>(&mut self, all: impl IntoIterator<Item = T>) {
        all.into_iter().for_each(|text| self.sentence(text.as_ref()));
    }

    /// Adds small print.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.push(Only::Both, Block::Note(text.into()));
    }

    /// Adds a table; a caption that begins with a small letter has a capital one on the page.
    pub(crate) fn table(
        &mut self,
        caption: impl Into<String>,
        head: &[&str],
        sides: &[Alignment],
        rows: Vec<Vec<String>>,
    ) {
        let head = head.iter().map(ToString::to_string).collect();
        let block = Block::Table { caption: caption.into(), head, sides: sides.to_vec(), rows };
        self.push(Only::Both, block);
    }
}

impl fmt::Display for Document {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (_, block) in self.blocks.iter().filter(|(only, _)| *only != Only::Page) {
            match block {
                Block::Verdict(text) | Block::Sentence(text) | Block::Judged { sentence: text, .. } => {
                    writeln!(f, "{text}")?;
                }
                Block::Warning(text) => writeln!(f, "warning: {text}")?,
                Block::Note(text) => writeln!(f, " {text}")?,
                Block::Item(text) => writeln!(f, "  {text}")?,
                Block::Gap => writeln!(f)?,
                Block::Table { caption, head, sides, rows } => {
                    let head: Vec<&str> = head.iter().map(String::as_str).collect();
                    write!(f, "\n{caption}\n{}", table(&head, sides, rows))?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::Page;

    #[test]
    fn terminal_and_page_have_the_same_words() {
        let mut document = Document::default();
        document.verdict("Adequate.");
        document.sentence("One.\nTwo.");
        document.push(Only::Both, Block::Warning("<few> rows".into()));
        document.push(Only::Page, Block::Note("page".into()));
        document.push(Only::Terminal, Block::Item("line".into()));
        document.table(
            "errors, mm",
            &["axis", "RMS"],
            &[Alignment::Left, Alignment::Right],
            vec![vec!["x".into(), "0.1".into()]],
        );
        let text =
            "Adequate.\nOne.\nTwo.\nwarning: <few> rows\n  line\n\nerrors, mm\n  axis  RMS\n  x     0.1\n";
        assert_eq!(document.to_string(), text);
        let mut page = Page::new("title");
        page.document(&document);
        let html = page.finish().html;
        for part in [
            "verdict\">Adequate.</p><p>One.</p><p>Two.</p>",
            "<li>&lt;few&gt; rows</li>",
            "Errors, mm</caption>",
        ] {
            assert!(html.contains(part), "{part}: {html}");
        }
        assert!(html.contains(">page</p>") && !html.contains(">line<"), "{html}");
    }
}
