//! A plot: two linear axes, and marks in the units of the data.

use super::{cut, escape};
use std::fmt::Write;

const LEFT: f64 = 58.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = 40.0;

/// One panel of a figure, being drawn.
pub(crate) struct Plot {
    width: f64,
    height: f64,
    x: [f64; 2],
    y: [f64; 2],
    body: String,
    outside: usize,
}

impl Plot {
    /// Width and height in pixels; ranges in the units of the data, widened where they are empty.
    pub(crate) fn new(width: f64, height: f64, x: [f64; 2], y: [f64; 2]) -> Self {
        Plot { width, height, x: opened(x), y: opened(y), body: String::new(), outside: 0 }
    }

    /// Grid, numbers and names of the axes.
    pub(crate) fn axes(mut self, title: &str, x: &str, y: &str) -> Self {
        let (right, bottom) = (self.width - RIGHT, self.height - BOTTOM);
        // Letters of 12 px that find room along an axis.
        let [along, up] = [right - LEFT, bottom - TOP].map(|length| (length / 6.4) as usize);
        for tick in ticks(self.y, 5) {
            let at = self.down(tick);
            let _ = write!(
                self.body,
                "<path class=\"grid\" d=\"M{LEFT} {at:.1}H{right}\"/><text class=\"soft\" x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                at + 4.0,
                number(tick)
            );
        }
        let many = ((self.width - LEFT - RIGHT) / 75.0) as usize;
        for tick in ticks(self.x, many.clamp(2, 9)) {
            let at = self.across(tick);
            let _ = write!(
                self.body,
                "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/><text class=\"soft\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 16.0,
                number(tick)
            );
        }
        let _ = write!(
            self.body,
            "<path class=\"axis\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/><text x=\"{LEFT}\" y=\"14\" font-weight=\"600\">{}</text>\
             <text class=\"soft\" x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <text class=\"soft\" transform=\"translate(12 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(&cut(title, along)),
            bottom + 33.0,
            escape(&cut(x, along)),
            0.5 * (TOP + bottom),
            escape(&cut(y, up))
        );
        self
    }

    /// Points, of which those outside of the plot are counted and drawn at its edge; few of them are larger, and hide nothing.
    pub(crate) fn dots(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        const FEW: usize = 60;
        let (mut path, mut count) = (String::new(), 0);
        for (x, y) in points.filter(|(x, y)| x.is_finite() && y.is_finite()) {
            self.outside += usize::from(y < self.y[0] || y > self.y[1]);
            let y = y.clamp(self.y[0], self.y[1]);
            let _ = write!(path, "M{:.1} {:.1}h0", self.across(x), self.down(y));
            count += 1;
        }
        if !path.is_empty() {
            let few = if count <= FEW && class.ends_with("dots") { " few" } else { "" };
            let _ = write!(self.body, "<path class=\"{class}{few}\" d=\"{path}\"/>");
        }
    }

    /// A line through points.
    pub(crate) fn line(&mut self, class: &str, points: &[(f64, f64)]) {
        let mut path = String::new();
        for (k, (x, y)) in points.iter().enumerate() {
            let y = y.clamp(self.y[0], self.y[1]);
            let _ =
                write!(path, "{}{:.1} {:.1}", if k == 0 { "M" } else { "L" }, self.across(*x), self.down(y));
        }
        if !path.is_empty() {
            let _ = write!(self.body, "<path class=\"{class}\" d=\"{path}\"/>");
        }
    }

    /// A line through points, dashed where neighbours are farther apart than `gap`: there are no data between them.
    pub(crate) fn line_over_data(&mut self, class: &str, points: &[(f64, f64)], gap: f64) {
        for (k, piece) in points.chunk_by(|a, b| (b.0 - a.0).abs() <= gap).enumerate() {
            if k > 0 {
                let begin = points.iter().position(|p| p.0.total_cmp(&piece[0].0).is_eq()).unwrap_or(0);
                self.line(&format!("{class} dash"), &points[begin.saturating_sub(1)..=begin]);
            }
            self.line(class, piece);
        }
    }

    /// An area between two lines: (x, lower, upper).
    pub(crate) fn band(&mut self, points: &[(f64, f64, f64)]) {
        let mut path = String::new();
        let mut add = |x: f64, y: f64| {
            let y = y.clamp(self.y[0], self.y[1]);
            let _ = write!(
                path,
                "{}{:.1} {:.1}",
                if path.is_empty() { "M" } else { "L" },
                self.across(x),
                self.down(y)
            );
        };
        points.iter().for_each(|p| add(p.0, p.1));
        points.iter().rev().for_each(|p| add(p.0, p.2));
        if !path.is_empty() {
            let _ = write!(self.body, "<path class=\"band\" d=\"{path}Z\"/>");
        }
    }

    /// Marks that could not be shown where they are.
    pub(crate) fn outside(&self) -> usize {
        self.outside
    }

