//! A fit of blocks that come one after the other is the fit of the whole.

use truepose_errormodel::effects::{Geometric, JointCompliance};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, Schema};
use truepose_identify::{
    FitOptions, IdentifyError, NoiseSource, Source, Streamed, StreamedOptions, Tally, fit, identify_streamed,
    refit,
};
use truepose_kinematics::nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, Conditions, Load, Payload, TargetId, samples};
use truepose_solvers::{PivotedQr, Robust, SolverSpec};

/// Numbers from −1 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Nearly normal, of variance one.
    fn normal(&mut self) -> f64 {
        self.next() + self.next() + self.next()
    }
}

fn effects() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]
}

/// Visits of the heavy arm, three targets each, with errors of the model's own kind and 20 µm of noise.
fn measured(chain: &Chain, visits: usize) -> Dataset {
    let model = ErrorModel::new(chain.clone(), effects()).expect("a model");
    let mut draw = Draw(3);
    // Constant errors of the expected size; joints that sink by a milliradian or two.
    let size =
        |column: &truepose_errormodel::Column| column.scale * if column.site.is_some() { 0.2 } else { 0.02 };
    let truth: Vec<f64> = model.columns().iter().map(|c| size(c) * (1.0 + draw.next())).collect();
    let p = truth.len();
    let fitted = FittedModel::new(model, truth, DMatrix::zeros(p, p)).expect("coefficients for it");
    let schema = Schema { load: true, ..Schema::default() };
    let mut predictor = fitted.bind(&schema).expect("its signals");
    let mut data =
        Dataset { schema, joints: vec![Vec::new(); 6], approach: vec![Vec::new(); 6], ..Dataset::default() };
    for visit in 0..visits {
        let q: Vec<f64> = (0..6).map(|_| 1.9 * draw.next()).collect();
        let load =
            Load::Payload(Payload { mass: 45.0 * (visit % 3) as f64, com: Vector3::new(0.0, 0.0, 0.1) });
        let conditions = Conditions::at(chain, &q).with_load(load);
        for target in 0..3 {
            let at = predictor.predict(&conditions, Some(TargetId(target))).translation;
            data.position.push([0, 1, 2].map(|k| at[k] + 2e-5 * draw.normal()));
            data.joints.iter_mut().zip(&q).for_each(|(column, q)| column.push(*q));
            data.approach.iter_mut().for_each(|column| column.push(0.0));
            data.target.push(Some(TargetId(target)));
            data.visit.push(visit);
            data.load.push(load);
        }
    }
    let rows = data.visit.len();
    data.orientation = vec![None; rows];
    data.position_sd = vec![[f64::NAN; 3]; rows];
    data.orientation_sd = vec![[f64::NAN; 3]; rows];
    data.time = vec![0.0; rows];
    data
}

/// Blocks of a data set, so many visits each.
struct Blocks<'a> {
    data: &'a Dataset,
    visits: usize,
    passes: usize,
}

impl Source for Blocks<'_> {
    type Error = IdentifyError;

    fn sample(&mut self, rows: usize) -> Result<Dataset, IdentifyError> {
        let step = (self.data.len() / rows).max(1);
        let rows: Vec<usize> = (0..self.data.len()).filter(|row| (row / 3) % step == 0).collect();
        Ok(self.data.select(&rows))
    }

    fn each(
        &mut self,
        take: &mut dyn FnMut(&Dataset) -> Result<(), IdentifyError>,
    ) -> Result<(), IdentifyError> {
        self.passes += 1;
        let rows: Vec<usize> = (0..self.data.len()).collect();
        rows.chunks(3 * self.visits).try_for_each(|rows| take(&self.data.select(rows)))
    }
}

fn streamed(data: &Dataset, visits: usize, refine: bool, folds: usize) -> Streamed {
    let options = StreamedOptions { fit: FitOptions { refine, ..FitOptions::default() }, folds };
    let mut source = Blocks { data, visits, passes: 0 };
    identify_streamed(&samples::heavy(), &effects(), &mut source, &PivotedQr::default(), &options)
        .expect("a fit")
}

