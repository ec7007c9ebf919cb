use super::*;
use crate::testkit::{check_effect, emitted};
use crate::{ErrorModel, FittedModel, Schema};
use std::f64::consts::FRAC_PI_2;
use truepose_kinematics::nalgebra::{DMatrix, Unit, vector};
use truepose_kinematics::{
    Conditions, Joint, JointKind, Link, Load, Payload, Placed, Placement, Pose, rotation_log, samples,
};

/// How far the tool moves and turns with these coefficients, in the measurement frame.
fn moved(
    chain: &Chain,
    effect: &LinkCompliance,
    c: &[f64],
    q: &[f64],
    load: Load,
) -> (Vector3<f64>, Vector3<f64>) {
    let model = ErrorModel::new(chain.clone(), vec![Box::new(effect.clone())]).unwrap();
    let fitted = FittedModel::new(model, c.to_vec(), DMatrix::zeros(c.len(), c.len())).unwrap();
    let mut predictor = fitted.bind(&Schema { load: true, ..Schema::default() }).unwrap();
    let real = predictor.predict(&Conditions::at(chain, q).with_load(load), None);
    let nominal = chain.forward(q);
    let turn = rotation_log(&(real.rotation * nominal.rotation.transpose()));
    (real.translation - nominal.translation, turn)
}

fn hung(mass: f64, com: [f64; 3]) -> Load {
    Load::Payload(Payload { mass, com: com.into() })
}

#[test]
fn conforms() {
    for chain in samples::all() {
        for section in [Section::Tube, Section::Symmetric, Section::General] {
            for own_weight in [OwnWeight::Declared, OwnWeight::Free] {
                for links in [0, 1, 9] {
                    check_effect(
                        &LinkCompliance { section, own_weight, links, ..LinkCompliance::default() },
                        &chain,
                    );
                }
            }
        }
    }
}

#[test]
fn a_cantilever_sags_as_in_the_textbook() {
    // One turn about the vertical, a beam of 1.2 m along x to the tool; 50 kg whose centre lies 0.3 m in front of
    // the tool and 0.2 m to its left; the beam itself weighs 30 kg.
    let (l, ei, gj, g) = (1.2, 4e6, 3e6, 9.81);
    let pose = Pose::IDENTITY;
    let joint = Joint::new(
        "j",
        JointKind::Revolute,
        Placement::Origin { pose, axis: Unit::new_normalize(Vector3::z()) },
    )
    .with_link(30.0, [0.6, 0.0, 0.0]);
    let tool = Placed { pose: Pose::from_xyz_rpy([l, 0.0, 0.0], [0.0; 3]), known: true };
    let chain = Chain::new("cantilever", vec![joint]).unwrap().with_tool(tool).unwrap();
    let beam = LinkCompliance { section: Section::Symmetric, ..LinkCompliance::default() };
    let (shift, turn) = moved(&chain, &beam, &[1.0 / ei, 1.0 / gj], &[0.0], hung(50.0, [0.3, 0.2, 0.0]));
    let (f, w) = (50.0 * g, 30.0 * g / l);
    let sag = f * l.powi(3) / (3.0 * ei) + f * 0.3 * l.powi(2) / (2.0 * ei) + w * l.powi(4) / (8.0 * ei);
    let slope = f * l.powi(2) / (2.0 * ei) + f * 0.3 * l / ei + w * l.powi(3) / (6.0 * ei);
    let twist = f * 0.2 * l / gj;
    // Deflections of 2e-4 m; what is left is of second order.
    assert!((shift.z + sag).abs() < 1e-7 && (turn.y - slope).abs() < 1e-7, "{shift} {turn}");
    assert!((turn.x + twist).abs() < 1e-7, "{turn}, twist {twist}");
    assert!(shift.x.abs() < 1e-7 && shift.y.abs() < 1e-7);
}

/// Rows (θ, d, a, α) of standard DH, with the masses' centres in the frames behind.
type Rows = Vec<(JointKind, [f64; 4], Option<Link>)>;