    /// Points with a text each, shown where the pointer rests.
    pub(crate) fn named_dots(&mut self, class: &str, points: impl Iterator<Item = (f64, f64, String)>) {
        for (x, y, name) in points.filter(|(x, y, _)| x.is_finite() && y.is_finite()) {
            self.outside += usize::from(y < self.y[0] || y > self.y[1]);
            let y = y.clamp(self.y[0], self.y[1]);
            let _ = write!(
                self.body,
                "<path class=\"{class}\" d=\"M{:.1} {:.1}h0\"><title>{}</title></path>",
                self.across(x),
                self.down(y),
                escape(&name)
            );
        }
    }

    /// A cell between two corners, the stronger the larger `strength` (0…1), with the text of its value.
    pub(crate) fn cell(&mut self, class: &str, [low, high]: [[f64; 2]; 2], strength: f64, words: &str) {
        let (left, right) = (self.across(low[0]), self.across(high[0]));
        let (bottom, top) = (self.down(low[1]), self.down(high[1]));
        let _ = write!(
            self.body,
            "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" opacity=\"{strength:.2}\"><title>{}</title></rect>",
            right - left,
            bottom - top,
            escape(words)
        );
    }

    /// The panel without its frame, shifted right and down by so many pixels.
    pub(crate) fn panel(&self, [right, down]: [f64; 2]) -> String {
        format!("<g transform=\"translate({right} {down})\">{}</g>", self.body)
    }

    /// The figure; `about` is its text alternative.
    pub(crate) fn finish(&self, about: &str) -> String {
        frame(self.width, self.height, about, &self.body)
    }

    fn across(&self, x: f64) -> f64 {
        LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]) * (self.width - LEFT - RIGHT)
    }

    fn down(&self, y: f64) -> f64 {
        let bottom = self.height - BOTTOM;
        bottom - (y - self.y[0]) / (self.y[1] - self.y[0]) * (bottom - TOP)
    }
}

/// An SVG of this size around a body.
pub(crate) fn frame(width: f64, height: f64, about: &str, body: &str) -> String {
    let about = escape(about);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" style=\"max-width:{:.0}px;min-width:{:.0}px\" role=\"img\" aria-label=\"{about}\"><title>{about}</title>{body}</svg>",
        1.2 * width,
        if width > 500.0 { 0.75 * width } else { 0.0 }
    )
}

fn opened([low, high]: [f64; 2]) -> [f64; 2] {
    if !low.is_finite() || !high.is_finite() {
        return [0.0, 1.0];
    }
    let width = high - low;
    if width > 1e-12 * low.abs().max(high.abs()).max(1e-300) {
        return [low, high];
    }
    let by = if low.abs() > 0.0 { 0.1 * low.abs() } else { 1.0 };
    [low - by, high + by]
}

/// Round numbers in a range: as many as are nearest to `about`, and never a single one.
fn ticks([low, high]: [f64; 2], about: usize) -> Vec<f64> {
    let about = about.max(2) as i64;
    let power = 10f64.powf(((high - low) / about as f64).log10().floor());
    let spanned = |step: f64| ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
    let number = |step: f64| spanned(step).1.saturating_sub(spanned(step).0) + 1;
    let step = [0.5, 1.0, 2.0, 5.0, 10.0]
        .map(|k| k * power)
        .into_iter()
        .filter(|step| number(*step) > 1)
        .min_by_key(|step| (number(*step) - about).abs())
        .unwrap_or(power);
    let (first, last) = spanned(step);
    (first..=last.min(first.saturating_add(40))).map(|k| k as f64 * step).collect()
}

fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" || value.abs() < 1e-12 {
        return "0".into();
    }
    if value.abs() < 1e-4 || value.abs() >= 1e6 { format!("{value:.1e}") } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            ticks([0.0, 1.0], 5).iter().map(|t| number(*t)).collect::<Vec<_>>(),
            ["0", "0.2", "0.4", "0.6", "0.8", "1"]
        );
        for t in ticks([-3.3, 17.2], 5) {
            assert!((-3.3..=17.2).contains(&t));
        }
        // A narrow panel has more than one number on its axis.
        for range in [[1.0, 360.0], [-57.0, 72.0], [19.6, 21.3], [1.0, 11911.0], [-181.0, 46.0]] {
            let count = ticks(range, 3).len();
            assert!((2..=5).contains(&count), "{range:?}: {count}");
        }
    }

    #[test]
    fn a_line_is_dashed_where_there_are_no_data() {
        let mut plot = Plot::new(300.0, 200.0, [0.0, 10.0], [0.0, 1.0]);
        plot.line_over_data("curve", &[(0.0, 0.1), (1.0, 0.2), (8.0, 0.5), (9.0, 0.4)], 2.0);
        let svg = plot.finish("about");
        assert_eq!(
            (svg.matches("class=\"curve\"").count(), svg.matches("class=\"curve dash\"").count()),
            (2, 1)
        );
    }

    #[test]
    fn an_empty_range_is_opened_and_what_is_outside_is_counted() {
        let mut plot = Plot::new(300.0, 200.0, [2.0, 2.0], [0.0, 1.0]).axes("t", "x", "y");
        plot.dots("dots", [(2.0, 0.5), (2.0, 7.0), (f64::NAN, 0.0)].into_iter());
        assert_eq!(plot.outside(), 1);
        assert!(!plot.finish("about").contains("NaN"));
    }
}
