//! Path accuracy AT and path repeatability RT.
//!
//! ```text
//! AT_p = max_i ‖x̄_i − x_ci‖        RT_p = max_i [ l̄_i + 3 S_li ]
//! ```
//!
//! At each commanded point i of the path, x_ij is where the path attained in cycle j passes through the plane that is normal to the commanded path
//! there, between two measured points. Planes through which some cycle does not pass are left out: at the ends of the path. Source: ISO
//! 9283:1998, 8.2 and 8.3.

use crate::error::AcceptanceError;
use crate::figure::Figure;
use crate::pose::{PoseFigures, pose_figures};
use nalgebra::Vector3;

/// AT and RT of one path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathFigures {
    /// Number of cycles.
    pub cycles: usize,
    /// Number of commanded points.
    pub points: usize,
    /// Points at which every cycle passes through the plane.
    pub evaluated: usize,
    /// AT_p, m: the figure of the worst point.
    pub at: Figure,
    /// Number of that point, from 0.
    pub at_point: usize,
    /// RT_p, m: the figure of the worst point.
    pub rt: Figure,
    /// Number of that point, from 0.
    pub rt_point: usize,
    /// Deviation of the mean from the command at each evaluated point, m.
    pub deviations: Vec<(usize, f64)>,
}

/// Of the commanded points and the attained ones of each cycle, m, in the order of the path.
///
/// # Errors
/// With fewer than two cycles or two different commanded points, or where no plane is passed by every cycle.
pub fn path_figures(
    commanded: &[Vector3<f64>],
    cycles: &[Vec<Vector3<f64>>],
    common: f64,
) -> Result<PathFigures, AcceptanceError> {
    let wrong = |reason| AcceptanceError::Path { reason };
    if cycles.len() < 2 {
        return Err(wrong("it was measured in fewer than two cycles"));
    }
    if commanded.len() < 2 {
        return Err(wrong("it has fewer than two commanded points"));
    }
    let mut figures: Vec<(usize, PoseFigures)> = Vec::new();
    // Each cycle goes on from the segment in which it passed the plane before: a path may cross itself.
    let mut at = vec![0; cycles.len()];
    for (i, point) in commanded.iter().enumerate() {
        let along = commanded[(i + 1).min(commanded.len() - 1)] - commanded[i.saturating_sub(1)];
        let length = along.norm();
        if length <= 0.0 {
            continue;
        }
        let normal = along / length;
        // A point of the path lies no farther away than its neighbours: a plane has no end, but the path bends.
        let reach = length;
        let crossings: Vec<Option<(usize, Vector3<f64>)>> = cycles
            .iter()
            .zip(&at)
            .map(|(cycle, &from)| crossing(cycle, from, point, &normal, reach))
            .collect();
        if crossings.iter().any(Option::is_none) {
            continue;
        }
        let mut deviations = Vec::with_capacity(cycles.len());
        for (from, (segment, passed)) in at.iter_mut().zip(crossings.into_iter().flatten()) {
            *from = segment;
            deviations.push(passed - point);
        }
        figures.push((i, pose_figures(&deviations, &[], common)));
    }
    let worst = |of: fn(&PoseFigures) -> &Figure| {
        let larger = |a: &&(usize, PoseFigures), b: &&(usize, PoseFigures)| {
            of(&a.1).value.total_cmp(&of(&b.1).value).then(b.0.cmp(&a.0))
        };
        figures.iter().max_by(larger).map(|(point, figures)| (*point, *of(figures)))
    };
    let none = wrong(
        "no plane normal to the commanded path is passed by every cycle; is the order of the points right?",
    );
    let ((at_point, at), (rt_point, rt)) = worst(|f| &f.ap).zip(worst(|f| &f.rp)).ok_or(none)?;
    Ok(PathFigures {
        cycles: cycles.len(),
        points: commanded.len(),
        evaluated: figures.len(),
        at,
        at_point,
        rt,
        rt_point,
        deviations: figures.iter().map(|(point, figures)| (*point, figures.ap.value)).collect(),
    })
}

/// Where a polyline first passes through a plane, from this segment on, within `reach` of the plane's point: the segment, and the place.
fn crossing(
    path: &[Vector3<f64>],
    from: usize,
    point: &Vector3<f64>,
    normal: &Vector3<f64>,
    reach: f64,
) -> Option<(usize, Vector3<f64>)> {
    let side = |p: &Vector3<f64>| (p - point).dot(normal);
    // Static repeats stop at the commanded points: the first and the last may lie on either side of their plane by the robot's error.
    let near = |p: &Vector3<f64>| side(p).abs() < 0.05 * reach && (p - point).norm() < reach;
    for k in from..path.len().saturating_sub(1) {
        let (a, b) = (side(&path[k]), side(&path[k + 1]));
        if a <= 0.0 && b > 0.0 || a < 0.0 && b >= 0.0 {
            let place = path[k] + (path[k + 1] - path[k]) * (a / (a - b));
            if (place - point).norm() < reach {
                return Some((k, place));
            }
        }
    }
    // An end of the path that stops short of its plane is carried on along its last segment.
    let ends = [(0, 1), (path.len().checked_sub(1)?, path.len().saturating_sub(2))];
    ends.into_iter().filter(|(end, beside)| end != beside).find_map(|(end, beside)| {
        let along = path.get(end)? - path.get(beside)?;
        let slope = along.dot(normal);
        let close = near(path.get(end)?) && slope.abs() > 0.5 * along.norm();
        close.then(|| (end.min(path.len() - 2).max(from), path[end] - along * (side(&path[end]) / slope)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_line_is_off_by_its_shift_wherever_it_was_sampled() {
        let commanded: Vec<_> = (0..11).map(|k| Vector3::new(0.1 * f64::from(k), 0.0, 0.0)).collect();
        let cycle = |offset: f64, phase: f64| -> Vec<Vector3<f64>> {
            (-1..24).map(|k| Vector3::new(0.05 * (f64::from(k) + phase), 0.002, offset)).collect()
        };
        let cycles = [cycle(1e-4, 0.1), cycle(-1e-4, 0.7), cycle(0.0, 0.4)];
        let found = path_figures(&commanded, &cycles, 0.0).unwrap();
        assert_eq!((found.cycles, found.points, found.evaluated), (3, 11, 11));
        assert!((found.at.value - 0.002).abs() < 1e-12, "{}", found.at.value);
        // Lengths 1e-4, 1e-4 and 0.
        let (mean, sd) =
            (2e-4 / 3.0, (2.0 * (1e-4f64 / 3.0).powi(2) + (2e-4f64 / 3.0).powi(2)).sqrt() / 2f64.sqrt());
        assert!((found.rt.value - (mean + 3.0 * sd)).abs() < 1e-12);
    }

    #[test]
    fn too_little_is_refused() {
        let line = [Vector3::zeros(), Vector3::x()];
        assert!(path_figures(&line, &[line.to_vec()], 0.0).is_err());
        assert!(path_figures(&line[..1], &[line.to_vec(), line.to_vec()], 0.0).is_err());
        let elsewhere = vec![Vector3::new(5.0, 0.0, 0.0), Vector3::new(6.0, 0.0, 0.0)];
        assert!(path_figures(&line, &[elsewhere.clone(), elsewhere], 0.0).is_err());
    }
}
