//! Levenberg and Marquardt's method over base, tool and targets at once.
//!
//! | unknowns | meaning | derivative of p | of the orientation |
//! | --- | --- | --- | --- |
//! | base t, ω | B ← (exp ω, t) B, measurement axes | 1, −[p]× | 0, 1 |
//! | tool t, ω | tool ← tool (exp ω, t), tool axes | R, −R [x]× | 0, R |
//! | target | x_τ ← x_τ + δ, tool axes | R | 0 |
//!
//! with R the tool's orientation and x the target in its axes. Each step solves the damped problem by the triangular
//! factor of the stacked rows, never by an inverse of JᵀJ (Moré 1978). Directions that the data does not fix
//! get no step: they stay as described.

use super::sight::Sight;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_errormodel::Dataset;
use truepose_errormodel::descent::{Schedule, descend, relative_gain};
use truepose_kinematics::{
    Chain, FrameId, Placed, Pose, Target, TargetId, ToolId, rotation_log, rotation_vector, skew,
};
use truepose_solvers::accumulator::{ColumnScale, Factor, Triangular};

/// Its damping is that of columns in expected sizes; the number of steps is the caller's.
const SCHEDULE: Schedule = Schedule {
    first: 1e-3,
    good: (0.1, 1e-14),
    bad: (20.0, 1e8),
    steps: 0,
    patience: (1, usize::MAX),
    flat: 1e-13,
    gain: relative_gain,
};

/// What is to be found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unknowns {
    pub base: bool,
    pub tools: Vec<ToolId>,
    pub targets: Vec<TargetId>,
}

impl Unknowns {
    /// What the description marks as unknown and the data shows at all. When nothing but positions of unknown
    /// targets is seen, the tool's pose is only a name for where those targets are: it stays as described.
    pub fn of(chain: &Chain, data: &Dataset) -> Self {
        let targets: Vec<TargetId> = (0..chain.targets().len())
            .map(TargetId)
            .filter(|t| !chain.targets()[t.0].known && data.target.contains(&Some(*t)))
            .collect();
        let shown = |tool: &ToolId| {
            let shows = |row: usize| {
                let fixed_point = data.target[row].is_none_or(|t| !targets.contains(&t));
                data.tool(row) == *tool && (fixed_point || data.orientation[row].is_some())
            };
            !chain.tools()[tool.0].placed.known && (0..data.len()).any(shows)
        };
        let tools = (0..chain.tools().len()).map(ToolId).filter(shown).collect();
        Unknowns { base: !chain.base().known, tools, targets }
    }

    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    pub fn count(&self) -> usize {
        6 * (usize::from(self.base) + self.tools.len()) + 3 * self.targets.len()
    }

    pub fn tool_column(&self, tool: ToolId) -> Option<usize> {
        let place = self.tools.iter().position(|&t| t == tool)?;
        Some(6 * (usize::from(self.base) + place))
    }

    pub fn target_column(&self, target: TargetId) -> Option<usize> {
        let place = self.targets.iter().position(|&t| t == target)?;
        Some(6 * (usize::from(self.base) + self.tools.len()) + 3 * place)
    }

    /// Frames that are looked for.
    fn frames(&self, chain: &Chain) -> Vec<FrameId> {
        let tools = self.tools.iter().map(|&tool| chain.frame_of_tool(tool));
        self.base.then_some(FrameId::BASE).into_iter().chain(tools).collect()
    }

    /// Names of what is looked for.
    pub fn words(&self, chain: &Chain) -> Vec<String> {
        let mut words = Vec::new();
        if self.base {
            words.push("base".into());
        }
        words.extend(self.tools.iter().map(|&t| chain.frame_word(chain.frame_of_tool(t)).to_owned()));
        words.extend(self.targets.iter().map(|t| format!("target {}", chain.targets()[t.0].name)));
        words
    }
}

/// Present values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    pub base: Pose,
    pub tools: Vec<Pose>,
    pub targets: Vec<Vector3<f64>>,
}

impl State {
    pub fn of(chain: &Chain) -> Self {
        State {
            base: chain.base().pose,
            tools: chain.tools().iter().map(|tool| tool.placed.pose).collect(),
            targets: chain.targets().iter().map(|t| t.position).collect(),
        }
    }

    /// A sight's target in the tool's axes.
    pub fn point(&self, target: Option<TargetId>) -> Vector3<f64> {
        target.map_or(Vector3::zeros(), |t| self.targets[t.0])
    }

    /// The tools, all known.
    fn placed(&self) -> Vec<Placed> {
        self.tools.iter().map(|&pose| Placed { pose, known: true }).collect()
    }

    fn moved(&self, unknowns: &Unknowns, by: &DVector<f64>) -> State {
        let mut next = self.clone();
        let twist = |at: usize| {
            let v = |k: usize| Vector3::new(by[at + k], by[at + k + 1], by[at + k + 2]);
            Pose::new(rotation_vector(&v(3)), v(0))
        };
        if unknowns.base {
            next.base = (twist(0) * self.base).renormalised();
        }
        for &tool in &unknowns.tools {
            if let Some(at) = unknowns.tool_column(tool) {
                next.tools[tool.0] = (self.tools[tool.0] * twist(at)).renormalised();
            }
        }
        for &target in &unknowns.targets {
            if let Some(at) = unknowns.target_column(target) {
                next.targets[target.0] += Vector3::new(by[at], by[at + 1], by[at + 2]);
            }
        }
        next
    }

