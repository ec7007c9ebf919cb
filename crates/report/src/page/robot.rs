//! The robot as a stick figure at its poses, with the position errors as arrows: turned by hand, and one view as a figure of its own.

use super::Page;
use super::rows::{Rows, length};
use crate::figure::{escape, sticks, thin};
use crate::{count, significant};
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, FrameId, PostureBuffer};

/// Rows that are drawn.
const DRAWN: usize = 48;
/// Length of the largest arrow, of the robot's size.
const ARROW: f64 = 0.16;

/// One pose: corners of the robot from base to tool, and the arrows at its point, mm in the measurement frame.
pub(crate) struct Stick {
    pub corners: Vec<[f64; 3]>,
    /// Where the arrows begin.
    pub point: [f64; 3],
    /// Errors before and after; empty without measurements.
    pub errors: Vec<[f64; 3]>,
    /// How far each corner is displaced, in a second line; empty without one.
    pub moved: Vec<[f64; 3]>,
    pub label: String,
}

/// What the picture shows, in words.
pub(crate) struct Words {
    pub title: &'static str,
    /// Without a full stop.
    pub about: String,
    /// Of the arrows.
    pub arrows: &'static str,
    /// One of the slider's.
    pub item: &'static str,
    pub hint: &'static str,
}

impl Words {
    /// Of a robot at so many poses.
    pub fn of_poses(number: usize) -> Words {
        Words {
            title: "The robot at its poses",
            about: format!("The robot at {}", count(number, "pose")),
            arrows: "position errors",
            item: "pose",
            hint: "point at the end of an arm for its errors",
        }
    }
}

/// Corners of the nominal robot under the conditions of a row, mm.
pub(crate) fn corners(
    chain: &Chain,
    data: &Dataset,
    row: usize,
    buffer: &mut PostureBuffer,
) -> Vec<[f64; 3]> {
    let conditions = data.conditions(row);
    let posture = buffer.update(chain, &conditions);
    // Where the robot branches, the branch that was measured.
    let carries = |frame: &FrameId| chain.carries(*frame, conditions.tool);
    let mut corners: Vec<[f64; 3]> =
        chain.frames().filter(carries).map(|frame| posture.frame(frame).translation.into()).collect();
    let tool = posture.tool();
    corners.push(tool.translation.into());
    if let Some(target) = data.target[row] {
        corners.push(tool.apply(&chain.targets()[target.0].position).into());
    }
    corners.dedup();
    corners.into_iter().map(|corner: [f64; 3]| corner.map(|v| 1e3 * v)).collect()
}

impl Page {
    /// The robot at the rows with the largest errors and at others evenly, with their errors.
    pub(crate) fn robot(&mut self, chain: &Chain, data: &Dataset, rows: &Rows, titles: [&str; 2]) {
        let whole: Vec<usize> = (0..rows.len())
            .filter(|&k| length(&rows.before[k]).is_finite() && length(&rows.after[k]).is_finite())
            .collect();
        let sizes: Vec<f64> = whole.iter().map(|&k| length(&rows.before[k])).collect();
        let drawn: Vec<usize> = thin(&sizes, DRAWN, |_| false).into_iter().map(|k| whole[k]).collect();
        let mut buffer = PostureBuffer::new(chain);
        let stick = |&k: &usize| Stick {
            corners: corners(chain, data, rows.row[k], &mut buffer),
            point: rows.place[k],
            errors: if rows.same { vec![rows.after[k]] } else { vec![rows.before[k], rows.after[k]] },
            moved: Vec::new(),
            label: format!("pose measurement {}, row {}", rows.visit[k], rows.row[k] + 1),
        };
        let list: Vec<Stick> = drawn.iter().map(stick).collect();
        let shown = rows.shown(titles).into_iter().map(|(title, _)| title).collect::<Vec<_>>();
        let note = if list.len() < rows.len() {
            format!("{} of {} are drawn. ", list.len(), count(rows.len(), "row"))
        } else {
            String::new()
        };
        self.sticks(
            &list,
            &shown,
            &Words::of_poses(list.len()),
            &format!("{note}Nominal robot in the measurement frame, without the shape of its links."),
        );
    }

