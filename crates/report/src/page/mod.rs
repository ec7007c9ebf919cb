//! The report: one self-contained page, and its figures as files.

mod acceptance;
mod blocks;
mod changed;
mod commands;
mod comparison;
mod discovery;
mod identifiability;
mod identification;
mod joint_space;
mod places;
mod program;
mod residuals;
mod robot;
mod rows;
mod sheet;
mod space;

pub use acceptance::acceptance_report;
pub use changed::{ChangedLine, changed_lines};
pub use commands::{CommandView, CommandsView, commands_report};
pub use comparison::comparison_report;
pub use discovery::discovery_report;
pub use identification::identification_report;
pub use places::{
    MapView, PlaceView, PlanView, PlannedView, PredictionView, map_report, plan_report, prediction_report,
};
pub use program::{CorrectionView, OffsetView, ProgramView, program_report};

use crate::RunRecord;
use crate::figure::{COLOURS, escape, standalone};
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = concat!(include_str!("script.js"), include_str!("robot.js"));

/// A page and its figures, ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// `index.html`.
    pub html: String,
    /// `summary.html`: the first sheet alone, which prints to one page; empty where the page has none.
    pub summary: String,
    /// Names and contents of the figures' files (SVG).
    pub figures: Vec<(String, String)>,
}

/// A page that is being put together.
pub(crate) struct Page {
    title: String,
    body: String,
    contents: Vec<(String, String)>,
    figures: Vec<(String, String)>,
    /// Where the first sheet ends in the body.
    sheet: Option<usize>,
}

impl Page {
    /// With this title (text).
    pub(crate) fn new(title: &str) -> Self {
        Page {
            title: title.into(),
            body: String::new(),
            contents: Vec::new(),
            figures: Vec::new(),
            sheet: None,
        }
    }

    /// A part of the page, which is in its contents.
    pub(crate) fn section(&mut self, title: &str) {
        let id = format!("part-{}", self.contents.len() + 1);
        let _ = write!(self.body, "<h2 id=\"{id}\">{}</h2>", escape(title));
        self.contents.push((id, title.into()));
    }

    /// A title within a part.
    pub(crate) fn title(&mut self, title: &str) {
        let _ = write!(self.body, "<h3>{}</h3>", escape(title));
    }

    /// A paragraph of text.
    pub(crate) fn text(&mut self, text: &str) {
        let _ = write!(self.body, "<p>{}</p>", escape(text));
    }

    /// A paragraph in small print; nothing for an empty text.
    pub(crate) fn note(&mut self, text: &str) {
        if text.is_empty() {
            return;
        }
        let _ = write!(self.body, "<p class=\"note\">{}</p>", escape(text));
    }

    /// Items of text.
    pub(crate) fn list(&mut self, items: &[String]) {
        self.body += "<ul>";
        for item in items {
            let _ = write!(self.body, "<li>{}</li>", escape(item));
        }
        self.body += "</ul>";
    }

    /// A table of texts; the first column is names, the others numbers where `numbers`.
    pub(crate) fn table(&mut self, caption: &str, head: &[&str], rows: &[Vec<String>], numbers: bool) {
        let class = if numbers { " class=\"numbers\"" } else { "" };
        let _ = write!(
            self.body,
            "<div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{0}\"><table{class}><caption>{0}</caption><thead><tr>",
            escape(caption)
        );
        for cell in head {
            let _ = write!(self.body, "<th scope=\"col\">{}</th>", escape(cell));
        }
        self.body += "</tr></thead><tbody>";
        for row in rows {
            self.body += "<tr>";
            for (k, cell) in row.iter().enumerate() {
                let _ = match k {
                    0 => write!(self.body, "<th scope=\"row\">{}</th>", escape(cell)),
                    _ => write!(self.body, "<td>{}</td>", escape(cell)),
                };
            }
            self.body += "</tr>";
        }
        self.body += "</tbody></table></div>";
    }

    /// A figure with its caption; it also becomes a file.
    pub(crate) fn figure(&mut self, name: &str, svg: &str, caption: &str) {
        let file = format!("{name}.svg");
        let _ = write!(
            self.body,
            "<figure><div class=\"wide\" tabindex=\"0\" role=\"group\" aria-label=\"{file}\">{svg}</div><figcaption>{} <a href=\"{file}\">{file}</a></figcaption></figure>",
            escape(caption)
        );
        self.figures.push((file, standalone(svg)));
    }

    /// Figures beside each other, or under each other where the page is narrow; each becomes a file.
    pub(crate) fn figures(&mut self, name: &str, svgs: &[String], caption: &str) {
        let named = svgs.iter().enumerate().map(|(k, svg)| (format!("{name}_{}", k + 1), standalone(svg)));
        let files: Vec<(String, String)> = named.map(|(name, svg)| (format!("{name}.svg"), svg)).collect();
        self.side_by_side(svgs, caption, &files.iter().map(|f| f.0.clone()).collect::<Vec<_>>());
        self.figures.extend(files);
    }

