use super::*;

fn block(rows: usize, columns: usize, seed: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |i, j| ((i * 37 + j * 101 + seed * 13 + i * j) as f64 * 0.7).sin())
}

/// AᵀA, AᵀY and YᵀY of the factor are those of the rows.
fn check(factor: &Factor, a: &DMatrix<f64>, y: &DMatrix<f64>) {
    let size = a.nrows() as f64;
    assert!((factor.r.transpose() * &factor.r - a.transpose() * a).amax() < 1e-13 * size);
    assert!((factor.r.transpose() * &factor.z - a.transpose() * y).amax() < 1e-13 * size);
    for k in 0..y.ncols() {
        let all = factor.z.column(k).norm_squared() + factor.rss[k];
        assert!((all - y.column(k).norm_squared()).abs() < 1e-13 * size);
    }
    assert_eq!(factor.rows, a.nrows());
}

#[test]
fn rows_blocks_and_merges_give_the_same_factor() {
    let (a, y) = (block(1000, 6, 1), block(1000, 2, 2));
    let mut whole = Triangular::new(6, 2);
    whole.update(&a, &y).unwrap();
    check(&whole.finish(), &a, &y);

    let mut at_once = Triangular::new(6, 2);
    let mut block = a.clone().insert_columns(6, 2, 0.0);
    block.columns_mut(6, 2).copy_from(&y);
    at_once.update_block(block.clone()).unwrap();
    check(&at_once.finish(), &a, &y);
    block[(3, 4)] = f64::NAN;
    assert!(at_once.update_block(block).is_err() && at_once.update_block(DMatrix::zeros(3, 7)).is_err());
    check(&at_once.finish(), &a, &y);

    let mut rowwise = Triangular::new(6, 2);
    let mut flat = Vec::new();
    for i in 0..1000 {
        flat.extend(a.row(i).iter().chain(y.row(i).iter()));
    }
    flat.chunks(8 * 77).for_each(|rows| rowwise.update_rows(rows).unwrap());
    assert_eq!(rowwise.finish(), whole.finish(), "the buffer makes the split of the stream irrelevant");

    let mut parts: Vec<Triangular> = (0..5)
        .map(|k| {
            let mut part = Triangular::new(6, 2);
            part.update(&a.rows(200 * k, 200).into_owned(), &y.rows(200 * k, 200).into_owned()).unwrap();
            part
        })
        .collect();
    let mut merged = parts.remove(3);
    parts.iter().for_each(|p| merged.merge(p).unwrap());
    check(&merged.finish(), &a, &y);
    assert!((merged.finish().r - whole.finish().r).amax() < 1e-12, "the sign of the diagonal is normalised");
}

#[test]
fn empty_and_short_streams() {
    let none = Triangular::new(3, 1).finish();
    assert_eq!((none.rows, none.r.shape(), none.rss.len()), (0, (3, 3), 1));
    let mut short = Triangular::new(5, 1);
    short.update(&block(2, 5, 3), &block(2, 1, 4)).unwrap();
    check(&short.finish(), &block(2, 5, 3), &block(2, 1, 4));
    let mut bare = Triangular::new(0, 1);
    bare.update(&DMatrix::zeros(4, 0), &DMatrix::from_element(4, 1, 1.0)).unwrap();
    assert!((bare.finish().rss[0] - 4.0).abs() < 1e-15);
    assert!(short.merge(&bare).is_err());
}

#[test]
fn stored_form_comes_back_bit_for_bit_and_nan_is_refused() {
    let mut t = Triangular::new(4, 1);
    t.update(&block(300, 4, 5), &block(300, 1, 6)).unwrap();
    let back = Triangular::from_bytes(&t.to_bytes()).unwrap();
    assert_eq!(back.finish(), t.finish());
    assert!(Triangular::from_bytes(&t.to_bytes()[1..]).is_err());
    assert!(matches!(
        t.update_rows(&[0.0, 0.0, f64::NAN, 0.0, 1.0]),
        Err(SolveError::NotFinite { column: 2, .. })
    ));
    assert!(matches!(t.update_rows(&[0.0; 7]), Err(SolveError::Shape { expected: 10, found: 7, .. })));
    assert_eq!(back.finish(), t.finish(), "a refused update leaves no trace");
}

#[test]
fn blocks_with_some_of_the_columns_are_the_same_rows() {
    let (mut sparse, mut dense, mut parts) = (Triangular::new(9, 1), Triangular::new(9, 1), Vec::new());
    let sets: [&[usize]; 5] =
        [&[0, 2, 5], &[1, 2, 4, 8], &[0, 2, 5], &[3, 4, 5, 6, 7], &[0, 1, 2, 3, 4, 5, 6, 7, 8]];
    for (k, active) in sets.iter().enumerate() {
        let (rows, n) = ([40, 30, 2, 3, 4][k], active.len());
        let some = block(rows, n + 1, k);
        let mut numbers = vec![f64::NAN; (n + 1) * 64];
        (0..=n).for_each(|j| numbers[64 * j..64 * j + rows].copy_from_slice(some.column(j).as_slice()));
        sparse.update_columns(active, rows, 64, &numbers).unwrap();
        let mut part = Triangular::new(9, 1);
        part.update_columns(active, rows, 64, &numbers).unwrap();
        parts.push(part);
        let mut a = DMatrix::zeros(rows, 9);
        active.iter().enumerate().for_each(|(j, &column)| a.set_column(column, &some.column(j)));
        dense.update(&a, &some.columns(n, 1).into_owned()).unwrap();
    }
    let mut merged = parts.remove(0);
    parts.iter().for_each(|part| merged.merge(part).unwrap());
    let want = dense.finish();
    for have in
        [sparse.finish(), merged.finish(), Triangular::from_bytes(&sparse.to_bytes()).unwrap().finish()]
    {
        assert!((&have.r - &want.r).amax() < 1e-13 && (&have.z - &want.z).amax() < 1e-13);
        assert!((have.rss[0] - want.rss[0]).abs() < 1e-12 && have.rows == 79);
    }
    let (have, order) = sparse.clone().into_factor_in_any_order();
    let gram = |r: &DMatrix<f64>| r.tr_mul(r);
    let (have, want) = (gram(&have.r), gram(&want.r));
    for (i, &a) in order.iter().enumerate() {
        for (j, &b) in order.iter().enumerate() {
            assert!((have[(i, j)] - want[(a, b)]).abs() < 1e-12);
        }
    }
    assert!(sparse.update_columns(&[9], 1, 4, &[0.0; 8]).is_err());
    assert!(sparse.update_columns(&[0], 1, 4, &[0.0, 0.0, 0.0, 0.0, f64::NAN]).is_err());
}

#[test]
fn a_block_without_rows_says_nothing() {
    let some = block(5, 3, 1);
    let mut triangle = Triangular::new(4, 1);
    triangle.update_columns(&[0, 3], 5, 5, some.as_slice()).unwrap();
    let before = triangle.finish();
    // Columns that no other block has: all of its rows were taken out.
    triangle.update_columns(&[1, 2], 0, 0, &[]).unwrap();
    triangle.update_columns(&[], 0, 0, &[]).unwrap();
    assert_eq!(triangle.finish(), before);
}
