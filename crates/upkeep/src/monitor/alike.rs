//! Suspects that move the measured points alike: one question, which has several words.
//!
//! ```text
//! ρ² = tr((H_aᵀQH_a)⁺ H_aᵀQH_b (H_bᵀQH_b)⁺ H_bᵀQH_a) / max(rank a, rank b)
//! ```
//!
//! ρ² is the mean of the squared canonical correlations (Hotelling 1936) of two suspects in the rows of a look. A zero of a joint and the
//! angle of the frame before it about the same axis have ρ² = 1: no measurement of the tool tells them apart.

use super::score::pseudo_inverse;
use super::suspects::Suspect;
use nalgebra::DMatrix;

/// 1 − ρ² below which two suspects are one. A change has to be a hundred times its own standard deviation before the remaining
/// difference is worth one standard deviation.
const SAME: f64 = 1e-4;

/// Suspects in groups that move alike, by number, each under the word that a mechanic would look for first: the zero of a joint, else the
/// one named first by the model. `information` is HᵀQH of all columns of the model.
pub(super) fn groups(information: &DMatrix<f64>, suspects: &[Suspect]) -> Vec<Vec<usize>> {
    let of = |a: &Suspect, b: &Suspect| information.select_rows(&a.columns).select_columns(&b.columns);
    let inverses: Vec<Option<(DMatrix<f64>, usize)>> =
        suspects.iter().map(|suspect| pseudo_inverse(&of(suspect, suspect))).collect();
    let alike = |a: usize, b: usize| -> bool {
        let (Some((inner_a, rank_a)), Some((inner_b, rank_b))) = (&inverses[a], &inverses[b]) else {
            return false;
        };
        let across = of(&suspects[a], &suspects[b]);
        let shared = (inner_a * &across * inner_b * across.transpose()).trace();
        1.0 - shared / (*rank_a).max(*rank_b) as f64 <= SAME
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for at in 0..suspects.len() {
        match groups.iter_mut().find(|group| alike(group[0], at)) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    groups.iter_mut().for_each(|group| group.sort_by_key(|&at| !suspects[at].is_zero));
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suspect(word: &str, columns: &[usize], is_zero: bool) -> Suspect {
        Suspect { word: word.into(), family: "constant".into(), columns: columns.to_vec(), is_zero }
    }

    #[test]
    fn equal_columns_are_one_question_whatever_their_unit_and_sign() {
        // Columns 0 and 1 are proportional, 2 differs by a tenth, 3 and 4 span what 0 and 5 span.
        let h = DMatrix::from_columns(&[
            nalgebra::dvector![1.0, 2.0, -1.0, 0.5],
            nalgebra::dvector![-1e3, -2e3, 1e3, -0.5e3],
            nalgebra::dvector![1.0, 2.0, -1.0, 0.7],
            nalgebra::dvector![1.0, 2.0, -1.0, 1.5],
            nalgebra::dvector![1.0, 2.0, -1.0, -0.5],
            nalgebra::dvector![0.0, 0.0, 0.0, 1.0],
        ]);
        let list = [
            suspect("ry@j3", &[0], false),
            suspect("zero of j4", &[1], true),
            suspect("rx@j3", &[2], false),
            suspect("gear", &[3, 4], false),
            suspect("other", &[0, 5], false),
        ];
        assert_eq!(groups(&h.tr_mul(&h), &list), [vec![1, 0], vec![2], vec![3, 4]]);
    }
}
