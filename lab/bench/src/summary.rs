//! What was measured: medians, ratios, agreement; as lines for people and as JSON that a later run compares with.

use crate::child::Times;
use crate::peaks::Peaks;
use crate::prelude::*;
use serde::{Deserialize, Serialize};

/// Everything that one run measured.
#[derive(Debug, Deserialize, Serialize)]
pub struct Results {
    /// The processor's name.
    pub processor: String,
    /// What it can do.
    pub peaks: Peaks,
    /// Threads of our side.
    pub threads: usize,
    /// Of this program.
    pub version: String,
    /// Of the peers' language and libraries.
    pub versions: serde_json::Value,
    /// One by one.
    pub workloads: Vec<Summary>,
}

/// A peer and the share of its time that is asked for.
#[derive(Debug, Clone, Deserialize, Serialize)]
pub struct Peer {
    /// As in the peers' script.
    pub name: String,
    /// At most this share.
    pub share: f64,
}

/// One program, one way.
#[derive(Debug, Deserialize, Serialize)]
pub struct Side {
    /// The way's or the peer's.
    pub name: String,
    /// Whether it is this project's.
    pub ours: bool,
    /// What it is held against.
    pub asked: Vec<Peer>,
    /// Process CPU of a run, median of each round, s.
    pub cpu: Vec<f64>,
    /// Wall time of the same.
    pub wall: Vec<f64>,
    /// What came of it.
    pub answer: Answer,
    /// Largest resident memory, MB.
    pub peak_mb: f64,
    /// The same before any work.
    pub before_mb: f64,
}

/// One workload.
#[derive(Debug, Deserialize, Serialize)]
pub struct Summary {
    /// Its name.
    pub name: String,
    /// What it is.
    pub about: String,
    /// Operations and bytes that any way has to spend.
    pub bound: (f64, f64),
    /// The system's load when it began.
    pub load: f64,
    /// Ours and the peers.
    pub sides: Vec<Side>,
    /// Where answers differ.
    pub disagreements: Vec<String>,
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

impl Side {
    /// One of our ways.
    pub fn ours(name: &str, asked: Vec<Peer>) -> Self {
        Side { ours: true, asked, ..Side::peer(name) }
    }

    /// A peer.
    pub fn peer(name: &str) -> Self {
        Side {
            name: name.into(),
            ours: false,
            asked: Vec::new(),
            cpu: Vec::new(),
            wall: Vec::new(),
            answer: Answer::new(),
            peak_mb: 0.0,
            before_mb: 0.0,
        }
    }

    /// Takes in a round.
    pub fn add(&mut self, times: Times) {
        self.cpu.push(median(&times.cpu));
        self.wall.push(median(&times.wall));
    }
}

impl Summary {
    /// Puts a workload together and holds the answers against each other.
    pub fn of(workload: &Workload, sides: Vec<Side>, load: f64) -> Self {
        let mut disagreements = Vec::new();
        if let Some(first) = sides.iter().find(|side| !side.ours) {
            for side in sides.iter().filter(|side| side.ours) {
                for &(what, digits) in workload.agree {
                    let (have, want) = (side.answer.get(what), first.answer.get(what));
                    let (have, want) = (have.copied().unwrap_or(f64::NAN), want.copied().unwrap_or(f64::NAN));
                    if (have - want).abs() <= 10f64.powi(-digits) * want.abs() {
                        continue;
                    }
                    let (ours, theirs, name) = (&side.name, &first.name, workload.name);
                    disagreements.push(format!("{name} {what}: {ours} {have:e}, {theirs} {want:e}"));
                }
            }
        }
        Summary {
            name: workload.name.into(),
            about: workload.about.into(),
            bound: workload.bound.into(),
            load,
            sides,
            disagreements,
        }
    }

    /// For people.
    pub fn lines(&self, machine: Peaks, earlier: Option<&Results>) -> Vec<String> {
        let least = (self.bound.0 / machine.flops).max(self.bound.1 / machine.bytes);
        let mut lines =
            vec![format!("{}: {}; bound {}, load {:.2}", self.name, self.about, time(least), self.load)];
        let known = earlier.and_then(|r| r.workloads.iter().find(|w| w.name == self.name));
        for side in &self.sides {
            let cpu = median(&side.cpu);
            let mut line = format!(
                "  {:<4} {:<14} cpu {:>9}  wall {:>9}  {:>5.0} MB (+{:.0})  {:>3.0} % of the bound",
                if side.ours { "ours" } else { "peer" },
                side.name,
                time(cpu),
                time(median(&side.wall)),
                side.peak_mb,
                side.peak_mb - side.before_mb,
                100.0 * least / cpu,
            );
            for asked in &side.asked {
                if let Some(peer) = self.sides.iter().find(|s| !s.ours && s.name == asked.name) {
                    let ratio = cpu / median(&peer.cpu);
                    let verdict = if ratio <= asked.share { "met" } else { "MISSED" };
                    line += &format!("  {ratio:.2} × {} (≤ {}: {verdict})", asked.name, asked.share);
                }
            }
            let before =
                known.and_then(|w| w.sides.iter().find(|s| s.name == side.name && s.ours == side.ours));
            if let Some(before) = before {
                line += &format!("  {:.2} × the earlier run", cpu / median(&before.cpu));
            }
            lines.push(line);
            let answer: Vec<String> = side.answer.iter().map(|(what, v)| format!("{what} {v:.12}")).collect();
            lines.push(format!("         {}", answer.join("  ")));
        }
        lines.extend(self.disagreements.iter().map(|d| format!("  NOT THE SAME: {d}")));
        lines
    }
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.1} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.2} ms", 1e3 * s),
        s => format!("{s:.3} s"),
    }
}

impl Results {
    /// Nothing yet.
    pub fn new(peaks: Peaks, processor: String, threads: usize) -> Self {
        Results {
            processor,
            peaks,
            threads,
            version: env!("CARGO_PKG_VERSION").into(),
            versions: serde_json::Value::Null,
            workloads: Vec::new(),
        }
    }

    /// Those of an earlier run.
    pub fn read(path: &Path) -> Outcome<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(serde_json::from_str(&text)?)
    }

    /// Keeps them for a later run.
    pub fn write(&self, path: &Path) -> Outcome {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        Ok(std::fs::write(path, serde_json::to_string_pretty(self)?)?)
    }
}
