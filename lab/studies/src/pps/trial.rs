//! One plant: its measurements, and what a model identified from them leaves.
//!
//! What is declared for the paper's robot: constant errors, the paper's polynomial, and physics.

use crate::prelude::*;
use rand::seq::SliceRandom;
use serde_json::json;
use truepose_errormodel::effects::{
    BaseCompliance, Basis, Expansion, Factor, Guideway, Input, LinkCompliance, Place,
};
use truepose_errormodel::{ModelError, Predictor};
use truepose_simulate::robots;

/// A plant and everything that the paper measured on it.
pub struct Experiment {
    plant: Plant,
    /// Set b) and half of set a).
    identification: Dataset,
    /// The other half of set a).
    pub check: Vec<Check>,
    /// Configurations used for the identification.
    pub configurations: usize,
    /// Largest deviation from a straight line of the treatment point's displacement against the payload at home, m.
    pub linearity: f64,
}

/// One check configuration.
pub struct Check {
    conditions: Conditions,
    measured: Vector3<f64>,
    truth: Vector3<f64>,
    nominal: Vector3<f64>,
}

/// What a model leaves at the check configurations.
pub struct Radii {
    pub measured: f64,
    pub noise_only: f64,
    pub noise_free: f64,
    /// Largest distance of the true treatment point from where it is wanted, when the plant gets the compensated commands.
    pub executed: f64,
    /// Check configurations whose command is not `ok`.
    pub missed: usize,
    pub columns: usize,
    pub rank: usize,
    pub rounds: usize,
}

impl Experiment {
    /// Measures a plant of this seed.
    pub fn new(seed: u64) -> Outcome<Self> {
        let plant = robots::pps_plant(seed)?;
        let chain = plant.chain().clone();
        let a = plant.measure(&Campaign::paper_set_a(&chain)?, seed)?;
        let b = plant.measure(&Campaign::paper_set_b(&chain)?, seed + 1)?;
        let visits = Visits::of(&a);
        let mut order: Vec<usize> = (0..visits.len()).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        let (used, checked) = order.split_at(visits.len() / 2);
        let rows: Vec<usize> = used.iter().flat_map(|&v| visits.rows[v].iter().copied()).collect();
        let identification = joined(&b, &a.select(&rows));
        let check =
            checked.iter().map(|&v| check(&plant, &chain, &a, &visits.rows[v])).collect::<Outcome<_>>()?;
        let configurations = Visits::of(&identification).len();
        let loads = load_test(&plant, &chain, seed)?;
        Ok(Experiment { identification, check, configurations, linearity: off_the_line(&loads), plant })
    }

    /// Largest distance between the measured and the nominal treatment point, m.
    pub fn before(&self) -> f64 {
        self.check.iter().map(|c| (c.measured - c.nominal).norm()).fold(0.0, f64::max)
    }

    /// Largest distance between the measured and the true treatment point, m.
    pub fn noise_only(&self) -> f64 {
        self.check.iter().map(|c| (c.measured - c.truth).norm()).fold(0.0, f64::max)
    }

    /// Identifies from the measurements.
    pub fn fit(&self, strategy: &Strategy) -> Outcome<Fit> {
        let chain = self.plant.chain();
        let model = ErrorModel::new(chain.clone(), (strategy.effects)(chain)?)?;
        let Strategy { prior, refine, second_reduction, rounds: max_iterations, .. } = *strategy;
        let options = FitOptions { prior, refine, second_reduction, max_iterations, ..FitOptions::default() };
        Ok(fit(&model, &self.identification, &*strategy.solver.build(), &options)?)
    }

    /// Identifies, and judges at the check configurations.
    pub fn identify(&self, strategy: &Strategy) -> Outcome<Radii> {
        let fit = self.fit(strategy)?;
        let mut predictor = fit.fitted.bind(&self.identification.schema)?;
        let (executed, reached) = self.execute(&fit.fitted)?;
        let mut radii = Radii {
            measured: 0.0,
            noise_only: self.noise_only(),
            noise_free: 0.0,
            executed,
            missed: self.check.len() - reached,
            columns: fit.fitted.coefficients().len(),
            rank: fit.reduction.rank(),
            rounds: fit.rounds,
        };
        for check in &self.check {
            let predicted = predicted(&mut predictor, self.plant.chain(), &check.conditions)?;
            radii.measured = radii.measured.max((check.measured - predicted).norm());
            radii.noise_free = radii.noise_free.max((check.truth - predicted).norm());
        }
        Ok(radii)
    }