    /// Stick figures; `titles` are those of the arrows.
    pub(crate) fn sticks(&mut self, list: &[Stick], titles: &[&str], words: &Words, note: &str) {
        let all = || list.iter().flat_map(|stick| &stick.corners).copied();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in all() {
            for axis in 0..3 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let size = length(&[0, 1, 2].map(|axis| 0.5 * (high[axis] - low[axis])));
        if list.is_empty() || !size.is_finite() || size <= 0.0 {
            return;
        }
        let middle = [0, 1, 2].map(|axis| 0.5 * (high[axis] + low[axis]));
        let largest = list.iter().flat_map(|stick| &stick.errors).map(length).fold(0.0, f64::max);
        // A round factor, so that lengths can be read.
        let factor = if largest > 0.0 { round_down(2.0 * ARROW * size / largest) } else { 0.0 };
        // What is drawn fits from every side.
        let displaced = |from: &[f64; 3], by: &[f64; 3]| {
            [0, 1, 2].map(|axis| from[axis] + factor * by[axis] - middle[axis])
        };
        let ends = |stick: &Stick| {
            let corners = stick.corners.iter().map(|corner| displaced(corner, &[0.0; 3]));
            let moved = stick.corners.iter().zip(&stick.moved).map(|(corner, by)| displaced(corner, by));
            let arrows = stick.errors.iter().map(|error| displaced(&stick.point, error));
            corners.chain(moved).chain(arrows).map(|end| length(&end)).fold(0.0, f64::max)
        };
        let reach = list.iter().map(ends).fold(0.0, f64::max);
        let arrows = if largest > 0.0 {
            format!(
                "; arrows: {} × {}, largest {} mm",
                words.arrows,
                significant(factor, 1),
                significant(largest, 3)
            )
        } else {
            String::new()
        };
        let about = format!("{}{arrows}", words.about);
        let flat =
            |points: &[[f64; 3]]| -> Vec<f64> { points.iter().flatten().map(|v| rounded(*v)).collect() };
        let data = serde_json::json!({
            "titles": titles,
            "poses": list.iter().map(|stick| serde_json::json!({
                "line": flat(&stick.corners), "at": flat(&[stick.point]), "errors": flat(&stick.errors), "moved": flat(&stick.moved), "name": stick.label,
            })).collect::<Vec<_>>(),
            "factor": factor, "size": rounded(reach), "middle": middle.map(rounded), "words": about,
        });
        let data = data.to_string().replace('<', "\\u003c");
        self.title(words.title);
        let chosen = list.len() - 1;
        self.raw(&format!(
            "<figure><canvas id=\"robot\" width=\"1040\" height=\"620\" tabindex=\"0\" role=\"img\" aria-label=\"{}\"></canvas>\
             <div class=\"bar\"><label>{} <input type=\"range\" id=\"robot-pose\" min=\"0\" max=\"{chosen}\" value=\"0\"></label> <output id=\"robot-name\"></output></div>\
             <figcaption>{} Drag, or use the arrow keys, to rotate; {}. <a href=\"robot.svg\">robot.svg</a></figcaption></figure>\
             <script type=\"application/json\" id=\"robot-data\">{data}</script>",
            escape(&about),
            words.item,
            escape(&format!("{about}. {note}")),
            words.hint
        ));
        let svg = sticks(
            &about,
            list.iter().map(|stick| (&stick.corners[..], &stick.moved[..], &stick.point, &stick.errors[..])),
            middle,
            reach,
            factor,
        );
        self.fallback_figure("robot", &svg);
    }
}

/// One, two or five times a power of ten.
fn round_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    [5.0, 2.0].into_iter().find(|k| k * power <= value).unwrap_or(1.0) * power
}

fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::round_down;

    #[test]
    fn factors_are_round() {
        for (value, round) in [(7.3, 5.0), (430.0, 200.0), (1.9, 1.0), (0.06, 0.05)] {
            assert!((round_down(value) - round).abs() < 1e-12 * round, "{value}");
        }
    }
}
