//! Stick figures of a robot, seen from one side: for print, files, and where there is no script.

use super::axes::frame;
use std::fmt::Write;

/// A line, how far its corners are displaced in a second one (or nothing), a point, and the arrows there, mm.
pub(crate) type Drawn<'a> = (&'a [[f64; 3]], &'a [[f64; 3]], &'a [f64; 3], &'a [[f64; 3]]);

/// Lines with a point and arrows at each, around a middle; `factor` exaggerates the arrows.
pub(crate) fn sticks<'a>(
    about: &str,
    list: impl Iterator<Item = Drawn<'a>>,
    middle: [f64; 3],
    size: f64,
    factor: f64,
) -> String {
    const SIDE: f64 = 520.0;
    let scale = 0.46 * SIDE / size;
    let (azimuth, height) = (0.6f64, 0.35f64);
    let project = |v: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|k| v[k] - middle[k]);
        let across = x * azimuth.cos() - y * azimuth.sin();
        let depth = x * azimuth.sin() + y * azimuth.cos();
        (0.5 * SIDE + across * scale, 0.5 * SIDE - (z * height.cos() - depth * height.sin()) * scale)
    };
    let (mut body, mut arrows) = (String::new(), [String::new(), String::new()]);
    for (k, (corners, moved, point, errors)) in list.enumerate() {
        let mut path = String::new();
        for (k, corner) in corners.iter().enumerate() {
            let (x, y) = project(corner);
            let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
        }
        let strength = if k == 0 { 1.0 } else { 0.22 };
        let _ = write!(body, "<path class=\"ink curve\" opacity=\"{strength}\" d=\"{path}\"/>");
        for (k, (corner, by)) in corners.iter().zip(moved).enumerate() {
            let (x, y) = project(&[0, 1, 2].map(|a| corner[a] + factor * by[a]));
            let _ = write!(arrows[1], "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
        }
        for (k, error) in errors.iter().enumerate() {
            let (from, to) = (project(point), project(&[0, 1, 2].map(|a| point[a] + factor * error[a])));
            // The last is the error after.
            let after = usize::from(k + 1 == errors.len());
            let _ = write!(arrows[after], "M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, to.0, to.1);
        }
    }
    for (class, path) in ["before", "after"].iter().zip(&arrows) {
        if !path.is_empty() {
            let _ = write!(body, "<path class=\"{class} curve\" d=\"{path}\"/>");
        }
    }
    frame(SIDE, SIDE, about, &body)
}