/// One robot in standard DH and as origins and axes in the same places; then in Craig's convention, which puts the turning
/// joints elsewhere on their axes, and as origins and axes in those places.
fn four_ways(rows: &Rows, tool: Pose) -> [Chain; 4] {
    let turn = |angle| Pose::rot(2, angle);
    let over = |a, alpha| Pose::trans(0, a) * Pose::rot(0, alpha);
    let made = |joints: Vec<Joint>, pose| {
        Chain::new("arm", joints).unwrap().with_tool(Placed { pose, known: true }).unwrap()
    };
    let joint = |k: usize, placement, behind: Pose| {
        let (kind, _, link) = rows[k];
        let joint = Joint::new(format!("j{}", k + 1), kind, placement).with_limits(-1.0, 1.0);
        match link {
            Some(link) => joint.with_link(link.mass, behind.apply(&link.com).into()),
            None => joint,
        }
    };
    let (mut dh, mut mdh, mut origin, mut other) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut before, mut pending) = ((0.0, 0.0), Pose::IDENTITY);
    for (k, &(kind, [theta, d, a, alpha], _)) in rows.iter().enumerate() {
        dh.push(joint(k, Placement::Dh { theta, d, a, alpha }, Pose::IDENTITY));
        let craig = Placement::Mdh { alpha: before.1, a: before.0, theta, d };
        mdh.push(joint(k, craig, over(a, alpha)));
        let placed = over(before.0, before.1) * turn(theta) * Pose::trans(2, d);
        let axis = Unit::new_normalize(Vector3::z());
        other.push(joint(k, Placement::Origin { pose: placed, axis }, over(a, alpha)));
        before = (a, alpha);
        // What follows the motion is fixed to the link: d for a turn; a slide stands at its carriage.
        let (pose, behind) = match kind {
            JointKind::Prismatic => (pending * turn(theta) * Pose::trans(2, d), over(a, alpha)),
            _ => (pending * turn(theta), Pose::trans(2, d) * over(a, alpha)),
        };
        origin.push(joint(k, Placement::Origin { pose, axis }, behind));
        pending = behind;
    }
    let behind = over(before.0, before.1) * tool;
    [made(dh, tool), made(origin, pending * tool), made(mdh, behind), made(other, behind)]
}

#[test]
fn a_robot_with_its_joints_in_the_same_places_bends_alike() {
    let (turn, slide) = (JointKind::Revolute, JointKind::Prismatic);
    let link = |mass, com: [f64; 3]| Some(Link { mass, com: com.into() });
    let arm: Rows = vec![
        (turn, [0.1, 0.5, 0.2, FRAC_PI_2], link(200.0, [-0.1, -0.2, 0.05])),
        (turn, [0.2, 0.12, 0.8, 0.3], link(90.0, [-0.4, 0.03, 0.02])),
        (turn, [0.0, -0.05, 0.15, -FRAC_PI_2], link(60.0, [-0.1, 0.1, 0.0])),
        (turn, [0.0, 0.7, 0.04, FRAC_PI_2], link(30.0, [0.0, -0.3, 0.0])),
    ];
    let cart: Rows = vec![
        (turn, [0.3, 0.6, 0.1, -FRAC_PI_2], link(200.0, [-0.1, 0.3, 0.05])),
        (slide, [0.2, 0.4, 0.05, FRAC_PI_2], link(90.0, [0.0, 0.03, 0.02])),
        (slide, [0.1, 0.3, 0.5, 0.2], None),
        (turn, [0.0, 0.2, 0.3, 0.1], link(20.0, [-0.1, 0.0, 0.0])),
    ];
    let tool = Pose::from_xyz_rpy([0.05, 0.1, 0.3], [0.3, 0.2, 0.1]);
    for rows in [arm, cart] {
        let ways = four_ways(&rows, tool);
        let q = [0.4, -0.3, 0.5, -0.7];
        for way in &ways[1..] {
            assert!((way.forward(&q).translation - ways[0].forward(&q).translation).norm() < 1e-14);
        }
        for section in [Section::Symmetric, Section::General] {
            for own_weight in [OwnWeight::Declared, OwnWeight::Free] {
                let joints = Some((1..=4).map(JointId).collect());
                let effect = LinkCompliance { joints, section, own_weight, ..LinkCompliance::default() };
                let columns = Effect::columns(&effect, &ways[0]).len();
                let c: Vec<f64> = (0..columns).map(|k| 1e-10 * (1.0 + k as f64)).collect();
                let load = hung(40.0, [0.1, 0.2, 0.1]);
                let [dh, origin, mdh, other] = ways.each_ref().map(|way| moved(way, &effect, &c, &q, load));
                assert!(dh.0.norm() > 1e-7, "{}", dh.0.norm());
                for (one, same) in [(dh, origin), (mdh, other)] {
                    // Second order of deflections of about 1e-6.
                    assert!((one.0 - same.0).norm() < 1e-4 * one.0.norm(), "{} {}", one.0, same.0);
                    assert!((one.1 - same.1).norm() < 1e-4 * one.1.norm(), "{} {}", one.1, same.1);
                }
            }
        }
    }
}

