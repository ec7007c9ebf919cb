//! Derived channels that follow the history of a record late: what a joint has carried, how it has worked, whether the robot was at work.
//!
//! ```text
//! τ dH/dt = u − H        from one pose to the next, h later:  H ← u + (H − u) exp(−h/τ)
//! ```
//!
//! | channel | u between two poses | H at the first pose | unit |
//! | --- | --- | --- | --- |
//! | `tau_3~lag=600` | load about or along joint 3 at the pose before | that load: it has carried it for long | N·m or N |
//! | `work_3~lag=600` | size of load times move, over h: power of the drive | 0: cold | W |
//! | `travel_3~lag=600` | size of the move over h | 0 | rad/s or m/s |
//! | `working_300~lag=600` | 1, and 0 in a pause: an interval of more than 300 s | 0 | 1 |
//!
//! 3 is the joint's number in the robot (from 1, fixed joints count), 600 the time constant in s. Loads are those of the nominal posture. A
//! controller makes a channel with [`follow`], move by move. Sources: lumped heat capacity (Incropera and DeWitt, chapter 5); Zener's
//! anelastic solid for creep (Findley, Lai and Onaran, *Creep and Relaxation of Nonlinear Viscoelastic Materials*, chapter 3).

use super::late::LATE;
use super::table::Dataset;
use truepose_kinematics::{Chain, JointId};

/// What is followed late.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum History {
    /// The load about (N·m) or along (N) a joint.
    Load(JointId),
    /// The mechanical power of a joint's drive, W.
    Work(JointId),
    /// The speed of a joint between poses, rad/s or m/s.
    Travel(JointId),
    /// Whether the robot is at work; an interval of more than so many seconds is a pause.
    Working(f64),
}

impl History {
    /// Its name without a time constant: `work_3`.
    pub fn source(&self) -> String {
        match self {
            History::Load(joint) => format!("tau_{}", joint.0),
            History::Work(joint) => format!("work_{}", joint.0),
            History::Travel(joint) => format!("travel_{}", joint.0),
            History::Working(pause) => format!("working_{pause}"),
        }
    }

    /// What a source of this name is.
    pub fn of_source(source: &str) -> Option<Self> {
        let (word, number) = source.split_once('_')?;
        if word == "working" {
            let pause = number.parse().ok().filter(|pause: &f64| pause.is_finite() && *pause > 0.0)?;
            return Some(History::Working(pause));
        }
        let of = match word {
            "tau" => History::Load,
            "work" => History::Work,
            "travel" => History::Travel,
            _ => return None,
        };
        Some(of(JointId(number.parse().ok().filter(|&number| number > 0)?)))
    }

    /// The unit of the channel.
    pub fn unit(&self, chain: &Chain) -> &'static str {
        let of = |joint: &JointId, turns, slides| {
            let known = joint.0 <= chain.joints().len();
            if known && chain.joint(*joint).unit() == "m" { slides } else { turns }
        };
        match self {
            History::Load(joint) => of(joint, "N*m", "N"),
            History::Work(_) => "W",
            History::Travel(joint) => of(joint, "rad/s", "m/s"),
            History::Working(_) => "1",
        }
    }
}

/// The name of the channel that follows a history with this time constant, s.
pub fn history_channel(history: History, lag: f64) -> String {
    format!("{}{LATE}{lag}", history.source())
}

/// History and time constant (s) of a channel of this name; none of other channels.
pub fn history_of(channel: &str) -> Option<(History, f64)> {
    let (source, lag) = channel.rsplit_once(LATE)?;
    let lag = lag.parse().ok().filter(|lag: &f64| lag.is_finite() && *lag > 0.0)?;
    Some((History::of_source(source)?, lag))
}

/// The state of a history after `h` seconds towards `u`, from `state`, with the time constant `lag` (s).
pub fn follow(state: f64, u: f64, h: f64, lag: f64) -> f64 {
    u + (state - u) * (-h / lag).exp()
}

