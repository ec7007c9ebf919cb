//! Errors in space, seen from one side: for print, files, and where there is no script.

use super::axes::frame;
use super::escape;
use std::fmt::Write;

/// Clouds of error vectors (mm) in one scale, each with the sphere of the specification (mm).
pub(crate) fn cloud(
    about: &str,
    titles: &[String],
    clouds: &[&[[f64; 3]]],
    sphere: Option<(f64, String)>,
) -> String {
    const SIDE: f64 = 380.0;
    let reach = clouds
        .iter()
        .flat_map(|c| c.iter())
        .map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt())
        .chain(sphere.iter().map(|s| s.0))
        .fold(f64::MIN_POSITIVE, f64::max);
    let scale = 0.43 * SIDE / reach;
    let (azimuth, height) = (0.6f64, 0.45f64);
    let project = |v: [f64; 3]| {
        let x = v[0] * azimuth.cos() - v[1] * azimuth.sin();
        let depth = v[0] * azimuth.sin() + v[1] * azimuth.cos();
        (x * scale, -(v[2] * height.cos() - depth * height.sin()) * scale)
    };
    let mut body = String::new();
    for (k, (title, points)) in titles.iter().zip(clouds).enumerate() {
        let (cx, cy) = (SIDE * (k as f64 + 0.5), 0.5 * SIDE + 16.0);
        let _ = write!(
            body,
            "<text x=\"{cx:.1}\" y=\"14\" text-anchor=\"middle\" font-weight=\"600\">{}</text>",
            escape(title)
        );
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let mut end = [0.0; 3];
            end[axis] = 0.95 * reach;
            let (x, y) = project(end);
            let _ = write!(
                body,
                "<path class=\"axis\" opacity=\".6\" d=\"M{cx:.1} {cy:.1}l{x:.1} {y:.1}\"/><text class=\"soft\" x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                cx + x + 3.0,
                cy + y
            );
        }
        let mut path = String::new();
        for point in points.iter() {
            let (x, y) = project(*point);
            let _ = write!(path, "M{:.1} {:.1}h0", cx + x, cy + y);
        }
        let class = if k + 1 == clouds.len() { "after" } else { "before" };
        let _ = write!(body, "<path class=\"{class} dots\" d=\"{path}\"/>");
        if let Some((radius, name)) = &sphere {
            let r = radius * scale;
            let _ = write!(
                body,
                "<circle class=\"ink thinline dash\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{r:.1}\"/><text x=\"{cx:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                (cy + r + 14.0).min(SIDE + 30.0),
                escape(name)
            );
        }
    }
    frame(SIDE * clouds.len() as f64, SIDE + 34.0, about, &body)
}
