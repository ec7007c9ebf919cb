//! Reduction to what can be identified (Eq. 8–16): c = B β.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | c | coefficients of the model | p | each its own |
//! | β | grouped errors | r | as the kept column |
//! | C | relations of dropped columns | (p − r) × p | unscaled |
//!
//! A dropped column p with `J^p = −Σ_j c_j J^j` is left at zero and its error passes into the kept ones:
//! `β_j = ε_j − c_j ε_p`. So B is a selection, and what it selects from is said in words, group by group.
//!
//! Two null spaces are kept apart: the *structural* one, over postures spread within the limits, that no data on this
//! robot with this kind of measurement can fill; and the *practical* one, further directions that this data set
//! leaves unexcited.

mod echelon;
mod grouped;
mod priority;
mod structural;
mod words;

pub use echelon::{Echelon, echelon};
pub use grouped::grouped;
pub use priority::{column_word, preference};
pub use structural::{joint_ranges, spread_factor};
pub use words::group_words;

use crate::IdentifyError;
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, ErrorModel};
use truepose_solvers::accumulator::{ColumnScale, Factor};
use truepose_solvers::{RankDecision, RankRule};

/// Which columns are kept, and what each kept coefficient stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Kept columns, ascending.
    pub kept: Vec<usize>,
    /// Dropped columns and why.
    pub dropped: Vec<Dropped>,
    /// What each kept coefficient stands for, in the order of `kept`.
    pub groups: Vec<Group>,
    /// How the structural rank was decided.
    pub structural: RankDecision,
    /// How the rank of the data, on the structurally kept columns, was decided.
    pub practical: RankDecision,
}

/// A column that is left at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Dropped {
    /// The column.
    pub column: usize,
    /// Kept columns j with their c_j in `J^p = −Σ_j c_j J^j`; empty when the column has no effect at all.
    pub relation: Vec<(usize, f64)>,
    /// Whose null space it belongs to.
    pub cause: Cause,
}

/// Why a column cannot be told from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// No data can tell them apart on this robot with this kind of measurement.
    Structural,
    /// This data set excites their difference not at all.
    Unexcited,
}

/// A grouped error: the kept column and what passes into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The kept column.
    pub column: usize,
    /// Dropped columns p with −c_j: β = ε_kept + Σ (−c_j) ε_p.
    pub members: Vec<(usize, f64)>,
}

impl Reduction {
    /// Nothing is reduced away: for models whose columns are known to be independent.
    pub fn none(columns: usize) -> Self {
        let clear = RankDecision {
            rank: columns,
            tolerance: 0.0,
            last_kept: 1.0,
            first_dropped: 0.0,
            gap: f64::INFINITY,
            dropped: 0,
        };
        Reduction {
            kept: (0..columns).collect(),
            dropped: Vec::new(),
            groups: (0..columns).map(|column| Group { column, members: Vec::new() }).collect(),
            structural: clear,
            practical: clear,
        }
    }

    /// The rank: how many grouped errors there are.
    pub fn rank(&self) -> usize {
        self.kept.len()
    }

    /// The columns of a p-column matrix that are kept.
    pub fn select(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        matrix.select_columns(&self.kept)
    }

    /// β of the model's coefficients, when the dropped ones are zero.
    pub fn grouped(&self, coefficients: &[f64]) -> Vec<f64> {
        self.kept.iter().map(|&column| coefficients[column]).collect()
    }

    /// β as the model's coefficients: kept ones in their places, zero elsewhere.
    pub fn expand(&self, grouped: &[f64], columns: usize) -> Vec<f64> {
        let mut coefficients = vec![0.0; columns];
        for (&column, &value) in self.kept.iter().zip(grouped) {
            coefficients[column] = value;
        }
        coefficients
    }
}

/// Reduces by the structural null space and then by what the data, given as its triangular factor, leaves unexcited; both
/// linearised at these coefficients.
///
/// # Errors
/// When the model does not fit the data or a factorisation fails.
pub fn reduce(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
) -> Result<Reduction, IdentifyError> {
    reduce_in_order(model, data, factor, rule, coefficients, &preference(model))
}

