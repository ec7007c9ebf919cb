//! Figures as SVG text: drawn with classes, coloured by the page's style or by [`standalone`].

mod axes;
mod bars;
mod chart;
mod cloud;
mod heat;
mod sticks;
mod thin;
mod trace;

pub(crate) use axes::Plot;
pub(crate) use bars::{Bar, bars, waterfall};
pub(crate) use chart::{Chart, cell, cells_for, chart, range};
pub(crate) use cloud::cloud;
pub(crate) use heat::heat_map;
pub(crate) use sticks::sticks;
pub(crate) use thin::{bins, quantile, thin};
pub(crate) use trace::trace_figure;

/// Colours of figures, as the page and the files have them.
pub(crate) const COLOURS: &str = include_str!("colours.css");

/// Text that may stand between tags and in attributes.
pub(crate) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // No control characters, and no U+FFFE or U+FFFF: they are no XML.
            c if c.is_control() && c != '\n' && c != '\t' => safe.push('\u{fffd}'),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// A text of at most so many letters; what is longer ends in an ellipsis.
pub(crate) fn cut(text: &str, letters: usize) -> String {
    if text.chars().count() <= letters {
        return text.into();
    }
    text.chars().take(letters.saturating_sub(1)).chain(['…']).collect()
}

/// A unit as people write it.
pub(crate) fn unit_text(unit: &str) -> String {
    unit.replace("degC", "°C").replace("N*m", "N·m")
}

/// A figure as a file of its own: with its colours, light and dark.
pub(crate) fn standalone(svg: &str) -> String {
    let style = format!("<style>{COLOURS}\nsvg{{background:var(--paper)}}</style>");
    match svg.find('>') {
        Some(end) => format!("{}{style}{}\n", &svg[..=end], &svg[end + 1..]),
        None => svg.into(),
    }
}
