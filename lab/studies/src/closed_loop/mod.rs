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

use crate::prelude::*;
pub mod robots;
mod trial;

use trial::{Counts, Request, Trial};

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
pub fn run(arguments: &[String]) -> Outcome {
    let Options { only, visits, driven } = parsed(arguments)?;
    let folder = folder("closed-loop")?;
    let mut executions = Table::columns(
        "robot -8|plant 6|ok 9|before mm 10|after µm 9|max µm 9|repeat µm 8|× before 8|× after 8|in band 9",
    );
    let mut trips = Table::columns(
        "robot -8|asked 10|ok 7|limit 8|unreachable 12|not conv. 8|beyond limits 14|m 9|rad 9|µs each 8",
    );
    let mut all = Fraction::of([]);
    for robot in robots::all()?.into_iter().filter(|robot| robot.name.contains(&only)) {
        for plant in 0..PLANTS {
            let trial = Trial::new(&robot, 40 + 10 * plant, visits.unwrap_or(robot.visits))?;
            let d = trial.execute()?;
            let (name, band) = (&robot.name, Fraction { hits: d.within, of: d.rows });
            let micro = [d.after, d.after_max, d.repeatability].map(|v| fixed(1e6 * v, 1));
            let head = [name.clone(), plant.to_string(), part_of(d.ok, d.of), fixed(1e3 * d.before, 3)];
            let per_cent = format!("{:.1} %", band.percent());
            let tail = [fixed(d.ratio_before(), 1), fixed(d.ratio(), 3), per_cent];
            executions.cells(&[&head[..], &micro, &tail].concat());
            print(executions.last());
            if d.ratio() > robot.within {
                print(&format!("{name}: more than {} times its repeatability", robot.within));
            }
            all = Fraction { hits: all.hits + band.hits, of: all.of + band.of };
            if plant > 0 || driven {
                continue;
            }
            for (request, words, poses, seeded) in [
                (Request::Reachable, "seeded", POSES, true),
                (Request::Reachable, "no seed", POSES / 10, false),
                (Request::BeyondLimits, "limits", POSES / 100, true),
                (Request::Far, "far", POSES / 100, true),
            ] {
                let begun = Instant::now();
                let c = trial.round_trip(request, poses, seeded)?;
                let seconds = begun.elapsed().as_secs_f64();
                let Counts { ok, unreachable, limit, not_converged, position, orientation, beyond } = c;
                let head = [name.clone(), words.into()];
                let counts = [ok, limit, unreachable, not_converged, beyond].map(|count| count.to_string());
                let each = fixed(1e6 * seconds / c.all() as f64, 1);
                let tail = [format!("{position:.1e}"), format!("{orientation:.1e}"), each];
                trips.cells(&[&head[..], &counts, &tail].concat());
                print(trips.last());
            }
        }
    }
    let (executions, per_cent) = (executions.text(), all.percent());
    let text = format!("{executions}in band, all: {per_cent:.2} % of {} rows\n\n{}", all.of, trips.text());
    finish("closed-loop", &folder.join("table.txt"), &text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A short form of the study: fewer visits and poses, the same demands but for what fewer measurements leave open.
    #[test]
    fn plants_end_where_they_should() {
        let (mut rows, mut within) = (0, 0);
        for robot in robots::all().expect("robots") {
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
            for (request, seeded) in
                [(Request::Reachable, true), (Request::BeyondLimits, true), (Request::Far, false)]
            {
                let c = trial.round_trip(request, 200, seeded).expect("round trips");
                assert_eq!((c.all(), c.beyond), (200, 0));
                assert!(c.position < 1e-9 && c.orientation < 1e-9, "{} {c:?}", robot.name);
                match request {
                    Request::Reachable => assert!(c.ok >= 199, "{} {c:?}", robot.name),
                    Request::Far => assert_eq!(c.ok, 0, "{} {c:?}", robot.name),
                    // Turns of more than a turn reach everything from within.
                    Request::BeyondLimits => assert!(c.limit > 2 || c.ok == 200, "{} {c:?}", robot.name),
                }
            }
        }
        let share = within as f64 / rows as f64;
        assert!((0.93..=0.97).contains(&share), "{share} of {rows} rows within their bands");
    }
}