/// As [`reduce`], at a robot on which a reduction is known already: its kept columns are preferred to all others, so that
/// they stay.
///
/// # Errors
/// As [`reduce`].
pub fn reduce_further(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
    known: &Reduction,
) -> Result<Reduction, IdentifyError> {
    let (mut order, others): (Vec<usize>, Vec<usize>) =
        preference(model).into_iter().partition(|column| known.kept.contains(column));
    order.extend(others);
    reduce_in_order(model, data, factor, rule, coefficients, &order)
}

fn reduce_in_order(
    model: &ErrorModel,
    data: &Dataset,
    factor: &Factor,
    rule: RankRule,
    coefficients: &[f64],
    order: &[usize],
) -> Result<Reduction, IdentifyError> {
    let scales: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
    let spread = spread_factor(model, data, factor, coefficients)?;
    let structural = spread.null_space(ColumnScale::Given(&scales), rule)?;
    let mut dropped = relations(&structural.basis, order, &scales, Cause::Structural);

    let left: Vec<usize> = (0..scales.len()).filter(|c| dropped.iter().all(|d| d.column != *c)).collect();
    let inner = factor.select(&left);
    let inner_scales: Vec<f64> = left.iter().map(|&c| scales[c]).collect();
    // Mostly the data excites all that is left, which the triangle's inverse shows without singular values.
    let sure = match rule {
        RankRule::Default => inner.certainly_full(ColumnScale::Given(&inner_scales))?,
        _ => None,
    };
    let (practical, unexcited) = match sure {
        Some(decision) => (decision, DMatrix::zeros(left.len(), 0)),
        None => {
            let found = inner.null_space(ColumnScale::Given(&inner_scales), rule)?;
            (found.decision, found.basis)
        }
    };
    let mut reduction = Reduction {
        kept: left,
        dropped: Vec::new(),
        groups: Vec::new(),
        structural: structural.decision,
        practical,
    };
    std::mem::swap(&mut reduction.dropped, &mut dropped);
    drop_more(&mut reduction, &unexcited, order, &scales, Cause::Unexcited);
    regroup(&mut reduction);
    Ok(reduction)
}

/// Relations of a null space over all columns.
fn relations(null: &DMatrix<f64>, order: &[usize], scales: &[f64], cause: Cause) -> Vec<Dropped> {
    let form = echelon(null, order);
    form.dropped
        .iter()
        .enumerate()
        .map(|(row, &column)| {
            let relation = (0..scales.len())
                .filter(|&j| j != column && form.relations[(row, j)].abs() > 1e-9)
                .map(|j| (j, tidy(form.relations[(row, j)] * scales[j] / scales[column])))
                .collect();
            Dropped { column, relation, cause }
        })
        .collect()
}

/// Snaps a coefficient that is a whole number but for round-off, so that groups read the same everywhere.
fn tidy(value: f64) -> f64 {
    let nearest = value.round();
    if nearest != 0.0 && (value - nearest).abs() < 1e-9 { nearest } else { value }
}

/// Drops further columns by a null space over the kept ones, and rewrites the relations of those dropped before.
fn drop_more(reduction: &mut Reduction, null: &DMatrix<f64>, order: &[usize], scales: &[f64], cause: Cause) {
    if null.ncols() == 0 {
        return;
    }
    let place: Vec<Option<usize>> =
        (0..scales.len()).map(|c| reduction.kept.iter().position(|&kept| kept == c)).collect();
    let inner_order: Vec<usize> = order.iter().filter_map(|&c| place[c]).collect();
    let inner_scales: Vec<f64> = reduction.kept.iter().map(|&c| scales[c]).collect();
    let kept = reduction.kept.clone();
    let more = relations(null, &inner_order, &inner_scales, cause).into_iter().map(|d| Dropped {
        column: kept[d.column],
        relation: d.relation.iter().map(|&(j, c)| (kept[j], c)).collect(),
        cause,
    });
    for new in more {
        for old in &mut reduction.dropped {
            // J^old = −Σ c_j J^j with J^new among them: put −Σ d_k J^k in its place.
            let Some(at) = old.relation.iter().position(|&(j, _)| j == new.column) else { continue };
            let (_, share) = old.relation.remove(at);
            for &(k, d) in &new.relation {
                match old.relation.iter_mut().find(|(j, _)| *j == k) {
                    Some((_, c)) => *c -= share * d,
                    None => old.relation.push((k, -share * d)),
                }
            }
            old.relation
                .retain(|&(j, c)| (c * scales[j] / scales[old.column]).abs() > 1e-9 || c.abs() > 1e-9);
        }
        reduction.kept.retain(|&c| c != new.column);
        reduction.dropped.push(new);
    }
}

