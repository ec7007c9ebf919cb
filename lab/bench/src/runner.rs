//! Runs workloads: ours and the peers' in turn, round after round, and says how they compare.

use crate::arguments::Arguments;
use crate::child::{Checked, Process, Times};
use crate::prelude::*;
use crate::summary::{Peer, Results, Side, Summary};
use crate::{peaks, workloads};
use std::process::Command;

/// One run of a side should take this long, s: shorter work is done several times over.
const LEAST: f64 = 0.05;

/// Runs what was asked for.
pub fn run(arguments: &Arguments) -> Outcome {
    let with_peers = ready(arguments)?;
    let machine = peaks::measure();
    let processor = clock::processor();
    say(&format!(
        "{processor}, {:.0} GFLOP/s and {:.1} GB/s on one thread, load {:.2}",
        1e-9 * machine.flops,
        1e-9 * machine.bytes,
        clock::load()
    ));
    let earlier = arguments.against.as_deref().map(Results::read).transpose()?;
    let mut results = Results::new(machine, processor, arguments.threads);
    for workload in workloads::ALL.iter().filter(|w| arguments.wants(w.name)) {
        let summary = one(workload, arguments, with_peers, &mut results.versions)?;
        for line in summary.lines(machine, earlier.as_ref()) {
            say(&line);
        }
        results.workloads.push(summary);
        results.write(&arguments.out)?;
    }
    say(&format!("written to {}", arguments.out.display()));
    match results.workloads.iter().flat_map(|w| &w.disagreements).next() {
        Some(first) => Err(format!("not the same work: {first}").into()),
        None => Ok(()),
    }
}

/// Makes the peers' data where it is missing; whether peers can run.
fn ready(arguments: &Arguments) -> Outcome<bool> {
    let script = arguments.peers.join("gen_workloads.py");
    let able = script.exists() && arguments.python.exists();
    if !able {
        let (peers, python) = (arguments.peers.display(), arguments.python.display());
        say(&format!("no peers ({peers}, {python}): ours alone, CONTRIBUTING.md says how to have them"));
    }
    if !arguments.data.join("w6.csv").exists() {
        if !able {
            return Err("there is no data: the peers' script makes it".into());
        }
        std::fs::create_dir_all(&arguments.data)?;
        say("making the data");
        let made = Command::new(&arguments.python).arg(script).arg(&arguments.data).status()?;
        if !made.success() {
            return Err("the peers' script did not make the data".into());
        }
    }
    Ok(able)
}

fn peer(arguments: &Arguments, workload: &str, peer: &str) -> Outcome<Process> {
    // Their BLAS does not know newer processors and takes kernels without AVX-512 there: peers/README.md.
    let wide = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default().contains("avx512");
    let core = if wide { "Cooperlake" } else { "" };
    Process::start(
        Command::new(&arguments.python)
            .args(["-c", concat!(include_str!("jacobian_peers.py"), "\n", include_str!("peer.py"))])
            .arg(&arguments.peers)
            .arg(&arguments.data)
            .args([workload, peer, core]),
    )
}

fn ours(arguments: &Arguments, workload: &str, way: &str) -> Outcome<Process> {
    Process::start(
        Command::new(std::env::current_exe()?)
            .args(["--serve", workload, way, "--threads"])
            .arg(arguments.threads.to_string())
            .env("TRUEPOSE_PEERS_DATA", &arguments.data),
    )
}

fn one(
    workload: &Workload,
    arguments: &Arguments,
    with_peers: bool,
    versions: &mut serde_json::Value,
) -> Outcome<Summary> {
    let mut sides: Vec<(Side, Process)> = Vec::new();
    for way in workload.ways {
        let asked =
            way.asked.iter().map(|(peer, share)| Peer { name: (*peer).into(), share: *share }).collect();
        let process = ours(arguments, workload.name, way.name)?;
        sides.push((Side::ours(way.name, asked), process));
    }
    let mut names: Vec<&str> = workload.ways.iter().flat_map(|w| w.asked).map(|(name, _)| *name).collect();
    names.sort_unstable();
    names.dedup();
    for name in names.into_iter().filter(|_| with_peers) {
        let process = peer(arguments, workload.name, name)?;
        *versions = process.ready["versions"].clone();
        sides.push((Side::peer(name), process));
    }
    // The first run warms up and says how many make a round.
    let mut repeats = Vec::new();
    for (_, process) in &mut sides {
        process.run(1)?;
        let Times { wall, .. } = process.run(1)?;
        let once = wall.first().copied().unwrap_or(LEAST).max(1e-6);
        repeats.push(((LEAST / once).ceil() as usize).clamp(1, 200));
    }
    let load = clock::load();
    for _ in 0..arguments.rounds {
        for ((side, process), &repeats) in sides.iter_mut().zip(&repeats) {
            side.add(process.run(repeats)?);
        }
    }
    let mut done = Vec::new();
    for (mut side, mut process) in sides {
        let Checked { answer, peak_mb, before_mb } = process.check()?;
        (side.answer, side.peak_mb, side.before_mb) = (answer, peak_mb, before_mb);
        done.push(side);
    }
    Ok(Summary::of(workload, done, load))
}
