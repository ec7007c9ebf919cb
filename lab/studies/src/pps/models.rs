//! What is declared for the paper's robot: constant errors, the paper's polynomial, and physics.

use crate::prelude::*;
use serde_json::json;
use truepose_errormodel::ModelError;
use truepose_errormodel::effects::{
    BaseCompliance, Basis, Expansion, Factor, Guideway, Input, LinkCompliance, Place,
};

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
