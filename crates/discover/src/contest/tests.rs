//! Contests on small data with one joint that is off, and with two.

use crate::contest::competition::{Contest, contest};
use crate::contest::competitor::{Competitor, competitor};
use crate::contest::look_ahead;
use crate::contest::pair::{Side, pair_score};
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::synthetic::{data_of, fitted, normal};
use crate::screen::candidates::Screen;
use truepose_errormodel::{Dataset, Visits};
use truepose_kinematics::Chain;

/// An arm whose third joint has a transmission error of 0.4 mrad, nine cycles a radian times `finer`.
fn measured(finer: f64) -> (Chain, Dataset) {
    let actual = move |joints: &[f64]| {
        let mut actual = joints.to_vec();
        actual[2] += 4e-4 * (9.0 * finer * joints[2]).sin();
        actual
    };
    data_of(60, 5, &actual, &|_, _, row| std::array::from_fn(|axis| 2e-5 * normal(3 * row + axis)))
}

fn held(chain: &Chain, data: &Dataset, options: &DiscoverOptions, see: impl FnOnce(&Contest, f64)) {
    let fit = fitted(chain, data);
    let linearisation = Linearisation::new(&fit, data, options).unwrap();
    let screen = Screen::new(&linearisation, &options.library, &[]);
    let p = screen.null(&linearisation, options.rotations, options.seed).unwrap().p_value(screen.largest());
    see(&contest(&linearisation, &screen, &[], true).unwrap(), p);
}

#[test]
fn a_transmission_error_wins_at_its_joint_with_its_period() {
    let (chain, data) = measured(1.0);
    held(&chain, &data, &DiscoverOptions::default(), |contest, p| {
        assert!(p < 0.002, "{p}");
        let first = &contest.competitors[0];
        assert_eq!(
            (first.candidate.family, first.candidate.words()),
            (Family::Transmission, "transmission j3".into())
        );
        let period = first.candidate.effects()[0].parameters()["period"].as_f64().unwrap();
        assert!((period / (std::f64::consts::TAU / 9.0) - 1.0).abs() < 0.01, "{period}");
        assert!(first.score < contest.present.deviance);
        // Best first.
        assert!(contest.competitors[1..].windows(2).all(|pair| pair[0].score <= pair[1].score + 6.0));
    });
}

#[test]
fn the_order_of_rows_and_where_the_base_stands_change_nothing() {
    let (chain, data) = measured(0.7);
    let options = DiscoverOptions { rotations: 499, ..DiscoverOptions::default() };
    let mut first = None;
    held(&chain, &data, &options, |contest, p| {
        first = Some((contest.competitors[0].candidate.words(), contest.competitors[0].score, p));
    });
    let (words, score, p) = first.unwrap();
    let backwards: Vec<usize> = (0..data.len()).rev().collect();
    let other = data.select(&backwards);
    let mut base = *chain.base();
    base.pose.translation += nalgebra::Vector3::new(0.3, -0.2, 0.1);
    let moved = chain.clone().with_base(base).unwrap();
    let mut shifted = data.clone();
    for position in &mut shifted.position {
        *position = std::array::from_fn(|axis| position[axis] + [0.3, -0.2, 0.1][axis]);
    }
    for (chain, data) in [(&chain, &other), (&moved, &shifted)] {
        held(chain, data, &options, |contest, again| {
            let best = &contest.competitors[0];
            assert_eq!(best.candidate.words(), words);
            assert!((best.score - score).abs() < 1e-3 * score.abs(), "{} {score}", best.score);
            // Signs are drawn for poses in their order.
            assert!((again - p).abs() < 0.01, "{again} {p}");
        });
    }
}

/// An arm with transmission errors of j2 and j4: competitors of j6, which has none, of j2 and of j4.
fn two_of(data: impl FnOnce(&Linearisation<'_>, &Screen, Vec<Competitor>)) {
    let actual = |joints: &[f64]| {
        let mut actual = joints.to_vec();
        actual[1] += 3e-4 * (2.0 * joints[1]).sin();
        actual[3] += 5e-4 * (3.0 * joints[3]).cos();
        actual
    };
    let (chain, rows) =
        data_of(60, 8, &actual, &|_, _, row| std::array::from_fn(|axis| 2e-5 * normal(3 * row + axis)));
    let fit = fitted(&chain, &rows);
    let options = DiscoverOptions::default();
    let linearisation = Linearisation::new(&fit, &rows, &options).unwrap();
    let screen = Screen::new(&linearisation, &options.library, &[]);
    let of = |words: &str| -> Competitor {
        let causes = screen.causes(&linearisation);
        let found = causes.iter().flat_map(|cause| &cause.variants).map(|variant| &variant.0);
        let candidate: Candidate = (**found.into_iter().find(|c| c.words() == words).expect(words)).clone();
        competitor(&linearisation, &screen, &Visits::of(&rows), candidate).unwrap().expect(words)
    };
    data(&linearisation, &screen, ["transmission j6", "transmission j2", "transmission j4"].map(of).into());
}

#[test]
fn a_pair_explains_what_neither_of_it_does() {
    two_of(|linearisation, screen, competitors| {
        let visits = Visits::of(linearisation.data);
        let of = |a: usize, b: usize| {
            let side = |k: usize| {
                let Competitor { candidate, columns, freedom, .. } = &competitors[k];
                Side { candidate, columns, freedom: *freedom }
            };
            pair_score(linearisation, screen, &visits, [side(a), side(b)]).unwrap().total
        };
        // The order of a pair is none, and one that explains nothing makes it worse by its penalty.
        assert!((of(1, 2) - of(2, 1)).abs() < 1e-6 * of(1, 2).abs());
        assert!(of(1, 2) < competitors[1].score.min(competitors[2].score) - 50.0);
        assert!(of(0, 2) > competitors[2].score);
    });
}

#[test]
fn a_leader_that_no_good_pair_needs_gives_way() {
    two_of(|linearisation, screen, mut competitors| {
        let visits = Visits::of(linearisation.data);
        let causes = screen.causes(linearisation);
        let first = |competitors: &mut [Competitor]| {
            look_ahead::join(linearisation, screen, &visits, competitors, &causes.iter().collect::<Vec<_>>())
                .unwrap();
            look_ahead::first(competitors, linearisation.policy)
        };
        // The joint that is not off leads a list in which both others are.
        let chosen = first(&mut competitors);
        assert!(chosen > 0, "{}", competitors[chosen].candidate.words());
        // Where one of the pair leads, it stays.
        competitors.rotate_left(2);
        assert_eq!(competitors[0].candidate.words(), "transmission j4");
        assert_eq!(first(&mut competitors), 0);
        assert_eq!(first(&mut competitors[..1]), 0);
    });
}
