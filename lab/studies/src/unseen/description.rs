//! What a robot of this study is: everything that decides it, in one struct, drawn from its key.
//!
//! | kind | cells | question |
//! | --- | --- | --- |
//! | `power` | 20, 25, 30, 40, 60, 100 poses | a cause inside the vocabulary at 5 times the noise: found, named first, listed? |
//! | `outside` | – | a cause without a word, 2 to 10 times the noise, 20 to 1000 poses: verdict, wrong names |
//! | `null` | – | nothing hidden, shuffled, white noise: false alarms, p-values |
//! | `memory` | φ = 0, 0.2, 0.4, 0.6, swept and shuffled | noise between poses with a memory: false alarms |
//! | `flicker` | – | encoders flicker by 1e-5 to 1e-4°, without a column `visit`: false alarms |
//! | `columns` | – | without `visit`, time, approach or all of them: false alarms |
//! | `joints` | – | repeatability in joint space, with and without orientations: false alarms |
//! | `stated` | a third of the truth, three times the truth | stated deviations are wrong: repeatability limit, false alarms |
//! | `bad` | 1, 2, 3 poses | all targets of a pose moved by 0.5 to 2 mm, of 100 poses: reported? what do they change? |
//! | `rows` | – | 2 % of the rows are outliers |
//! | `unweighed` | base_tilt, link_bending, joint_compliance; drives, and all of them bare | the same cause at 5 times the noise in 30 to 100 poses of a robot whose weights are not declared, bare: without payloads: name |
//! | `everything` | 150, 300, 1000 poses | all usual causes at once: held-out error, the two largest named, the error after compensation |
//! | `words` | one for each row of the vocabulary | the same at 5 times the noise in 130 poses: found, named, held-out error |
//!
//! Robots of one number have the same geometry, noise and cause in all cells of a kind: cells are compared in pairs.

use super::amend;
use super::cause::Cause;
use super::robots::{MAKES, Make};
use super::stream::{Key, Part};
use crate::prelude::*;

/// A kind of campaign; the place is the number in a key and never changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    Power,
    Outside,
    Null,
    Memory,
    Flicker,
    Columns,
    Joints,
    Stated,
    Bad,
    Rows,
    Words,
    Unweighed,
    Everything,
}

/// What yields under weights that are not declared.
const YIELDING: [Cause; 4] = [Cause::BaseTilt, Cause::LinkBending, Cause::JointCompliance, Cause::Drives];
/// In the name of a cell: no payload but the robot itself.
const BARE: &str = " bare";

/// Numbers of poses at which power is evaluated.
pub const POSES: [usize; 6] = [20, 25, 30, 40, 60, 100];

impl Kind {
    /// Names of its cells.
    pub fn cells(self) -> Vec<String> {
        match self {
            Kind::Power => POSES.iter().map(usize::to_string).collect(),
            Kind::Memory => {
                let both = |memory: &str| ["shuffled", "swept"].map(|order| format!("{memory} {order}"));
                ["0", "0.2", "0.4", "0.6"].iter().flat_map(|memory| both(memory)).collect()
            }
            Kind::Stated => vec!["1/3".into(), "3".into()],
            Kind::Words => Cause::with_word().iter().map(Word::word).collect(),
            Kind::Bad => vec!["1".into(), "2".into(), "3".into()],
            Kind::Everything => amend::POSES.iter().map(usize::to_string).collect(),
            Kind::Unweighed => {
                let with = |suffix: &str| YIELDING.map(|cause| format!("{}{suffix}", cause.word()));
                ["", BARE].iter().flat_map(|suffix| with(suffix)).collect()
            }
            _ => vec![String::new()],
        }
    }

    /// The key of a robot of this kind in a cell. Rows of the vocabulary have robots of their own, so that what is counted over them is counted over
    /// independent noise; the cells of another kind are the same robots under other conditions.
    pub fn key_in(self, cell: &str, half: Half, number: u64) -> Key {
        let place = match self {
            Kind::Words => {
                self.cells().iter().position(|one| one == cell).map_or(0, |place| place as u64 + 1)
            }
            _ => 0,
        };
        Key { cell: place, ..self.key(half, number) }
    }

    /// The key of a robot of this kind.
    pub fn key(self, half: Half, number: u64) -> Key {
        Key { half, series: 1, kind: self as u64, cell: 0, number }
    }
}

/// Order of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Order {
    Shuffled,
    Snake,
    JointByJoint,
}

/// Which optional columns the record has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Columns {
    pub visit: bool,
    pub time: bool,
    pub approach: bool,
    pub temperature: bool,
}

