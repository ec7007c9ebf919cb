//! Position errors before and after as vectors in 3-D, with the sphere of the specification.

use super::Page;
use super::rows::{Rows, length};
use crate::figure::{cloud, escape, thin};
use crate::{count, significant};
use std::fmt::Write;

/// Points of a cloud that are drawn.
const DRAWN: usize = 4000;

impl Page {
    /// The part; `limit` is the specification, mm.
    pub(crate) fn space(&mut self, rows: &Rows, titles: [&str; 2], limit: Option<f64>) {
        let whole: Vec<usize> = (0..rows.len())
            .filter(|&k| length(&rows.before[k]).is_finite() && length(&rows.after[k]).is_finite())
            .collect();
        if whole.is_empty() {
            self.text("No row has all three components of a position: no 3-D picture is drawn.");
            return;
        }
        let sizes: Vec<f64> =
            whole.iter().map(|&k| length(&rows.after[k]).max(1e-3 * length(&rows.before[k]))).collect();
        let drawn: Vec<usize> = thin(&sizes, DRAWN, |_| false).into_iter().map(|k| whole[k]).collect();
        let pick = |list: &[[f64; 3]]| drawn.iter().map(|&k| list[k]).collect::<Vec<_>>();
        let (before, after, place) = (pick(&rows.before), pick(&rows.after), pick(&rows.place));
        let reach = before.iter().chain(&after).map(length).chain(limit).fold(1e-9, f64::max);
        let mut middle = [0.0; 3];
        for (axis, middle) in middle.iter_mut().enumerate() {
            let low = place.iter().map(|v| v[axis]).fold(f64::INFINITY, f64::min);
            *middle = 0.5 * (low + place.iter().map(|v| v[axis]).fold(f64::NEG_INFINITY, f64::max));
        }
        let size = place
            .iter()
            .map(|v| length(&[v[0] - middle[0], v[1] - middle[1], v[2] - middle[2]]))
            .fold(1e-9, f64::max);
        let caption = match limit {
            Some(limit) => format!(
                "sphere: specification {} mm; axes to {} mm",
                significant(limit, 3),
                significant(0.95 * reach, 3)
            ),
            None => format!("axes to {} mm", significant(0.95 * reach, 3)),
        };
        let inside = |list: &[[f64; 3]]| {
            limit.map(|limit| {
                let n = whole.iter().filter(|&&k| length(&list[k]) <= limit).count();
                format!(" ({} of {} inside)", n, whole.len())
            })
        };
        let title =
            |(title, list): (&str, &[[f64; 3]])| format!("{title}{}", inside(list).unwrap_or_default());
        let named: Vec<String> = rows.shown(titles).into_iter().map(title).collect();
        let largest = |list: &[[f64; 3]]| significant(list.iter().map(length).fold(0.0, f64::max), 3);
        let about = if rows.same {
            format!(
                "Position errors as vectors from one origin, {}; largest {} mm",
                titles[0],
                largest(&after)
            )
        } else {
            format!(
                "Position errors as vectors from one origin, {} first, then {}, in one scale; largest {} and {} mm",
                titles[0],
                titles[1],
                largest(&before),
                largest(&after)
            )
        };
        let clouds: Vec<&[[f64; 3]]> =
            [before.as_slice(), after.as_slice()].into_iter().take(named.len()).collect();
        let data = serde_json::json!({
            "titles": named, "clouds": clouds.iter().map(|c| flat(c)).collect::<Vec<_>>(),
            "colours": if rows.same { vec!["--after"] } else { vec!["--before", "--after"] },
            "rows": drawn.iter().map(|&k| rows.row[k] + 1).collect::<Vec<_>>(), "place": flat(&place), "reach": rounded(reach), "size": rounded(size), "middle": middle.map(rounded), "limit": limit,
            "words": caption,
            "placeWords": format!("measured positions; blue: no error, red: {} mm", significant(reach, 3)),
        });
        // A closing tag within a name must not end the script.
        let data = data.to_string().replace('<', "\\u003c");
        self.raw(&format!(
            "<div class=\"bar\"><button type=\"button\" data-mode=\"errors\" aria-pressed=\"true\">error vectors</button>\
             <button type=\"button\" data-mode=\"place\" aria-pressed=\"false\">measured positions</button></div>\
             <figure><canvas id=\"space\" width=\"1040\" height=\"520\" tabindex=\"0\" role=\"img\" aria-label=\"{}\"></canvas>\
             <figcaption>Drag, or use the arrow keys, to rotate; point at a mark for its row and error. <a href=\"errors_in_space.svg\">errors_in_space.svg</a></figcaption></figure>\
             <script type=\"application/json\" id=\"space-data\">{data}</script>",
            escape(&about)
        ));
        let svg = cloud(
            &about,
            &named,
            &clouds,
            limit.map(|limit| (limit, format!("specification {} mm", significant(limit, 3)))),
        );
        self.fallback_figure("errors_in_space", &svg);
        let mut notes = String::new();
        if drawn.len() < whole.len() {
            let _ = write!(
                notes,
                "{} of {} are drawn: the 1 % with the largest errors, and the others at equal steps. ",
                drawn.len(),
                count(whole.len(), "row")
            );
        }
        if whole.len() < rows.len() {
            let _ = write!(
                notes,
                "{} without a complete position are not drawn.",
                count(rows.len() - whole.len(), "row")
            );
        }
        if !notes.is_empty() {
            self.note(&notes);
        }
    }
}

fn flat(list: &[[f64; 3]]) -> Vec<f64> {
    list.iter().flatten().map(|v| rounded(*v)).collect()
}

/// Rounded to four digits, the resolution of the picture.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(0.0)
}
