//! `truepose dwell`: the dwells in a log as measurements.

use super::{print_json, robot};
use crate::args::DwellOf;
use crate::failure::Failure;
use crate::terminal;
use truepose_errormodel::{DwellOptions, Segmented};
use truepose_io::{
    ExportUnits, MeasurementsOptions, Unit, check_writable, read_measurements, robot_columns,
    write_measurements,
};
use truepose_kinematics::{Chain, JointKind};
use truepose_report::{count, significant};

/// Correlation of the speeds below which a lag is not to be trusted.
const TRUSTED: f64 = 0.5;

/// Runs the verb.
pub fn run(args: &DwellOf) -> Result<(), Failure> {
    check_writable(&args.out)?;
    let file = args.log.display();
    let chain = robot(&args.robot)?;
    let columns = robot_columns(&args.robot.robot)?.with(&args.named.map());
    // Every row counts: one that repeats an earlier one is a sample of the same dwell.
    let options = MeasurementsOptions { columns, measured_required: false, ..MeasurementsOptions::default() };
    let (data, info, _) = read_measurements(&args.log, &chain, &options)?;
    let about = |words: &str| Failure::Input(format!("{file}: {words}"));
    if !data.schema.time {
        return Err(about("a log needs the time of each row: a column `time[s]`"));
    }
    if !info.landmarks.is_empty() || !info.sessions.is_empty() {
        return Err(about("rows at landmarks and of several sessions are measurements already, and no log"));
    }
    let options = options_of(args);
    let found = data.standstills(&slides(&chain), &options);
    if found.data.is_empty() {
        return Err(about(&format!(
            "no dwell of {} s or longer with a measured position in it: lower --dwell, raise --still, or state --lag",
            significant(options.dwell, 3)
        )));
    }
    let unit = |word| Unit::named(word).copied().ok_or_else(|| Failure::Input(format!("no unit `{word}`")));
    let units = ExportUnits { length: unit("mm")?, angle: unit("deg")? };
    write_measurements(&args.out, &chain, &found.data, &units)?;
    if args.json {
        return print_json(&json(&found));
    }
    terminal::print(&text(args, &found, data.len()));
    Ok(())
}

fn options_of(args: &DwellOf) -> DwellOptions {
    let usual = DwellOptions::default();
    DwellOptions {
        still: args.still.map_or(usual.still, |still| [still.angle, still.length.unwrap_or(usual.still[1])]),
        dwell: args.dwell.as_secs_f64(),
        settle: args.settle.max(0.0),
        lag: args.lag,
    }
}

/// Which joints are prismatic.
fn slides(chain: &Chain) -> Vec<bool> {
    chain.movable().iter().map(|&joint| chain.joint(joint).kind == JointKind::Prismatic).collect()
}

fn text(args: &DwellOf, found: &Segmented, rows: usize) -> String {
    let visits = found.data.visit.iter().max().map_or(0, |last| last + 1);
    let samples: usize = found.samples.iter().sum();
    let milliseconds = |lag: f64| format!("{} ms", significant(1e3 * lag, 3));
    let correlated = format!("speeds correlate by {}", significant(found.found.1, 2));
    let lag = match (args.lag, found.found.1 >= TRUSTED) {
        (Some(lag), _) => format!("the instrument is late by {}, as stated", milliseconds(lag)),
        (None, true) => {
            format!("the instrument is late by {} against the joints ({correlated})", milliseconds(found.lag))
        }
        (None, false) => format!(
            "the lag between the clocks of joints and instrument is unknown ({correlated}) and taken as 0; state it with --lag"
        ),
    };
    let unseen = match found.unseen {
        0 => String::new(),
        n => format!("{} without a measured position\n", count(n, "dwell")),
    };
    format!(
        "{} in {}: {} from {} measured while the robot stood still\n{unseen}{lag}\nwritten to {}\n",
        count(visits, "dwell"),
        count(rows, "row"),
        count(found.data.len(), "measurement"),
        count(samples, "row"),
        args.out.display()
    )
}

fn json(found: &Segmented) -> serde_json::Value {
    serde_json::json!({
        "dwells": found.data.visit.iter().max().map_or(0, |last| last + 1),
        "rows": found.data.len(),
        "samples": found.samples,
        "without_position": found.unseen,
        "lag_s": found.lag,
        "lag_found_s": found.found.0,
        "correlation": found.found.1,
    })
}