    /// Sends the plant to where the nominal robot has the couch at each check configuration: the largest distance of the true
    /// treatment point from where it is wanted, m, and at how many of them the command was `ok`.
    fn execute(&self, fitted: &FittedModel) -> Outcome<(f64, usize)> {
        // The treatment point is no target: the tool is sent so that it comes right, and moves with the tool.
        const ROUNDS: usize = 3;
        let chain = self.plant.chain();
        let schema = &self.identification.schema;
        let mut compensator = Compensator::bind(fitted, schema, CompensatorOptions::default())?;
        let mut predictor = fitted.bind(schema)?;
        let (mut largest, mut reached) = (0.0_f64, 0);
        for check in &self.check {
            let tool = chain.forward(&check.conditions.joints);
            let mut goal = Goal::at(tool.translation).turned(tool.rotation);
            let mut commanded = check.conditions.clone();
            let mut ok = true;
            for _ in 0..ROUNDS {
                let command = compensator.command(&goal, &check.conditions, Some(&check.conditions.joints));
                ok = command.status == Status::Ok;
                commanded.joints = command.joints.to_vec();
                goal.position += check.nominal - predicted(&mut predictor, chain, &commanded)?;
            }
            if ok {
                reached += 1;
                largest = largest.max((true_point(&self.plant, chain, &commanded)? - check.nominal).norm());
            }
        }
        Ok((largest, reached))
    }
}

/// Where a model has the treatment point, m.
fn predicted(predictor: &mut Predictor<'_>, chain: &Chain, conditions: &Conditions) -> Outcome<Vector3<f64>> {
    let seen: Vec<Vector3<f64>> = (0..chain.targets().len())
        .map(|t| predictor.predict(conditions, Some(TargetId(t))).translation)
        .collect();
    Ok(robots::treatment_point(chain, &seen)?)
}

/// Where the plant has it, without any noise, m.
fn true_point(plant: &Plant, chain: &Chain, conditions: &Conditions) -> Outcome<Vector3<f64>> {
    let seen = (0..chain.targets().len())
        .map(|t| plant.true_position(conditions, Some(TargetId(t))))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(robots::treatment_point(chain, &seen)?)
}

fn check(plant: &Plant, chain: &Chain, data: &Dataset, rows: &[usize]) -> Outcome<Check> {
    let conditions = data.conditions(rows[0]);
    let seen: Vec<Vector3<f64>> = rows.iter().map(|&row| data.measured_position(row)).collect();
    let tool = chain.forward(&conditions.joints);
    let nominal: Vec<Vector3<f64>> = chain.targets().iter().map(|t| tool.apply(&t.position)).collect();
    Ok(Check {
        measured: robots::treatment_point(chain, &seen)?,
        truth: true_point(plant, chain, &conditions)?,
        nominal: robots::treatment_point(chain, &nominal)?,
        conditions,
    })
}

/// Measured treatment points of each visit.
fn points(chain: &Chain, data: &Dataset) -> Outcome<Vec<Vector3<f64>>> {
    Visits::of(data)
        .rows
        .iter()
        .map(|rows| {
            let seen: Vec<Vector3<f64>> = rows.iter().map(|&row| data.measured_position(row)).collect();
            Ok(robots::treatment_point(chain, &seen)?)
        })
        .collect()
}

/// Displacement of the treatment point from the empty one, by payload.
fn load_test(plant: &Plant, chain: &Chain, seed: u64) -> Outcome<Vec<(f64, f64)>> {
    let measured = points(chain, &plant.measure(&Campaign::paper_linearity(), seed + 2)?)?;
    Ok(measured.iter().enumerate().map(|(k, p)| (25.0 * k as f64, (p - measured[0]).norm())).collect())
}

/// Largest distance from the least-squares line.
fn off_the_line(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
        / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>();
    points.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).abs()).fold(0.0, f64::max)
}

/// Two data sets of one robot, one after the other; visits of the second follow those of the first.
fn joined(first: &Dataset, second: &Dataset) -> Dataset {
    let mut all = first.clone();
    let offset = Visits::of(first).len();
    all.visit.extend(second.visit.iter().map(|v| v + offset));
    for (columns, more) in [
        (&mut all.joints, &second.joints),
        (&mut all.approach, &second.approach),
        (&mut all.channels, &second.channels),
    ] {
        columns.iter_mut().zip(more).for_each(|(column, more)| column.extend(more));
    }
    all.position.extend(&second.position);
    all.orientation.extend(&second.orientation);
    all.position_sd.extend(&second.position_sd);
    all.orientation_sd.extend(&second.orientation_sd);
    all.target.extend(&second.target);
    all.load.extend(&second.load);
    all.time.extend(&second.time);
    all.line.clear();
    all
}

/// Effects, unless one of them does not fit the robot.
type Declared = Result<Vec<Box<dyn AnyEffect>>, ModelError>;