/// A robot of this study.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    pub make: Make,
    pub cause: Option<Cause>,
    /// Size of the cause: what the declared model cannot absorb (3-D RMS over a dense campaign) over the noise of a row.
    pub size: f64,
    pub poses: usize,
    pub targets: usize,
    /// Poses that are measured a second time.
    pub repeats: usize,
    pub order: Order,
    /// Whether payloads differ between poses.
    pub loads: bool,
    /// Whether the description has the weights of the links.
    pub weights: bool,
    /// Whether joint compliances are present, and declared.
    pub compliance: bool,
    /// Instrument and repeatability, µm an axis.
    pub noise_um: [f64; 2],
    /// Of the repeatability from pose to pose; 0 is white.
    pub memory: f64,
    /// Repeatability comes from the joints.
    pub joint_noise: bool,
    /// Student's t with five degrees of freedom.
    pub heavy_tails: bool,
    pub orientation: bool,
    /// Stated over true standard deviation of the instrument; none states nothing.
    pub stated: Option<f64>,
    /// Amplitude of the recorded joint values, degrees (slides: the same number in units of 17.5 mm).
    pub flicker_deg: f64,
    pub columns: Columns,
    pub bad_poses: usize,
    /// Fraction of the rows that are outliers.
    pub outliers: f64,
}

impl Description {
    /// The robot of this key in a cell of its kind.
    pub fn of(kind: Kind, cell: &str, key: Key) -> Self {
        let mut draw = key.draw(Part::Description);
        let mut one = Description::usual(&mut draw);
        let fewer = |one: &mut Description, poses: usize| {
            one.poses = poses;
            one.repeats = if one.repeats > 0 { (poses / 8).max(2) } else { 0 };
        };
        match kind {
            Kind::Power => {
                one.cause = Some(draw.one(Cause::with_family()));
                one.size = 5.0;
                fewer(&mut one, cell.parse().unwrap_or(60));
            }
            Kind::Outside => {
                one.cause = Some(draw.one(Cause::without_word()));
                one.size = draw.logarithmic(2.0, 10.0);
                let poses = draw.logarithmic(20.0, 1000.0).round() as usize;
                fewer(&mut one, poses);
                one.order = draw.one(Order::all());
            }
            Kind::Null => one.heavy_tails = draw.chance(0.33),
            Kind::Memory => {
                let (memory, order) = cell.split_once(' ').unwrap_or(("0", "shuffled"));
                one.memory = memory.parse().unwrap_or(0.0);
                // Of an arm that repeats three times worse than its tracker measures, in a campaign in which a memory tells.
                one.noise_um[0] = 0.3 * one.noise_um[1];
                let poses = draw.logarithmic(40.0, 300.0).round() as usize;
                fewer(&mut one, poses);
                let swept = draw.one(&[Order::Snake, Order::JointByJoint]);
                one.order = if order == "swept" { swept } else { Order::Shuffled };
            }
            Kind::Flicker => {
                one.flicker_deg = draw.logarithmic(1e-5, 1e-4);
                one.columns.visit = false;
                one.targets = draw.one(&[2, 3]);
                one.order = draw.one(Order::all());
            }
            Kind::Columns => {
                let missing = [0.0; 3].map(|_: f64| draw.chance(0.6));
                one.columns.visit = !missing[0];
                one.columns.time = !missing[1];
                one.columns.approach = !missing[2];
                one.columns.temperature = draw.chance(0.5);
                one.order = draw.one(Order::all());
            }
            Kind::Joints => {
                one.joint_noise = true;
                one.orientation = draw.chance(0.5);
            }
            Kind::Stated => {
                one.stated = Some(if cell == "3" { 3.0 } else { 1.0 / 3.0 });
                // Half of them have nothing but what is stated to go by.
                one.repeats = if draw.chance(0.5) { 0 } else { one.poses / 8 };
            }
            Kind::Bad => {
                fewer(&mut one, 100);
                one.bad_poses = cell.parse().unwrap_or(1);
                one.targets = draw.one(&[2, 3]);
            }
            Kind::Rows => one.outliers = 0.02,
            Kind::Unweighed => {
                one.cause = Cause::named(cell.trim_end_matches(BARE));
                one.size = 5.0;
                let poses = draw.logarithmic(30.0, 100.0).round() as usize;
                fewer(&mut one, poses);
                one.make = draw.one(&[Make::Elbow, Make::Elbow, Make::Tree]);
                // Nothing else that is not declared depends on weights.
                (one.weights, one.compliance) = (false, false);
            }
            Kind::Everything => {
                one.cause = Some(Cause::Everything);
                one.size = draw.logarithmic(amend::SIZES[0], amend::SIZES[1]);
                fewer(&mut one, cell.parse().unwrap_or(amend::POSES[0]));
                one.make = draw.one(&[Make::Elbow, Make::Elbow, Make::Tree]);
                (one.joint_noise, one.columns.approach) = (true, true);
            }
            Kind::Words => {
                one.cause = Cause::named(cell);
                one.size = 5.0;
                fewer(&mut one, 130);
                if let Some(cause) = one.cause {
                    one.show(cause, &mut draw);
                }
            }
        }
        if let Some(cause) = one.cause {
            one.loads |= cause.needs_loads();
            one.compliance |= cause.needs_compliance();
        }
        one.loads &= !cell.ends_with(BARE);
        one
    }

