//! What to measure next as a CSV file, in the columns of measurements: the file of `truepose plan`.

use crate::commanded::{commanded, commanded_names};
use crate::poses::{controller_values, si_unit};
use crate::table::TableWriter;
use crate::{IoError, Unit};
use std::path::Path;
use truepose_kinematics::{Chain, Load};

/// One visit to make.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedVisit {
    /// Variables of the movable joints, rad or m; written as the controller's values.
    pub joints: Vec<f64>,
    /// What is carried.
    pub load: Load,
    /// From which side each joint arrives, −1, 0, +1.
    pub approach: Vec<f64>,
    /// `new` or `repeat`.
    pub why: &'static str,
    /// What it adds.
    pub worth: f64,
    /// What is touched or read there, a line each; empty where positions are measured.
    pub observed: Vec<PlannedRow>,
}

/// What is observed in a visit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedRow {
    /// The word of the column `kind`.
    pub kind: &'static str,
    /// The landmark or sensor.
    pub landmark: String,
    /// The target; empty where it is the tool's origin.
    pub target: String,
}

/// Writes a plan, in m, rad and kg, or joints in these units, one for each that moves.
///
/// # Errors
/// When the file cannot be written.
pub fn write_plan(
    path: impl AsRef<Path>,
    chain: &Chain,
    visits: &[PlannedVisit],
    units: Option<&[Unit]>,
) -> Result<(), IoError> {
    let si: Vec<Unit> = chain.movable().iter().map(|&joint| *si_unit(chain.joint(joint).kind)).collect();
    let units = units.filter(|units| units.len() == si.len()).unwrap_or(&si);
    let own = commanded(chain);
    let names = commanded_names(chain);
    let mut header = vec!["visit".to_owned()];
    let observed = visits.iter().any(|visit| !visit.observed.is_empty());
    if observed {
        header.extend(["kind", "landmark", "target"].map(String::from));
    }
    header.extend(
        names
            .iter()
            .zip(&own)
            .map(|(name, &k)| (name, &units[k]))
            .map(|(name, unit)| format!("{name}[{}]", unit.word)),
    );
    let loaded = visits.iter().any(|visit| visit.load != Load::None);
    if loaded {
        header.extend(["payload[kg]", "cx[m]", "cy[m]", "cz[m]"].map(String::from));
    }
    header.extend(names.iter().map(|name| format!("approach_{name}")));
    header.extend(["why", "worth"].map(String::from));
    let mut table = TableWriter::create(path.as_ref(), &header)?;
    for (number, visit) in (1..).zip(visits) {
        let values = controller_values(chain, &visit.joints);
        for row in 0..visit.observed.len().max(1) {
            table.integer(number);
            if observed {
                let row = visit.observed.get(row);
                let cells = row.map_or(["", "", ""], |row| [row.kind, &row.landmark, &row.target]);
                cells.iter().for_each(|cell| table.text(cell));
            }
            own.iter().for_each(|&k| table.number(units[k].from_si(values[k])));
            if loaded {
                let (mass, com) = match visit.load {
                    Load::Payload(payload) => (payload.mass, payload.com.into()),
                    _ => (0.0, [0.0; 3]),
                };
                table.number(mass);
                com.iter().for_each(|&c| table.number(c));
            }
            own.iter().for_each(|&k| table.integer(visit.approach[k] as i64));
            table.text(visit.why);
            table.number(visit.worth);
            table.end_row()?;
        }
    }
    table.finish()
}