    /// Figures beside each other, of which one file shows all.
    pub(crate) fn figure_of_two(&mut self, name: &str, svgs: &[String], whole: &str, caption: &str) {
        let file = format!("{name}.svg");
        self.side_by_side(svgs, caption, std::slice::from_ref(&file));
        self.figures.push((file, standalone(whole)));
    }

    fn side_by_side(&mut self, svgs: &[String], caption: &str, files: &[String]) {
        let links: Vec<String> = files.iter().map(|file| format!("<a href=\"{file}\">{file}</a>")).collect();
        let _ = write!(
            self.body,
            "<figure><div class=\"pair\">{}</div><figcaption>{} {}</figcaption></figure>",
            svgs.concat(),
            escape(caption),
            links.join(" ")
        );
    }

    /// A figure that is a file, and on the page only where there is no script.
    pub(crate) fn fallback_figure(&mut self, name: &str, svg: &str) {
        let _ = write!(self.body, "<noscript>{svg}</noscript>");
        self.figures.push((format!("{name}.svg"), standalone(svg)));
    }

    /// Markup; the caller escapes texts.
    pub(crate) fn raw(&mut self, html: &str) {
        self.body += html;
    }

    /// Program, command and files: what reproduces the run.
    pub(crate) fn reproduction(&mut self, run: &RunRecord) {
        self.text(&format!(
            "Made by {}. This command, run in the same folder, reproduces the same bytes:",
            run.program
        ));
        let arguments: Vec<String> = run.arguments.iter().map(|a| quoted(a)).collect();
        let _ = write!(self.body, "<pre tabindex=\"0\">truepose {}</pre>", escape(&arguments.join(" ")));
        self.text("`truepose verify run.json` (the file beside this page) repeats the run and compares the results.");
        self.raw("<div class=\"files\">");
        let rows: Vec<Vec<String>> = run
            .inputs
            .iter()
            .chain(std::iter::once(&run.result))
            .map(|f| vec![f.file.clone(), f.bytes.to_string(), f.sha256.clone()])
            .collect();
        self.table("Files", &["file", "bytes", "SHA-256"], &rows, false);
        self.raw("</div>");
    }

    /// The whole page.
    pub(crate) fn finish(self) -> Report {
        let title = escape(&self.title);
        let mut contents = String::new();
        for (id, name) in &self.contents {
            let _ = write!(contents, "<a href=\"#{id}\">{}</a>", escape(name));
        }
        let whole = |class: &str, main: &str, nav: &str| {
            format!(
                "<!doctype html>\n<html lang=\"en\"{class}><head><meta charset=\"utf-8\">\
                 <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
                 <meta name=\"color-scheme\" content=\"light dark\">\
                 <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\
                 <link rel=\"icon\" href=\"data:,\"><title>{title}</title><style>{COLOURS}\n{STYLE}</style></head>\
                 <body><header><h1>{title}</h1><nav aria-label=\"Parts\">{nav}</nav></header><main>{main}</main>\
                 <script>{SCRIPT}</script></body></html>\n"
            )
        };
        let Some(end) = self.sheet else {
            return Report {
                html: whole("", &self.body, &contents),
                summary: String::new(),
                figures: self.figures,
            };
        };
        let (sheet, rest) = self.body.split_at(end);
        let first = "<a href=\"summary.html\">one-page summary</a>";
        let html =
            whole("", &format!("<div class=\"sheet\">{sheet}</div>{rest}"), &format!("{contents}{first}"));
        let back = "<a href=\"index.html\">whole report</a>";
        let summary = whole(" class=\"one-sheet\"", &format!("<div class=\"sheet\">{sheet}</div>"), back);
        Report { html, summary, figures: self.figures }
    }
}

/// An argument, quoted for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_shown_and_not_run() {
        let evil = "<img src=x onerror=alert(1)>";
        let mut page = Page::new(evil);
        page.section(evil);
        page.text(evil);
        page.list(&[evil.into()]);
        page.table(evil, &[evil], &[vec![evil.into(), evil.into()]], true);
        let report = page.finish();
        assert!(!report.html.contains("<img"));
        assert!(report.html.matches("&lt;img src=x onerror=alert(1)&gt;").count() >= 8);
    }

    #[test]
    fn arguments_are_quoted_for_a_shell() {
        assert_eq!(quoted("--data=a/b.csv"), "--data=a/b.csv");
        assert_eq!(quoted("huber(qr)"), "'huber(qr)'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
