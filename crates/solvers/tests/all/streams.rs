//! However a stream is cut, in whatever order its parts are merged: the same factor, and the same answer as from the rows.

use proptest::prelude::*;
use truepose_solvers::nalgebra::{DMatrix, DVector};
use truepose_solvers::{ColumnScale, Gram, LeastSquares, PivotedQr, RankRule, Solver, Triangular};

fn problem() -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>, Vec<usize>)> {
    (1_usize..9, 1_usize..200).prop_flat_map(|(p, m)| {
        let numbers = prop::collection::vec(-1.0_f64..1.0, m * (p + 1));
        let sizes = prop::collection::vec(-6_i32..6, p);
        let cuts = prop::collection::vec(0..=m, 0..6);
        (numbers, sizes, cuts).prop_map(move |(numbers, sizes, mut cuts)| {
            let all = DMatrix::from_column_slice(m, p + 1, &numbers);
            let mut a = all.columns(0, p).into_owned();
            (0..p).for_each(|j| a.column_mut(j).scale_mut(10f64.powi(sizes[j])));
            cuts.extend([0, m]);
            cuts.sort_unstable();
            (a, all.column(p).into_owned(), cuts)
        })
    })
}

/// Relative to the norm of each column.
fn close(have: &DMatrix<f64>, want: &DMatrix<f64>) -> bool {
    want.column_iter().zip(have.column_iter()).all(|(w, h)| (w - h).norm() <= 1e-12 * w.norm())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn parts_merge_to_the_whole((a, y, cuts) in problem(), backwards in any::<bool>()) {
        let p = a.ncols();
        let y = DMatrix::from_column_slice(y.len(), 1, y.as_slice());
        let mut parts = Vec::new();
        let mut grams = Vec::new();
        for pair in cuts.windows(2) {
            let (from, many) = (pair[0], pair[1] - pair[0]);
            let (block, right) = (a.rows(from, many).into_owned(), y.rows(from, many).into_owned());
            let (mut part, mut gram) = (Triangular::new(p, 1), Gram::new(p, 1));
            part.update(&block, &right).expect("finite");
            gram.update(&block, &right).expect("finite");
            parts.push(Triangular::from_bytes(&part.to_bytes()).expect("whole"));
            grams.push(gram);
        }
        if backwards {
            parts.reverse();
        }
        let mut merged = Triangular::new(p, 1);
        parts.iter().for_each(|part| merged.merge(part).expect("alike"));
        let mut gram = Gram::new(p, 1);
        grams.iter().for_each(|part| gram.merge(part).expect("alike"));
        let factor = merged.finish();
        prop_assert_eq!(factor.rows, a.nrows());
        let squares = a.tr_mul(&a);
        let from_parts = factor.r.tr_mul(&factor.r);
        let size: Vec<f64> = (0..p).map(|j| squares[(j, j)].sqrt()).collect();
        for i in 0..p {
            for j in 0..p {
                prop_assert!((squares[(i, j)] - from_parts[(i, j)]).abs() <= 1e-13 * size[i] * size[j]);
            }
            prop_assert!(factor.r[(i, i)] >= 0.0);
        }
        let total = factor.z.column(0).norm_squared() + factor.rss[0];
        prop_assert!((total - y.norm_squared()).abs() <= 1e-12 * y.norm_squared());

        // Where the data determine everything well, the answers agree.
        let values = factor.singular_values(ColumnScale::Norms).expect("converges");
        if values[p - 1] > 1e-3 && a.nrows() > p {
            let whole = PivotedQr::default().solve(&LeastSquares::new(&a, &y.column(0).into_owned())).expect("full rank");
            let streamed = factor.solve_pivoted(0, ColumnScale::Norms, RankRule::Default).expect("full rank");
            let squared = gram.finish().expect("finite").solve_svd(0, ColumnScale::Norms, RankRule::Default).expect("full rank");
            let scaled = |x: &DVector<f64>| DMatrix::from_fn(p, 1, |j, _| x[j] * size[j]);
            prop_assert!(close(&scaled(&streamed.x), &scaled(&whole.x)) || (scaled(&streamed.x) - scaled(&whole.x)).norm() < 1e-10);
            prop_assert!((scaled(&squared.x) - scaled(&whole.x)).norm() < 1e-7 * (1.0 + scaled(&whole.x).norm()));
        }
    }
}