/// A declared model, and how it is fitted.
pub struct Strategy {
    /// For the table.
    pub name: String,
    /// The declared effects.
    pub effects: fn(&Chain) -> Declared,
    /// Scale of the prior standard deviations.
    pub prior: PriorStrength,
    /// The solver.
    pub solver: SolverSpec,
    /// Rounds at the exact robot, or the paper's single linear step.
    pub refine: bool,
    /// Whether identifiability is determined again at the exact robot.
    pub second_reduction: bool,
    /// Rounds at most.
    pub rounds: usize,
}

/// All of them.
pub fn strategies() -> Vec<Strategy> {
    let strategy = |name: &str, effects, prior, solver: &str| Strategy {
        name: name.into(),
        effects,
        prior,
        solver: solver.parse().unwrap_or_default(),
        refine: true,
        second_reduction: true,
        // Polynomials without a prior lie in flat valleys: what more rounds than these gain is not worth its time.
        rounds: 25,
    };
    use PriorStrength::{Evidence, None};
    let once =
        |name: &str, effects| Strategy { second_reduction: false, ..strategy(name, effects, Evidence, "qr") };
    let linear = |name: &str, effects| Strategy { refine: false, ..strategy(name, effects, None, "qr") };
    vec![
        strategy("constant errors, qr", constant, None, "qr"),
        linear("constant errors, one linear step", constant),
        strategy("physics (compliances, beam, rails), evidence", physics, Evidence, "qr"),
        once("the same, reduced at the nominal robot", physics),
        once("turning springs, beam, short rails, the same way", lean),
        Strategy { rounds: 3, ..once("the same in three rounds", lean) },
        Strategy { rounds: 2, ..once("the same in two rounds", lean) },
        strategy("physics (compliances, beam, rails), no prior", physics, None, "qr"),
        strategy("frame compliances, evidence prior, qr", elastic, Evidence, "qr"),
        strategy("Eq. (17) polynomial, evidence prior, qr", polynomial, Evidence, "qr"),
        strategy("Eq. (17) polynomial, qr", polynomial, None, "qr"),
        linear("Eq. (17) polynomial, one linear step", polynomial),
        linear("the same, reduced first (the paper's order)", reduced_first),
        strategy("Eq. (17) polynomial, svd", polynomial, None, "svd"),
        strategy("Eq. (17) polynomial, normal equations", polynomial, None, "normal"),
        strategy("Eq. (17) polynomial, ridge(map)", polynomial, None, "ridge(map)"),
    ]
}

fn constant(_: &Chain) -> Declared {
    Ok(vec![Box::new(Geometric::default())])
}

/// The paper's declared model: degree 3 in each slide and in theta, 1 in the small turns, one wrench component.
pub fn polynomial(chain: &Chain) -> Declared {
    in_order(chain, "expand_first")
}

/// The same in the paper's order.
pub fn reduced_first(chain: &Chain) -> Declared {
    in_order(chain, "reduce_first")
}

fn in_order(chain: &Chain, order: &str) -> Declared {
    let registry = EffectRegistry::builtin();
    let polynomial = json!({"degree": 3, "small": [5, 6], "wrench": ["fy"], "order": order});
    Ok(vec![
        registry.build("geometric", json!({"frames": [0, 7, "targets"]}), chain)?,
        registry.build("polynomial", polynomial, chain)?,
    ])
}

/// Every frame has a compliance for each component of its wrench: six per frame.
fn elastic(chain: &Chain) -> Declared {
    springs(chain, &Axis::ALL)
}

/// Every frame has compliances along and about these axes; the couch is a beam, the base is compliant.
fn springs(chain: &Chain, axes: &[Axis]) -> Declared {
    let mut effects = constant(chain)?;
    for frame in (0..=chain.joints().len()).map(FrameId) {
        for &axis in axes {
            let of = Input::Wrench { frame, component: axis.index() };
            effects.push(Box::new(Expansion {
                at: Place::Frame { frame, components: vec![axis] },
                factors: vec![Factor { of, basis: Basis::Powers(vec![1]) }],
            }));
        }
    }
    effects.push(Box::new(LinkCompliance::of(JointId(6))));
    effects.push(Box::new(BaseCompliance::default()));
    Ok(effects)
}

/// The same, with errors of the linear guideways.
fn physics(chain: &Chain) -> Declared {
    Ok(on_rails(elastic(chain)?, 6))
}

/// Rotational compliance of frames, and guideways with three spline pieces at most.
fn lean(chain: &Chain) -> Declared {
    Ok(on_rails(springs(chain, &Axis::ROTATIONS)?, 3))
}

/// With guideways as splines of this number of pieces.
fn on_rails(mut effects: Vec<Box<dyn AnyEffect>>, pieces: usize) -> Vec<Box<dyn AnyEffect>> {
    for slide in 1..=3 {
        effects.push(Box::new(Guideway { pieces, ..Guideway::of(JointId(slide)) }));
    }
    effects
}