impl Dataset {
    /// A history at every row, with this time constant, s. `chain` is the robot, whose loads are those of its nominal postures; none for a joint
    /// that does not move.
    pub fn history(&self, history: History, lag: f64, chain: &Chain) -> Option<Vec<f64>> {
        let whole = self.whole();
        let joint = match history {
            History::Load(joint) | History::Work(joint) | History::Travel(joint) => Some(joint),
            History::Working(_) => None,
        };
        let moves = match joint {
            Some(joint) => whole.moves(chain.coordinate(joint)?),
            None => Vec::new(),
        };
        let loads = match history {
            History::Load(joint) | History::Work(joint) => whole.loads(joint, chain),
            History::Travel(_) | History::Working(_) => Vec::new(),
        };
        let towards = |k: usize, h: f64| match history {
            History::Load(_) => loads[k],
            // Half of the move under either load.
            History::Work(_) => 0.5 * (loads[k].abs() + loads[k + 1].abs()) * moves[k].abs() / h,
            History::Travel(_) => moves[k].abs() / h,
            History::Working(pause) => f64::from(h <= pause),
        };
        let first = if matches!(history, History::Load(_)) { loads.first().copied() } else { None };
        Some(whole.follow_time(first.unwrap_or(0.0), |state, k, h| follow(state, towards(k, h), h, lag)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Conditions, Load, Payload, PostureBuffer, samples};

    fn record(chain: &Chain) -> Dataset {
        let time = vec![0.0, 60.0, 100.0, 1000.0, 1040.0];
        let n = time.len();
        let joints: Vec<Vec<f64>> = (0..chain.movable().len())
            .map(|j| (0..n).map(|k| 0.3 + (0.7 * ((k * (j + 2)) as f64)).sin()).collect())
            .collect();
        let mass = |k: usize| Load::Payload(Payload { mass: [0.0, 8.0][k % 2], com: [0.1, 0.0, 0.0].into() });
        let mut data = Dataset {
            approach: vec![vec![0.0; n]; joints.len()],
            joints,
            visit: (0..n).collect(),
            time,
            position: vec![[0.0; 3]; n],
            orientation: vec![None; n],
            position_sd: vec![[f64::NAN; 3]; n],
            orientation_sd: vec![[f64::NAN; 3]; n],
            target: vec![None; n],
            load: (0..n).map(mass).collect(),
            ..Dataset::default()
        };
        data.schema.time = true;
        data
    }

    #[test]
    fn it_is_the_differential_equation() {
        let chain = samples::ur10();
        let data = record(&chain);
        let joint = JointId(2);
        let mut buffer = PostureBuffer::new(&chain);
        let loads: Vec<f64> = (0..data.len())
            .map(|row| {
                let q: Vec<f64> = data.joints.iter().map(|column| column[row]).collect();
                let at = Conditions::at(&chain, &q).with_load(data.load[row]);
                buffer.update(&chain, &at).joint_load(joint)
            })
            .collect();
        let (q, t, lag) = (&data.joints[1], &data.time, 200.0);
        let power = |k: usize| 0.5 * (loads[k].abs() + loads[k + 1].abs()) * (q[k + 1] - q[k]).abs();
        type Drive<'a> = &'a dyn Fn(usize) -> f64;
        let cases: [(History, f64, Drive<'_>); 4] = [
            (History::Load(joint), loads[0], &|k| loads[k]),
            (History::Work(joint), 0.0, &|k| power(k) / (t[k + 1] - t[k])),
            (History::Travel(joint), 0.0, &|k| (q[k + 1] - q[k]).abs() / (t[k + 1] - t[k])),
            (History::Working(300.0), 0.0, &|k| if k == 2 { 0.0 } else { 1.0 }),
        ];
        for (history, first, u) in cases {
            let found = data.history(history, lag, &chain).unwrap();
            let mut state = first;
            for k in 0..data.len() {
                assert!((found[k] - state).abs() < 1e-6 * (1.0 + state.abs()), "{history:?} at {k}");
                if k + 1 < data.len() {
                    // Small steps of the equation, without its solution.
                    let count = 200_000;
                    let step = (t[k + 1] - t[k]) / f64::from(count);
                    (0..count).for_each(|_| state += step * (u(k) - state) / lag);
                }
            }
            // A part of the rows remembers what was between them.
            let part = data.select(&[4, 1]).history(history, lag, &chain).unwrap();
            assert_eq!(part, [found[4], found[1]]);
        }
        assert!(!samples::skewed().joint(JointId(2)).moves());
        assert!(
            record(&samples::skewed())
                .history(History::Travel(JointId(2)), 1.0, &samples::skewed())
                .is_none()
        );
    }

    #[test]
    fn names_read_back() {
        for (history, name) in [
            (History::Load(JointId(3)), "tau_3~lag=600"),
            (History::Work(JointId(3)), "work_3~lag=600"),
            (History::Travel(JointId(12)), "travel_12~lag=600"),
            (History::Working(300.0), "working_300~lag=600"),
        ] {
            assert_eq!(history_channel(history, 600.0), name);
            assert_eq!(history_of(name), Some((history, 600.0)));
        }
        for other in [
            "work_3",
            "work_0~lag=60",
            "works_3~lag=60",
            "temperature~lag=600",
            "working_0~lag=6",
            "tau_3~lag=-1",
        ] {
            assert_eq!(history_of(other), None, "{other}");
        }
    }
}
