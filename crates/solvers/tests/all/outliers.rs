//! With wrong visits in the data, robust fits predict nearly as well as an oracle that knows which ones are wrong.

use truepose_solvers::nalgebra::{DMatrix, DVector};
use truepose_solvers::{LeastSquares, PivotedQr, Solver, SolverSpec};

/// Gaussian numbers (splitmix64, Box and Muller), the same everywhere.
struct Gauss(u64);

impl Gauss {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

const UNKNOWNS: usize = 20;
const VISITS: usize = 100;
const ROWS: usize = 3;

/// Every composition of a robust loss with a start, at efficiencies of 90 % and above; the inner solvers that are not penalised reach the same squares.
/// Sharper tunings do not pass: `tukey(qr, c=3)` is at 1.32 of plain least squares in clean draw 38.
const ROBUST: [&str; 7] = [
    "huber(qr)",
    "huber(svd, start=trimmed)",
    "huber(normal, start=huber)",
    "tukey(qr)",
    "tukey(svd, start=plain)",
    "tukey(normal, start=huber)",
    "huber(qr, k=1)",
];

struct Data {
    a: DMatrix<f64>,
    y: DVector<f64>,
    ids: Vec<usize>,
    wrong: Vec<bool>,
    truth: DVector<f64>,
    held: DMatrix<f64>,
}

/// Noise of 1; wrong visits are off by 5 to 30 in a common direction of their rows.
fn data(share: f64, seed: u64) -> Data {
    sized(VISITS, UNKNOWNS, share, seed)
}

/// With so many visits and unknowns.
fn sized(visits: usize, unknowns: usize, share: f64, seed: u64) -> Data {
    let mut g = Gauss(seed);
    let m = visits * ROWS;
    let a = DMatrix::from_fn(m, unknowns, |_, _| g.next());
    let truth = DVector::from_fn(unknowns, |_, _| g.next());
    let mut y = &a * &truth + DVector::from_fn(m, |_, _| g.next());
    let wrong: Vec<bool> = (0..visits).map(|v| (v as f64 * 0.618_033_988).fract() < share).collect();
    for v in (0..visits).filter(|v| wrong[*v]) {
        let size = 5.0 + 25.0 * g.uniform();
        (0..ROWS).for_each(|k| y[ROWS * v + k] += size * (1.0 + 0.2 * g.next()));
    }
    let held = DMatrix::from_fn(600, unknowns, |_, _| g.next());
    Data { a, y, ids: (0..m).map(|i| i / ROWS).collect(), wrong, truth, held }
}

impl Data {
    fn problem(&self) -> LeastSquares<'_> {
        LeastSquares::new(&self.a, &self.y).with_row_groups(&self.ids)
    }

    /// Expected held-out root mean square, noise of 1 included.
    fn held_out(&self, x: &DVector<f64>) -> f64 {
        (1.0 + (&self.held * (x - &self.truth)).norm_squared() / 600.0).sqrt()
    }

    fn oracle(&self) -> f64 {
        let weights: Vec<f64> = self.ids.iter().map(|v| if self.wrong[*v] { 0.0 } else { 1.0 }).collect();
        self.held_out(
            &PivotedQr::default().solve(&self.problem().with_weights(&weights)).expect("full rank").x,
        )
    }
}

/// Mean over seeds of the held-out error over the oracle's.
fn ratio(spec: &str, share: f64) -> f64 {
    let solver = spec.parse::<SolverSpec>().expect("a solver").build();
    let one = |seed| {
        let data = data(share, seed);
        data.held_out(&solver.solve(&data.problem()).expect("full rank").x) / data.oracle()
    };
    (1..=12).map(one).sum::<f64>() / 12.0
}

#[test]
fn robust_fits_come_within_a_tenth_of_the_oracle() {
    for share in [0.05, 0.10] {
        let plain = ratio("qr", share);
        assert!(plain > 1.2, "plain least squares at {share}: {plain}");
        for (spec, limit) in [
            ("huber(qr)", 1.10),
            ("tukey(qr)", 1.02),
            ("tukey(svd, start=huber)", 1.02),
            ("huber(normal, start=trimmed)", 1.10),
        ] {
            let robust = ratio(spec, share);
            assert!(robust < limit, "{spec} at {share}: {robust}, plain {plain}");
        }
        #[cfg(feature = "clarabel")]
        assert!(ratio("huber_exact", share) < 1.10);
    }
}

#[test]
fn without_outliers_robustness_costs_little() {
    for spec in ["huber(qr)", "tukey(qr)"] {
        let cost = ratio(spec, 0.0);
        assert!(cost < 1.01, "{spec}: {cost}");
    }
}

#[test]
fn the_noise_is_estimated_in_spite_of_them() {
    let data = data(0.1, 5);
    let s = "tukey(qr)"
        .parse::<SolverSpec>()
        .expect("a solver")
        .build()
        .solve(&data.problem())
        .expect("full rank");
    let noise = s.info.noise.expect("an estimate");
    assert!((0.85..1.25).contains(&noise), "{noise}");
    let weights = s.info.row_weights.expect("weights");
    let lost = (0..VISITS).filter(|v| data.wrong[*v] && weights[ROWS * v] > 0.0).count();
    assert_eq!(lost, 0, "wrong visits that still count");
}

/// Expected held-out error over that of plain least squares.
fn against_plain(spec: &str, data: &Data) -> f64 {
    let solved = |spec: &str| {
        let solver = spec.parse::<SolverSpec>().expect("a solver").build();
        data.held_out(&solver.solve(&data.problem()).expect("full rank").x)
    };
    solved(spec) / solved("qr")
}

/// Draws of 16 to 75 visits with a third as many unknowns as numbers: where efficiency is dear and a descending loss has many minima.
#[test]
fn no_clean_draw_is_predicted_worse_than_by_plain_least_squares() {
    for seed in (0..60).step_by(4) {
        let visits = 16 + seed as usize;
        let data = sized(visits, visits, 0.0, 100 + seed);
        for spec in ROBUST {
            let ratio = against_plain(spec, &data);
            assert!(ratio <= 1.03, "{spec}, draw {seed}: {ratio}");
        }
    }
}

/// The same draws with 6 % of the visits wrong.
#[test]
fn spoiled_draws_are_predicted_better_than_by_plain_least_squares() {
    for seed in (0..60).step_by(4) {
        let visits = 16 + seed as usize;
        let data = sized(visits, visits / 2, 0.06, 100 + seed);
        if data.wrong.iter().all(|wrong| !wrong) {
            continue;
        }
        for spec in ROBUST {
            let ratio = against_plain(spec, &data);
            assert!(ratio < 1.0, "{spec}, draw {seed}: {ratio}");
        }
    }
}