#[test]
fn it_is_the_fit_of_the_whole() {
    let chain = samples::heavy();
    let data = measured(&chain, 4000);
    let model = ErrorModel::new(chain.clone(), effects()).unwrap();
    let found = streamed(&data, 700, true, 5);
    // What the sample decided, on all rows at once.
    let options = FitOptions { noise: NoiseSource::Fixed(found.fit.noise), ..FitOptions::default() };
    let solver = PivotedQr::default();
    let whole = refit(&model, &data, &solver, &options, &found.fit.reduction, &found.fit.prior).unwrap();
    assert_eq!((found.rows, found.visits, found.fit.observations), (12_000, 4000, 36_000));
    assert!(found.sampled < 1500 && found.fit.converged, "{} {}", found.sampled, found.fit.rounds);
    assert!((found.fit.chi_square / whole.chi_square - 1.0).abs() < 1e-3);
    let sd = |k: usize| whole.fitted.covariance()[(k, k)].sqrt();
    for &k in &whole.reduction.kept {
        // Both end in a flat valley, in a tenth of a standard deviation.
        let (a, b) = (found.fit.fitted.coefficients()[k], whole.fitted.coefficients()[k]);
        assert!((a - b).abs() < 0.1 * sd(k), "{}: {a:e} {b:e} ± {:e}", model.columns()[k].name, sd(k));
        let spread = found.fit.fitted.covariance()[(k, k)].sqrt() / sd(k);
        assert!((spread - 1.0).abs() < 1e-2, "{spread}");
    }
    assert_eq!(found.fit.fitted.domain, whole.fitted.domain);
    let (train, exact) = (found.position, whole.residuals.positions());
    assert_eq!(train.count, exact.count);
    assert!(
        (train.rms - exact.rms).abs() < 1e-4 * exact.rms && (train.p95 - exact.p95).abs() < 1e-3 * exact.p95
    );
    // What the errors alone tell apart is in: three components of 20 µm, and a trifle more where the fit has not been.
    let held = found.held_out.expect("folds");
    let floor = 3f64.sqrt() * 2e-5;
    assert!((0.99..1.02).contains(&(held.position.rms / floor)), "{}", held.position.rms / floor);
    assert!(held.position.rms > train.rms && held.fold_rms.len() == 5);
    assert_eq!(held.position.count, 12_000);
}

#[test]
fn blocks_may_be_of_any_size() {
    let data = measured(&samples::heavy(), 900);
    let (one, other) = (streamed(&data, 900, true, 3), streamed(&data, 50, true, 3));
    for (a, b) in one.fit.fitted.coefficients().iter().zip(other.fit.fitted.coefficients()) {
        assert!((a - b).abs() <= 1e-7 * (a.abs() + b.abs()), "{a:e} {b:e}");
    }
    let held = |found: &Streamed| found.held_out.clone().expect("folds").position;
    assert!((held(&one).rms - held(&other).rms).abs() < 1e-9 * held(&one).rms);
}

#[test]
fn the_linear_fit_is_one_step_from_zero() {
    let chain = samples::heavy();
    let data = measured(&chain, 600);
    let model = ErrorModel::new(chain.clone(), effects()).unwrap();
    let options = FitOptions { refine: false, ..FitOptions::default() };
    let whole = fit(&model, &data, &PivotedQr::default(), &options).unwrap();
    let mut source = Blocks { data: &data, visits: 100, passes: 0 };
    let options = StreamedOptions { fit: options, folds: 0 };
    let solver = PivotedQr::default();
    let found = identify_streamed(&chain, &effects(), &mut source, &solver, &options).unwrap();
    assert_eq!((source.passes, found.fit.rounds), (2, 1));
    assert!(found.held_out.is_none());
    assert!(found.gram);
    assert!((found.position.rms - whole.residuals.positions().rms).abs() < 1e-2 * found.position.rms);
}

#[test]
fn what_has_to_see_all_rows_is_refused() {
    let chain = samples::heavy();
    let data = measured(&chain, 60);
    let options = StreamedOptions { fit: FitOptions::default(), folds: 0 };
    let mut source = Blocks { data: &data, visits: 10, passes: 0 };
    let robust = Robust::huber(PivotedQr::default());
    let error = identify_streamed(&chain, &effects(), &mut source, &robust, &options).unwrap_err();
    assert!(error.to_string().contains("has to see all rows at once"), "{error}");
    let ridge: SolverSpec = "ridge(gcv)".parse().unwrap();
    let error = identify_streamed(&chain, &effects(), &mut source, &*ridge.build(), &options).unwrap_err();
    assert!(matches!(error, IdentifyError::NotStreamed { .. }), "{error}");
    assert_eq!(source.passes, 0);
    let mut tally = Tally::default();
    tally.add([3.0, 4.0].into_iter());
    assert!((tally.spread().rms - 12.5f64.sqrt()).abs() < 1e-15);
}
