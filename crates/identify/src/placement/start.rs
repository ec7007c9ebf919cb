//! Starts: closed forms, and the rotations of the cube with everything else linear.

use super::refine::{State, Unknowns};
use super::sight::Sight;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_kinematics::{Chain, Pose, TargetId, ToolId, nearest_rotation};
use truepose_solvers::{LeastSquares, Solver, Svd};

/// All starts worth refining, best guesses first.
pub(super) fn starts(chain: &Chain, unknowns: &Unknowns, sights: &[Sight]) -> Vec<State> {
    let hint = State::of(chain);
    if !unknowns.base {
        return vec![complete(&hint, hint.base.rotation, unknowns, sights)];
    }
    let mut rotations = Vec::new();
    rotations.extend(from_orientations(unknowns, sights, &hint));
    rotations.extend(relaxed(unknowns, sights, &hint));
    rotations.extend(cube());
    rotations.into_iter().map(|rotation| complete(&hint, rotation, unknowns, sights)).collect()
}

/// The 24 rotations of the cube.
fn cube() -> Vec<Matrix3<f64>> {
    let axes: Vec<Vector3<f64>> = (0..6)
        .map(|k| {
            let mut v = Vector3::zeros();
            v[k % 3] = if k < 3 { 1.0 } else { -1.0 };
            v
        })
        .collect();
    let mut rotations = Vec::new();
    for x in &axes {
        for y in &axes {
            if x.dot(y).abs() < 0.5 {
                rotations.push(Matrix3::from_columns(&[*x, *y, x.cross(y)]));
            }
        }
    }
    rotations
}

/// R_B (and R_T) from measured orientations `R_k = R_B R_Fk R_T`: directly when the tool is known, else from
/// the singular vector of `R_k X − Y R_Fk = 0` with X = R_Tᵀ (transposed on the right) and Y = R_B.
fn from_orientations(unknowns: &Unknowns, sights: &[Sight], hint: &State) -> Option<Matrix3<f64>> {
    // Of one tool only: a known one, else the one that was seen most often.
    let oriented = |tool: &ToolId| sights.iter().filter(|s| s.tool == *tool && s.rotation.is_some()).count();
    let seen = (0..hint.tools.len()).map(ToolId).filter(|tool| oriented(tool) > 0);
    let tool = seen.max_by_key(|tool| (!unknowns.tools.contains(tool), oriented(tool)))?;
    let of_tool = sights.iter().filter(|s| s.tool == tool);
    let turned: Vec<(Matrix3<f64>, Matrix3<f64>)> =
        of_tool.filter_map(|s| Some((s.rotation?, s.flange.rotation))).collect();
    if !unknowns.tools.contains(&tool) {
        let known = hint.tools[tool.0].rotation;
        let sum = turned.iter().map(|(r, f)| r * (f * known).transpose()).sum::<Matrix3<f64>>();
        return nearest_rotation(&sum);
    }
    // R_k R_Tᵀ = R_B R_Fk, linear in both: 9 equations a row for 18 unknowns, columns stacked.
    let mut gram = DMatrix::<f64>::zeros(18, 18);
    for (r, f) in &turned {
        let mut rows = DMatrix::<f64>::zeros(9, 18);
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    rows[(3 * j + i, 3 * j + k)] += r[(i, k)];
                    rows[(3 * j + i, 9 + 3 * k + i)] -= f[(k, j)];
                }
            }
        }
        gram += rows.tr_mul(&rows);
    }
    let eigen = gram.symmetric_eigen();
    let smallest = eigen.eigenvalues.imin();
    let v = eigen.eigenvectors.column(smallest);
    let y = Matrix3::from_fn(|i, j| v[9 + 3 * j + i]);
    // A null vector has no sign: the one that makes a rotation of Y is the right one.
    nearest_rotation(&if y.determinant() < 0.0 { -y } else { y })
}

/// R_B from positions alone, with R_Bᵀ relaxed to any matrix M: `M p_k + v − R_Fk y_τ = p_Fk` is linear in M, v, y.
fn relaxed(unknowns: &Unknowns, sights: &[Sight], hint: &State) -> Option<Matrix3<f64>> {
    let (free, known) = points(unknowns, sights, hint);
    let seen: Vec<(&Sight, Vector3<f64>)> = sights.iter().filter_map(|s| Some((s, s.position?))).collect();
    let columns = 12 + 3 * free.len();
    if seen.len() * 3 < columns {
        return None;
    }
    let centre = seen.iter().map(|s| s.1).sum::<Vector3<f64>>() / seen.len() as f64;
    let mut a = DMatrix::<f64>::zeros(3 * seen.len(), columns);
    let mut y = DVector::<f64>::zeros(3 * seen.len());
    for (k, (sight, p)) in seen.iter().enumerate() {
        let fixed = if free.contains(&Point::of(sight)) { Vector3::zeros() } else { known(Point::of(sight)) };
        let q = sight.flange.apply(&fixed);
        for i in 0..3 {
            for j in 0..3 {
                a[(3 * k + i, 3 * i + j)] = p[j] - centre[j];
            }
            a[(3 * k + i, 9 + i)] = 1.0;
            if let Some(place) = free.iter().position(|t| *t == Point::of(sight)) {
                for j in 0..3 {
                    a[(3 * k + i, 12 + 3 * place + j)] = -sight.flange.rotation[(i, j)];
                }
            }
            y[3 * k + i] = q[i];
        }
    }
    let x = Svd::default().solve(&LeastSquares::new(&a, &y)).ok()?.x;
    let m = Matrix3::from_fn(|i, j| x[3 * i + j]);
    nearest_rotation(&m.transpose())
}