    /// What a campaign needs so that it can be seen at all.
    fn show(&mut self, cause: Cause, draw: &mut Draw) {
        match cause {
            Cause::Bridge | Cause::Ram => self.make = Make::Gantry,
            Cause::FourBar => self.make = draw.one(&[Make::Elbow, Make::Tree]),
            // Arms whose joints carry weights.
            _ => self.make = draw.one(&[Make::Elbow, Make::Elbow, Make::Tree]),
        }
        self.columns.temperature = matches!(cause, Cause::WholeArm | Cause::Lubricant) || draw.chance(0.3);
        self.columns.approach = true;
        use Cause::{Bridge, Creep, Label, Lubricant, Ram, Spring, TiltingBearing};
        let carries = matches!(cause, Creep | Lubricant | TiltingBearing | Bridge | Ram | Label | Spring);
        (self.loads, self.compliance) = (self.loads | carries, self.compliance | carries);
    }

    /// Nothing hidden, nothing wrong.
    fn usual(draw: &mut Draw) -> Self {
        let poses = draw.logarithmic(20.0, 150.0).round() as usize;
        let temperature = draw.chance(0.6);
        Description {
            make: draw.one(&MAKES),
            cause: None,
            size: 0.0,
            poses,
            targets: 1 + draw.below(3),
            repeats: if draw.chance(0.6) { (poses / 8).max(2) } else { 0 },
            order: Order::Shuffled,
            loads: draw.chance(0.5),
            weights: true,
            compliance: draw.chance(0.4),
            noise_um: [draw.logarithmic(8.0, 30.0), draw.logarithmic(10.0, 50.0)],
            memory: 0.0,
            joint_noise: false,
            heavy_tails: false,
            orientation: draw.chance(0.2),
            stated: if draw.chance(0.4) { Some(1.0) } else { None },
            flicker_deg: 0.0,
            columns: Columns { visit: true, time: true, approach: draw.chance(0.6), temperature },
            bad_poses: 0,
            outliers: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_describes_the_same_robot_again_and_cells_share_it() {
        let key = Kind::Power.key(Half::Tuning, 5);
        let at = |cell: &str| Description::of(Kind::Power, cell, key);
        assert_eq!(at("20"), at("20"));
        let (few, many) = (at("20"), at("100"));
        assert_eq!((few.poses, many.poses), (20, 100));
        assert_eq!((few.make, few.cause, few.noise_um), (many.make, many.cause, many.noise_um));
        assert_ne!(at("20"), Description::of(Kind::Power, "20", Kind::Power.key(Half::Locked, 5)));
    }

    #[test]
    fn rows_of_the_vocabulary_have_robots_of_their_own() {
        let key = |kind: Kind, cell: usize| kind.key_in(&kind.cells()[cell], Half::Tuning, 3);
        assert_ne!(key(Kind::Words, 0), key(Kind::Words, 1));
        assert_ne!(key(Kind::Words, 0), Kind::Words.key(Half::Tuning, 3));
        assert_eq!(key(Kind::Power, 0), key(Kind::Power, 1));
    }

    #[test]
    fn cells_are_what_they_are_called() {
        let of = |kind: Kind, cell: &str| Description::of(kind, cell, kind.key(Half::Tuning, 3));
        let swept = of(Kind::Memory, "0.4 swept");
        assert!((swept.memory - 0.4).abs() < 1e-15 && swept.order != Order::Shuffled);
        assert_eq!(of(Kind::Memory, "0.4 shuffled").order, Order::Shuffled);
        assert_eq!(of(Kind::Bad, "3").bad_poses, 3);
        assert_eq!(of(Kind::Stated, "3").stated, Some(3.0));
        assert!(!of(Kind::Flicker, "").columns.visit);
        assert!(Kind::all().iter().all(|kind| !kind.cells().is_empty()));
    }

    #[test]
    fn causes_of_a_kind_are_of_their_side_of_the_vocabulary() {
        for number in 0..40 {
            let inside = Description::of(Kind::Power, "30", Kind::Power.key(Half::Tuning, number));
            let outside = Description::of(Kind::Outside, "", Kind::Outside.key(Half::Tuning, number));
            assert!(inside.cause.and_then(Cause::inside) == Some(true));
            assert!(outside.cause.and_then(Cause::inside) == Some(false));
            assert!((20..=1000).contains(&outside.poses) && (2.0..=10.0).contains(&outside.size));
        }
    }
}
