//! Bounds and effects of columns, carried over to the grouped errors that a solver sees.
//!
//! `β = ε_k + Σ_j g_j ε_j` lies between the sums of the members' bounds, `g_j l_j` or `g_j u_j` by the sign of g_j: what the
//! members allow, and nothing tighter. A group with a member that is not bounded is not bounded.

use super::warnings::Warning;
use crate::reduction::Reduction;
use truepose_errormodel::ErrorModel;
use truepose_solvers::Bounds;

/// Bounds of the grouped errors, in the order of the kept columns.
pub(super) fn bounds(model: &ErrorModel, reduction: &Reduction) -> Bounds {
    let columns = model.columns();
    let mut bounds = Bounds::free(reduction.rank());
    for (k, group) in reduction.groups.iter().enumerate() {
        let [mut lower, mut upper] = columns[group.column].bounds;
        for &(column, weight) in group.members.iter().filter(|m| m.1 != 0.0) {
            let [a, b] = columns[column].bounds.map(|bound| weight * bound);
            lower += a.min(b);
            upper += a.max(b);
        }
        bounds = bounds.with(k, lower, upper);
    }
    bounds
}

/// The effect of each kept column.
pub(super) fn effects(model: &ErrorModel, reduction: &Reduction) -> Vec<usize> {
    reduction.kept.iter().map(|&column| model.effect_of(column)).collect()
}

/// Grouped errors outside of their bounds by more than their 95 % interval, `half` a column of the model.
pub(super) fn violated(
    model: &ErrorModel,
    reduction: &Reduction,
    coefficients: &[f64],
    half: &[f64],
) -> Vec<Warning> {
    let bounds = bounds(model, reduction);
    let outside = |k: usize| {
        let column = reduction.kept[k];
        let value = coefficients[column];
        let over = (bounds.lower[k] - value).max(value - bounds.upper[k]);
        (over > half[column]).then(|| Warning::OutOfBounds {
            column: model.columns()[column].name.clone(),
            value,
            bounds: [bounds.lower[k], bounds.upper[k]],
        })
    };
    (0..reduction.rank()).filter_map(outside).collect()
}

/// Effects of which a solver that takes or leaves whole effects left out everything.
pub(super) fn left_out(model: &ErrorModel, reduction: &Reduction, coefficients: &[f64]) -> Vec<Warning> {
    (0..model.effects().len())
        .filter(|&effect| {
            let range = model.columns_of(effect);
            let mut mine = reduction.kept.iter().filter(|column| range.contains(*column)).peekable();
            mine.peek().is_some() && mine.all(|&column| coefficients[column] == 0.0)
        })
        .map(|effect| Warning::LeftOut {
            effect: model.effects()[effect].kind().into(),
            column: model.columns()[model.columns_of(effect).start].name.clone(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reduction::Group;
    use truepose_errormodel::effects::{Geometric, JointCompliance};
    use truepose_kinematics::samples;

    #[test]
    fn a_group_is_bounded_by_what_its_members_allow() {
        let chain = samples::scara();
        let effects: Vec<Box<dyn truepose_errormodel::AnyEffect>> =
            vec![Box::new(JointCompliance::default()), Box::new(Geometric::default())];
        let model = ErrorModel::new(chain, effects).unwrap();
        let mut reduction = Reduction::none(model.columns().len());
        reduction.kept = vec![0, 1, 2];
        reduction.groups = vec![
            Group { column: 0, members: vec![(3, 2.0)] },
            Group { column: 1, members: vec![(3, -1.0)] },
            Group { column: 2, members: vec![(9, 0.5)] },
        ];
        let bounds = bounds(&model, &reduction);
        assert_eq!((bounds.lower[0], bounds.upper[0]), (0.0, f64::INFINITY));
        assert_eq!((bounds.lower[1], bounds.upper[1]), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!((bounds.lower[2], bounds.upper[2]), (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(effects_of(&model, &reduction), [0, 0, 0]);
        let negative = [-2e-6, 1e-6, 0.0];
        let told = violated(&model, &reduction, &negative, &[1e-6; 3]);
        assert!(matches!(&told[..], [Warning::OutOfBounds { value, .. }] if *value < 0.0), "{told:?}");
        assert!(violated(&model, &reduction, &negative, &[3e-6; 3]).is_empty(), "within its interval");
    }

    fn effects_of(model: &ErrorModel, reduction: &Reduction) -> Vec<usize> {
        effects(model, reduction)
    }
}