/// β_j = ε_j − Σ_p c_pj ε_p for every kept column.
fn regroup(reduction: &mut Reduction) {
    reduction.dropped.sort_by_key(|d| d.column);
    for dropped in &mut reduction.dropped {
        dropped.relation.sort_by_key(|&(j, _)| j);
    }
    reduction.groups = reduction
        .kept
        .iter()
        .map(|&column| {
            let members = reduction
                .dropped
                .iter()
                .filter_map(|d| d.relation.iter().find(|(j, _)| *j == column).map(|&(_, c)| (d.column, -c)));
            Group { column, members: members.collect() }
        })
        .collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::effects::{Geometric, Where};
    use truepose_errormodel::{EffectRegistry, Visits};
    use truepose_kinematics::{Chain, Load, Target, TargetId, nalgebra::Vector3, samples};

    /// Postures spread over ±2.5 rad (m), seen as asked for.
    fn postures(chain: &Chain, count: usize, orientation: bool, targets: &[Option<TargetId>]) -> Dataset {
        let mut data = Dataset::default();
        let n = chain.movable().len();
        data.joints = vec![Vec::new(); n];
        data.approach = vec![Vec::new(); n];
        for visit in 0..count {
            for &target in targets {
                for k in 0..n {
                    let phase = (visit * (2 * k + 3)) as f64 * 0.6180339887 + 0.1 * k as f64;
                    data.joints[k].push(5.0 * (phase - phase.floor()) - 2.5);
                    data.approach[k].push(0.0);
                }
                data.position.push([0.0; 3]);
                data.orientation.push(orientation.then_some([1.0, 0.0, 0.0, 0.0]));
                data.position_sd.push([f64::NAN; 3]);
                data.orientation_sd.push([f64::NAN; 3]);
                data.target.push(target);
                data.visit.push(visit);
                data.load.push(Load::None);
                data.time.push(0.0);
            }
        }
        data
    }

    fn frames_only(chain: &Chain) -> ErrorModel {
        let frames = Some(chain.frames().map(Where::Frame).collect());
        ErrorModel::new(chain.clone(), vec![Box::new(Geometric { frames, components: None })]).unwrap()
    }

    fn reduced(model: &ErrorModel, data: &Dataset) -> Reduction {
        let zero = vec![0.0; model.columns().len()];
        let factor =
            crate::factorise(model, data, &Visits::of(data), crate::NoiseModel::default(), &zero, None)
                .unwrap();
        reduce(model, data, &factor, RankRule::Default, &zero).unwrap()
    }

    #[test]
    fn ur10_has_rank_30_for_poses_and_three_targets_and_27_for_one() {
        let chain = samples::ur10();
        let target = |name: &str, position: [f64; 3]| Target {
            name: name.into(),
            position: Vector3::from(position),
            known: true,
        };
        let with_targets = chain
            .clone()
            .with_targets(vec![
                target("a", [0.1, 0.0, 0.1]),
                target("b", [-0.1, 0.1, 0.1]),
                target("c", [0.0, -0.1, 0.2]),
            ])
            .unwrap();
        let all: Vec<Option<TargetId>> = (0..3).map(|t| Some(TargetId(t))).collect();
        let cases = [
            (&chain, true, vec![None], 30),
            (&with_targets, false, all, 30),
            (&with_targets, false, vec![Some(TargetId(0))], 27),
        ];
        for (chain, orientation, targets, rank) in cases {
            let model = frames_only(chain);
            assert_eq!(model.columns().len(), 48);
            let reduction = reduced(&model, &postures(chain, 60, orientation, &targets));
            assert_eq!(reduction.rank(), rank);
            assert_eq!(reduction.structural.rank, rank);
            assert!(reduction.structural.is_clear(), "{:?}", reduction.structural);
            assert!(reduction.dropped.iter().all(|d| d.cause == Cause::Structural));
        }
    }

    #[test]
    fn relations_hold_in_the_data() {
        for chain in samples::all() {
            let model = ErrorModel::new(chain.clone(), vec![Box::new(Geometric::default())]).unwrap();
            let target = (!chain.targets().is_empty()).then_some(TargetId(0));
            let data = postures(&chain, 50, true, &[target]);
            let zero = vec![0.0; model.columns().len()];
            let noise = crate::NoiseModel { position_sd: 1.0, visit_sd: 0.0, orientation_sd: 1.0 };
            let rows = crate::collect(&model, &data, &Visits::of(&data), noise, &zero).unwrap();
            let reduction = reduced(&model, &data);
            assert_eq!(reduction.kept.len() + reduction.dropped.len(), zero.len());
            for d in &reduction.dropped {
                let mut sum = rows.a.column(d.column).into_owned();
                for &(j, c) in &d.relation {
                    sum += rows.a.column(j) * c;
                }
                let size = rows.a.column(d.column).norm().max(1e-3);
                assert!(sum.norm() < 1e-9 * size * (rows.a.nrows() as f64), "{} {}", chain.name(), d.column);
            }
        }
    }

    /// The paper's order has all that the other one has.
    #[test]
    fn what_every_error_has_its_grouped_ones_have() {
        use truepose_errormodel::effects::{Order, Polynomial, WrenchComponent};
        let chain = samples::pps();
        let mut data =
            postures(&chain, 150, false, &[Some(TargetId(0)), Some(TargetId(1)), Some(TargetId(2))]);
        for (row, load) in data.load.iter_mut().enumerate() {
            let mass = 20.0 * (row / 3 % 4) as f64;
            *load = Load::Payload(truepose_kinematics::Payload { mass, com: Vector3::new(0.0, -0.1, -0.8) });
        }
        let first = Polynomial::of(2, vec![WrenchComponent::Fy]);
        let second = Polynomial { order: Order::ReduceFirst, ..first.clone() };
        let rank = |effects: Vec<Polynomial>| {
            let effects = effects.into_iter().map(|e| Box::new(e) as Box<dyn truepose_errormodel::AnyEffect>);
            let model = ErrorModel::new(chain.clone(), effects.collect()).unwrap();
            let model = grouped(&model, &data, RankRule::Default).unwrap().into_owned();
            (model.columns().len(), reduced(&model, &data).rank())
        };
        let (each, paper) = (rank(vec![first.clone()]), rank(vec![second.clone()]));
        let both = rank(vec![first, second]);
        assert!(paper.0 < each.0, "{paper:?} {each:?}");
        assert_eq!(both.1, paper.1, "{paper:?} {each:?} {both:?}");
    }

    #[test]
    fn what_is_not_moved_is_unexcited_and_not_structural() {
        let chain = samples::ur10();
        let model = frames_only(&chain);
        let mut data = postures(&chain, 60, true, &[None]);
        data.joints[4].fill(0.7);
        let reduction = reduced(&model, &data);
        assert_eq!(reduction.structural.rank, 30);
        assert_eq!(reduction.rank(), 26, "a joint that stands still hides four of its six errors");
        assert!(reduction.dropped.iter().filter(|d| d.cause == Cause::Unexcited).count() == 4);
    }

    #[test]
    fn renaming_joints_changes_no_group() {
        let chain = samples::pps();
        let data = postures(&chain, 60, false, &[Some(TargetId(0)), Some(TargetId(1)), Some(TargetId(2))]);
        let renamed = Chain::new(
            "other",
            chain
                .joints()
                .iter()
                .enumerate()
                .map(|(k, joint)| {
                    let mut joint = joint.clone();
                    joint.name = format!("{}{k}", ["zz", "a", "M"][k % 3]);
                    joint
                })
                .collect(),
        )
        .and_then(|c| c.with_tool(*chain.tool()))
        .and_then(|c| c.with_targets(chain.targets().to_vec()))
        .unwrap();
        let registry = EffectRegistry::builtin();
        let groups = |chain: &Chain| {
            let effect = registry.build("geometric", serde_json::json!({}), chain).unwrap();
            reduced(&ErrorModel::new(chain.clone(), vec![effect]).unwrap(), &data).groups
        };
        let (a, b) = (groups(&chain), groups(&renamed));
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(&b) {
            assert_eq!(x.column, y.column);
            assert_eq!(x.members.len(), y.members.len());
        }
    }

    #[test]
    fn a_group_reads_like_a_sentence() {
        let chain = samples::ur10();
        let model = frames_only(&chain);
        let reduction = reduced(&model, &postures(&chain, 60, true, &[None]));
        let words: Vec<String> = reduction.groups.iter().map(|g| group_words(&model, g)).collect();
        insta::assert_snapshot!(words.join("\n"));
    }
}
