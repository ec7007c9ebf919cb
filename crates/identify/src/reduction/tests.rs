use super::*;
use truepose_errormodel::effects::{Geometric, Where};
use truepose_errormodel::{Dataset, DatasetBuilder, EffectRegistry, ErrorModel, Measurement, Visits};
use truepose_kinematics::{Chain, Load, Target, TargetId, nalgebra::Vector3, samples};
use truepose_solvers::RankRule;

/// Postures spread over ±2.5 rad (m), seen as asked for.
fn postures(chain: &Chain, count: usize, orientation: bool, targets: &[Option<TargetId>]) -> Dataset {
    let mut builder = DatasetBuilder::new(chain);
    let joint = |visit: usize, k: usize| {
        let phase = (visit * (2 * k + 3)) as f64 * 0.6180339887 + 0.1 * k as f64;
        5.0 * (phase - phase.floor()) - 2.5
    };
    for visit in 0..count {
        let joints: Vec<f64> = (0..chain.movable().len()).map(|k| joint(visit, k)).collect();
        for &target in targets {
            let row = Measurement::at(joints.clone()).position([0.0; 3]).target(target).visit(visit as u64);
            builder.push(if orientation { row.orientation([1.0, 0.0, 0.0, 0.0]) } else { row }).unwrap();
        }
    }
    builder.finish()
}

fn frames_only(chain: &Chain) -> ErrorModel {
    let frames = Some(chain.frames().map(Where::Frame).collect());
    ErrorModel::new(chain.clone(), vec![Box::new(Geometric { frames, components: None })]).unwrap()
}

fn reduced(model: &ErrorModel, data: &Dataset) -> Reduction {
    let zero = vec![0.0; model.columns().len()];
    let factor = crate::linearise::factorise(
        model,
        data,
        &Visits::of(data),
        crate::NoiseModel::default(),
        &zero,
        None,
    )
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
        tool: truepose_kinematics::ToolId::FIRST,
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
        let rows = crate::linearise::collect(&model, &data, &Visits::of(&data), noise, &zero).unwrap();
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
    let mut data = postures(&chain, 150, false, &[Some(TargetId(0)), Some(TargetId(1)), Some(TargetId(2))]);
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
    let words: Vec<String> = reduction.groups.iter().map(|g| group_words(&model, g).0).collect();
    insta::assert_snapshot!(words.join("\n"));
}