/// A point on a flange: a target, or the origin of a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    tool: ToolId,
    target: Option<TargetId>,
}

impl Point {
    fn of(sight: &Sight) -> Self {
        Point { tool: sight.tool, target: sight.target }
    }
}

/// Which seen points are free to be anywhere on the flange, and where the others are.
fn points<'a>(
    unknowns: &Unknowns,
    sights: &[Sight],
    hint: &'a State,
) -> (Vec<Point>, impl Fn(Point) -> Vector3<f64> + 'a) {
    let mut free: Vec<Point> = Vec::new();
    for point in sights.iter().map(Point::of) {
        let of_target = point.target.is_some_and(|t| unknowns.targets.contains(&t));
        if (of_target || unknowns.tools.contains(&point.tool)) && !free.contains(&point) {
            free.push(point);
        }
    }
    (free, move |point| hint.tools[point.tool.0].apply(&hint.point(point.target)))
}

/// With R_B given, the rest is linear: `p_k − R_B p_Fk = t_B + R_B R_Fk y_τ` for the points that are free. Then tool and
/// targets are read off the points.
fn complete(hint: &State, base: Matrix3<f64>, unknowns: &Unknowns, sights: &[Sight]) -> State {
    let (free, known) = points(unknowns, sights, hint);
    let free: Vec<Point> = free
        .into_iter()
        .filter(|t| sights.iter().any(|s| Point::of(s) == *t && s.position.is_some()))
        .collect();
    let seen: Vec<(&Sight, Vector3<f64>)> = sights.iter().filter_map(|s| Some((s, s.position?))).collect();
    let first = if unknowns.base { 3 } else { 0 };
    let mut state = hint.clone();
    state.base.rotation = base;
    for &tool in &unknowns.tools {
        let of_tool = || sights.iter().filter(|s| s.tool == tool);
        let sum = of_tool()
            .filter_map(|s| Some((base * s.flange.rotation).transpose() * s.rotation?))
            .sum::<Matrix3<f64>>();
        if let Some(rotation) = nearest_rotation(&sum).filter(|_| of_tool().any(|s| s.rotation.is_some())) {
            state.tools[tool.0].rotation = rotation;
        }
    }
    if seen.is_empty() {
        return state;
    }
    let mut a = DMatrix::<f64>::zeros(3 * seen.len(), first + 3 * free.len());
    let mut y = DVector::<f64>::zeros(3 * seen.len());
    for (k, (sight, p)) in seen.iter().enumerate() {
        let place = free.iter().position(|t| *t == Point::of(sight));
        let fixed = if place.is_some() { Vector3::zeros() } else { known(Point::of(sight)) };
        let offset = if unknowns.base { Vector3::zeros() } else { hint.base.translation };
        let rest = p - base * sight.flange.apply(&fixed) - offset;
        let turn = base * sight.flange.rotation;
        for i in 0..3 {
            if unknowns.base {
                a[(3 * k + i, i)] = 1.0;
            }
            if let Some(place) = place {
                for j in 0..3 {
                    a[(3 * k + i, first + 3 * place + j)] = turn[(i, j)];
                }
            }
            y[3 * k + i] = rest[i];
        }
    }
    let Ok(solution) = Svd::default().solve(&LeastSquares::new(&a, &y)) else { return state };
    let x = solution.x;
    if unknowns.base {
        state.base.translation = Vector3::new(x[0], x[1], x[2]);
    }
    let point =
        |place: usize| Vector3::new(x[first + 3 * place], x[first + 3 * place + 1], x[first + 3 * place + 2]);
    for &tool in &unknowns.tools {
        let fixed: Vec<(Vector3<f64>, Vector3<f64>)> = free
            .iter()
            .enumerate()
            .filter(|(_, p)| p.tool == tool && p.target.is_none_or(|t| !unknowns.targets.contains(&t)))
            .map(|(place, p)| (hint.point(p.target), point(place)))
            .collect();
        if !fixed.is_empty() {
            let oriented = sights.iter().any(|s| s.tool == tool && s.rotation.is_some());
            state.tools[tool.0] = tool_of(&fixed, &state.tools[tool.0], oriented);
        }
    }
    for (place, at) in free.iter().enumerate() {
        if let Some(t) = at.target.filter(|t| unknowns.targets.contains(t)) {
            state.targets[t.0] = state.tools[at.tool.0].inverse().apply(&point(place));
        }
    }
    state
}

/// The tool's pose that takes known points x (tool axes) to where they are on the flange.
fn tool_of(pairs: &[(Vector3<f64>, Vector3<f64>)], hint: &Pose, oriented: bool) -> Pose {
    let n = pairs.len() as f64;
    let x0 = pairs.iter().map(|p| p.0).sum::<Vector3<f64>>() / n;
    let y0 = pairs.iter().map(|p| p.1).sum::<Vector3<f64>>() / n;
    let mut rotation = hint.rotation;
    if pairs.len() >= 3 && !oriented {
        let cross: Matrix3<f64> = pairs.iter().map(|(x, y)| (y - y0) * (x - x0).transpose()).sum();
        let strengths = cross.svd(false, false).singular_values;
        if strengths[1] > 1e-9 * strengths[0] {
            rotation = nearest_rotation(&cross).unwrap_or(rotation);
        }
    }
    Pose::new(rotation, y0 - rotation * x0)
}