#[test]
fn the_two_planes_together_are_the_symmetric_section() {
    let chain = samples::heavy();
    let joints = Some(vec![JointId(2), JointId(4)]);
    let of = |section| LinkCompliance {
        joints: joints.clone(),
        section,
        own_weight: OwnWeight::Declared,
        ..LinkCompliance::default()
    };
    let (q, load) = ([0.3, -0.8, 0.9, 0.5, -0.4, 0.2], hung(80.0, [0.1, 0.2, 0.1]));
    let c = 1e-9;
    let symmetric = moved(&chain, &of(Section::Symmetric), &[c, TUBE * c, c, TUBE * c], &q, load);
    let general = moved(&chain, &of(Section::General), &[c, c, TUBE * c, c, c, TUBE * c], &q, load);
    let tube = moved(&chain, &of(Section::Tube), &[c, c], &q, load);
    assert!((symmetric.0 - general.0).norm() < 1e-13 && (symmetric.1 - general.1).norm() < 1e-13);
    assert!((symmetric.0 - tube.0).norm() < 1e-13 && (symmetric.1 - tube.1).norm() < 1e-13);
}

#[test]
fn free_weights_stand_for_an_even_link_and_a_mass_beyond_it() {
    // The same arm, once with declared masses and a stiffness, once with the products in the free coefficients.
    let [declared, ..] = four_ways(
        &vec![
            (
                JointKind::Revolute,
                [0.0, 0.0, 0.9, 0.0],
                Some(Link { mass: 40.0, com: vector![-0.45, 0.0, 0.0] }),
            ),
            (
                JointKind::Revolute,
                [0.0, 0.0, 0.7, 0.0],
                Some(Link { mass: 25.0, com: vector![-0.7, 0.0, 0.0] }),
            ),
        ],
        Pose::IDENTITY,
    );
    let upright = Placed { pose: Pose::from_xyz_rpy([0.0; 3], [FRAC_PI_2, 0.0, 0.0]), known: true };
    let declared = declared.with_base(upright).unwrap();
    let joints = Some(vec![JointId(1)]);
    let effect = LinkCompliance {
        joints,
        section: Section::Symmetric,
        own_weight: OwnWeight::Declared,
        ..LinkCompliance::default()
    };
    let free = LinkCompliance { own_weight: OwnWeight::Free, ..effect.clone() };
    let bare: Vec<Joint> = declared.joints().iter().map(|j| Joint { link: None, ..j.clone() }).collect();
    let bare = Chain::new("bare", bare).unwrap().with_base(upright).unwrap();
    let c = 1e-8;
    for q in [[0.3, -0.5], [-0.9, 0.4]] {
        let known = moved(&declared, &effect, &[c, c], &q, Load::None);
        let found = moved(&bare, &free, &[c, c, 40.0 * c, 25.0 * c], &q, Load::None);
        assert!(known.0.norm() > 1e-7);
        assert!((known.0 - found.0).norm() < 1e-13, "{} {}", known.0, found.0);
    }
}

#[test]
fn a_link_without_length_is_refused() {
    let error = Effect::validate(&LinkCompliance::of(JointId(1)), &samples::seven()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "effect `link_compliance`: the link behind joint `k1` has no length, so that it cannot bend"
    );
}

/// What the declared weights of a robot without payload bend lies in the span of the free ones with arms.
#[test]
fn free_weights_with_arms_span_what_declared_ones_do() {
    let postures = 40;
    for (chain, section) in [
        (samples::heavy(), Section::Tube),
        (samples::heavy(), Section::General),
        (samples::seven(), Section::General),
    ] {
        let long = |joint: &&JointId| chain.link_length(**joint) > 0.1;
        for &joint in chain.movable().iter().filter(long) {
            let declared = LinkCompliance { section, ..LinkCompliance::of(joint) };
            let free = LinkCompliance { own_weight: OwnWeight::Free, links: 9, ..declared.clone() };
            let (planes, stiffnesses) = (declared.planes(), declared.columns(&chain).len());
            let mut table = DMatrix::zeros(6 * postures, free.columns(&chain).len() - stiffnesses);
            let mut wanted = DMatrix::zeros(6 * postures, planes);
            for row in 0..postures {
                let angle = |k: usize| ((row * (7 + 4 * k)) as f64 * 0.37 + k as f64).sin();
                let q: Vec<f64> = (0..chain.movable().len()).map(angle).collect();
                let at = Conditions::at(&chain, &q);
                for entry in emitted(&free, &chain, &at) {
                    if let Some(column) = entry.column.checked_sub(stiffnesses) {
                        table[(6 * row + entry.site.axis().index(), column)] += entry.value;
                    }
                }
                for entry in emitted(&declared, &chain, &at).into_iter().filter(|entry| entry.column < planes)
                {
                    wanted[(6 * row + entry.site.axis().index(), entry.column)] += entry.value;
                }
            }
            let scale = wanted.norm();
            if scale == 0.0 {
                continue;
            }
            let solved: DMatrix<f64> =
                table.clone().svd(true, true).solve(&wanted, 1e-10 * table.norm()).unwrap();
            // A centre beside the link's own line bends it in a shape between those of the free weights.
            let off = (&table * solved - &wanted).norm() / scale;
            assert!(off < 0.02, "{} {joint:?} {section:?}: {off}", chain.name());
        }
    }
}
