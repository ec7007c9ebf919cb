//! Closed-loop verification: the plants are identified, then execute compensated commands. How accurate are they?
//!
//! | figure | of |
//! | --- | --- |
//! | before, after | the true plant against the desired position, RMS over visits that took no part, without what differs each time |
//! | × repeatability | the same together with what differs each time, over that alone |
//! | in band | measured rows of those visits that lie within their 95 % band |
//! | round trip | the model's own prediction at the command against the desired pose |
//!
//! `--only ROBOT` takes one kind alone, `--visits N` so many configurations, `--driven` leaves the round trips out.

pub mod robots;
mod trial;

pub use robots::Robot;

use crate::results::finish;
use crate::{asked, folder, print};
use clap::Parser;
use std::error::Error;
use std::fmt::Write;
use std::time::Instant;
use trial::{Asked, Counts, Executed, Trial};

/// Plants of each kind, and poses of each round trip.
const PLANTS: u64 = 3;
const POSES: usize = 100_000;

/// The options of the run.
#[derive(Parser)]
struct Options {
    /// One kind of robot.
    #[arg(long, default_value = "")]
    only: String,
    /// So many configurations.
    #[arg(long)]
    visits: Option<usize>,
    /// No round trips.
    #[arg(long)]
    driven: bool,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let Options { only, visits, driven } = asked(arguments)?;
    let folder = folder("closed-loop")?;
    let (mut executions, mut trips) = (String::new(), String::new());
    let (mut execution_csv, mut trip_csv) = (
        String::from(
            "robot,plant,visits,ok,before_mm,after_mm,after_max_mm,repeatability_mm,ratio_before,ratio,rows,in_band\n",
        ),
        String::from(
            "robot,asked,seeded,poses,ok,unreachable,limit,not_converged,position_m,orientation_rad,seconds\n",
        ),
    );
    writeln!(
        executions,
        "{:8} {:>6} {:>9} {:>10} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8}",
        "robot",
        "plant",
        "ok",
        "before mm",
        "after µm",
        "max µm",
        "repeat µm",
        "× before",
        "× after",
        "in band"
    )?;
    writeln!(
        trips,
        "{:8} {:>10} {:>7} {:>8} {:>12} {:>8} {:>14} {:>9} {:>9} {:>8}",
        "robot", "asked", "ok", "limit", "unreachable", "not conv.", "beyond limits", "m", "rad", "µs each"
    )?;
    let (mut rows, mut within) = (0, 0);
    for robot in robots::all().into_iter().filter(|robot| robot.name.contains(&only)) {
        for plant in 0..PLANTS {
            let trial = Trial::new(&robot, 40 + 10 * plant, visits.unwrap_or(robot.visits))?;
            let d = trial.execute()?;
            execution_line(&mut executions, &mut execution_csv, robot.name, plant, &d)?;
            print(executions.lines().last().unwrap_or_default());
            if d.ratio() > robot.within {
                print(&format!("{}: more than {} times its repeatability", robot.name, robot.within));
            }
            rows += d.rows;
            within += d.within;
            if plant > 0 || driven {
                continue;
            }
            for (asked, words, poses, seeded) in [
                (Asked::Reachable, "seeded", POSES, true),
                (Asked::Reachable, "no seed", POSES / 10, false),
                (Asked::BeyondLimits, "limits", POSES / 100, true),
                (Asked::Far, "far", POSES / 100, true),
            ] {
                let begun = Instant::now();
                let counts = trial.round_trip(asked, poses, seeded)?;
                let seconds = begun.elapsed().as_secs_f64();
                trip_line(&mut trips, &mut trip_csv, (robot.name, words, seeded), &counts, seconds)?;
                print(trips.lines().last().unwrap_or_default());
            }
        }
    }
    writeln!(executions, "in band, all: {:.2} % of {rows} rows", 100.0 * within as f64 / rows as f64)?;
    let text = format!("{executions}\n{trips}");
    std::fs::write(folder.join("execution.csv"), execution_csv)?;
    std::fs::write(folder.join("round_trip.csv"), trip_csv)?;
    finish("closed-loop", &folder.join("table.txt"), &text)
}

fn execution_line(
    text: &mut String,
    csv: &mut String,
    robot: &str,
    plant: u64,
    d: &Executed,
) -> std::fmt::Result {
    let band = d.within as f64 / d.rows as f64;
    writeln!(
        text,
        "{robot:8} {plant:>6} {:>9} {:>10.3} {:>9.1} {:>9.1} {:>8.1} {:>8.1} {:>8.3} {:>7.1} %",
        format!("{}/{}", d.ok, d.of),
        1e3 * d.before,
        1e6 * d.after,
        1e6 * d.after_max,
        1e6 * d.repeatability,
        d.ratio_before(),
        d.ratio(),
        100.0 * band
    )?;
    writeln!(
        csv,
        "{robot},{plant},{},{},{},{},{},{},{},{},{},{band}",
        d.of,
        d.ok,
        1e3 * d.before,
        1e3 * d.after,
        1e3 * d.after_max,
        1e3 * d.repeatability,
        d.ratio_before(),
        d.ratio(),
        d.rows
    )
}

fn trip_line(
    text: &mut String,
    csv: &mut String,
    (robot, asked, seeded): (&str, &str, bool),
    c: &Counts,
    seconds: f64,
) -> std::fmt::Result {
    writeln!(
        text,
        "{robot:8} {asked:>10} {:>7} {:>8} {:>12} {:>8} {:>14} {:>9.1e} {:>9.1e} {:>8.1}",
        c.ok,
        c.limit,
        c.unreachable,
        c.not_converged,
        c.beyond,
        c.position,
        c.orientation,
        1e6 * seconds / c.all() as f64
    )?;
    writeln!(
        csv,
        "{robot},{asked},{seeded},{},{},{},{},{},{:e},{:e},{seconds}",
        c.all(),
        c.ok,
        c.unreachable,
        c.limit,
        c.not_converged,
        c.position,
        c.orientation
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A short form of the study: fewer visits and poses, the same demands but for what fewer measurements leave open.
    #[test]
    fn plants_end_where_they_should() {
        let (mut rows, mut within) = (0, 0);
        for robot in robots::all() {
            let trial = Trial::new(&robot, 40, robot.visits.min(1200)).expect("a trial");
            let d = trial.execute().expect("an execution");
            assert!(d.ok * 10 >= d.of * 8, "{}: {} of {}", robot.name, d.ok, d.of);
            assert!(
                d.ratio() < robot.within && d.ratio_before() > 5.0,
                "{}: {} {}",
                robot.name,
                d.ratio_before(),
                d.ratio()
            );
            (rows, within) = (rows + d.rows, within + d.within);
            for (asked, seeded) in
                [(Asked::Reachable, true), (Asked::BeyondLimits, true), (Asked::Far, false)]
            {
                let c = trial.round_trip(asked, 200, seeded).expect("round trips");
                assert_eq!((c.all(), c.beyond), (200, 0));
                assert!(c.position < 1e-9 && c.orientation < 1e-9, "{} {c:?}", robot.name);
                match asked {
                    Asked::Reachable => assert!(c.ok >= 199, "{} {c:?}", robot.name),
                    Asked::Far => assert_eq!(c.ok, 0, "{} {c:?}", robot.name),
                    // Turns of more than a turn reach everything from within.
                    Asked::BeyondLimits => assert!(c.limit > 2 || c.ok == 200, "{} {c:?}", robot.name),
                }
            }
        }
        let share = within as f64 / rows as f64;
        assert!((0.93..=0.97).contains(&share), "{share} of {rows} rows within their bands");
    }
}