    /// The robot with these values.
    pub fn applied(&self, chain: &Chain, unknowns: &Unknowns) -> Result<Chain, IdentifyError> {
        let targets: Vec<Target> = chain
            .targets()
            .iter()
            .enumerate()
            .map(|(k, target)| Target {
                position: self.targets[k],
                known: target.known || unknowns.targets.contains(&TargetId(k)),
                ..target.clone()
            })
            .collect();
        let wrong = |error: truepose_kinematics::ChainError| IdentifyError::Placement {
            what: unknowns.words(chain).join(", "),
            why: error.to_string(),
        };
        chain
            .clone()
            .with_base(Placed { pose: self.base, known: true })
            .and_then(|c| c.with_placed_tools(&self.placed()))
            .and_then(|c| c.with_targets(targets))
            .map(|c| c.with_found(&unknowns.frames(chain), &unknowns.targets))
            .map_err(wrong)
    }
}

/// Where a start led.
#[derive(Debug, Clone)]
pub(crate) struct Refined {
    pub state: State,
    pub cost: f64,
    pub rms: f64,
    pub factor: Factor,
}

/// Refines a start; angles count as `length` metres a radian.
pub(crate) fn refine(
    chain: &Chain,
    unknowns: &Unknowns,
    sights: &[Sight],
    start: State,
    length: f64,
    rounds: usize,
) -> Refined {
    let scale = scales(unknowns, length);
    let cost = cost_of(sights, &start, length);
    let complete = |state: State| {
        let factor = linearised(unknowns, sights, &state, length);
        (state, factor)
    };
    let propose = |(state, factor): &(State, Factor), damping: f64| {
        let strength = damping * strength(factor, &scale);
        let step = factor.solve_ridge(0, ColumnScale::Given(&scale), strength).ok()?;
        let next = state.moved(unknowns, &step.x);
        let cost = cost_of(sights, &next, length);
        Some((next, cost))
    };
    let schedule = Schedule { steps: rounds, ..SCHEDULE };
    let ((state, factor), cost) = descend((complete(start), cost), &schedule, propose, complete);
    let positions = sights.iter().filter_map(|s| Some((s, s.position?)));
    let squares: Vec<f64> =
        positions.map(|(s, p)| (p - predicted(s, &state).translation).norm_squared()).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    debug_assert_eq!(state.targets.len(), chain.targets().len());
    Refined { state, cost, rms, factor }
}

/// Tool orientation and target position of a sight.
fn predicted(sight: &Sight, state: &State) -> Pose {
    let tool = state.base * sight.flange * state.tools[sight.tool.0];
    Pose::new(tool.rotation, tool.apply(&state.point(sight.target)))
}

fn cost_of(sights: &[Sight], state: &State, length: f64) -> f64 {
    sights
        .iter()
        .map(|sight| {
            let pose = predicted(sight, state);
            let p = sight.position.map_or(0.0, |p| (p - pose.translation).norm_squared());
            let r = sight.rotation.map_or(0.0, |r| {
                rotation_log(&(r * pose.rotation.transpose())).norm_squared() * length * length
            });
            p + r
        })
        .sum()
}

/// Triangular factor of the rows `[J | residual]`.
fn linearised(unknowns: &Unknowns, sights: &[Sight], state: &State, length: f64) -> Factor {
    let count = unknowns.count();
    let mut factor = Triangular::new(count, 1);
    let mut rows = DMatrix::<f64>::zeros(count + 1, 3);
    let mut put = |rows: &DMatrix<f64>| {
        // Columns of `rows` are rows of the problem; a non-finite one cannot come from finite poses.
        let _ = factor.update_rows(rows.as_slice());
    };
    for sight in sights {
        let pose = predicted(sight, state);
        let x = state.point(sight.target);
        if let Some(p) = sight.position {
            rows.fill(0.0);
            let mut block =
                |at: usize, m: &Matrix3<f64>| rows.view_mut((at, 0), (3, 3)).copy_from(&m.transpose());
            if unknowns.base {
                block(0, &Matrix3::identity());
                block(3, &-skew(&pose.translation));
            }
            if let Some(at) = unknowns.tool_column(sight.tool) {
                block(at, &pose.rotation);
                block(at + 3, &-(pose.rotation * skew(&x)));
            }
            if let Some(at) = sight.target.and_then(|t| unknowns.target_column(t)) {
                block(at, &pose.rotation);
            }
            let residual = p - pose.translation;
            rows.row_mut(count).copy_from(&residual.transpose());
            put(&rows);
        }
        if let Some(r) = sight.rotation {
            rows.fill(0.0);
            let mut block = |at: usize, m: Matrix3<f64>| {
                rows.view_mut((at, 0), (3, 3)).copy_from(&(m.transpose() * length))
            };
            if unknowns.base {
                block(3, Matrix3::identity());
            }
            if let Some(at) = unknowns.tool_column(sight.tool) {
                block(at + 3, pose.rotation);
            }
            let residual = rotation_log(&(r * pose.rotation.transpose())) * length;
            rows.row_mut(count).copy_from(&residual.transpose());
            put(&rows);
        }
    }
    factor.finish()
}

/// A metre, and the angle that moves the end of the arm by a metre.
pub(crate) fn scales(unknowns: &Unknowns, length: f64) -> Vec<f64> {
    let mut scale = Vec::with_capacity(unknowns.count());
    for _ in 0..usize::from(unknowns.base) + unknowns.tools.len() {
        scale.extend([1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length]);
    }
    scale.resize(unknowns.count(), 1.0);
    scale
}

/// Mean square of the scaled columns: what damping is measured by.
fn strength(factor: &Factor, scale: &[f64]) -> f64 {
    let squares: f64 =
        factor.column_norms().iter().zip(scale).map(|(norm, s)| (norm * s).powi(2)).sum::<f64>();
    squares / scale.len().max(1) as f64
}
