//! One line a robot.

use crate::journal::Line;

/// What is measured; RMS in mm unless the name has another unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Nominal robot after best base, tool and targets.
    Nominal,
    /// Constants only: `identify`.
    Constants,
    /// The same from the record as it would be without what went wrong; not judged.
    Clean,
    Tukey,
    Huber,
    Ridge,
    Discover,
    /// The exported geometry after best base, tool and targets.
    Export,
    /// The exported geometry as it is written.
    Written,
    /// The plant, executing nominal inverse kinematics after best base, tool and targets.
    DriveNominal,
    DriveConstants,
    DriveDiscover,
    /// How many of the fresh configurations could be executed.
    Executed,
    /// Nested folds of `discover`: the declared model, and what was found.
    NestedBefore,
    NestedAfter,
    /// Seconds on the wall, and of the processors.
    SecondsIdentify,
    SecondsDiscover,
    Processors,
    SecondsNested,
}

pub const FIGURES: [Figure; 19] = [
    Figure::Nominal,
    Figure::Constants,
    Figure::Clean,
    Figure::Tukey,
    Figure::Huber,
    Figure::Ridge,
    Figure::Discover,
    Figure::Export,
    Figure::Written,
    Figure::DriveNominal,
    Figure::DriveConstants,
    Figure::DriveDiscover,
    Figure::Executed,
    Figure::NestedBefore,
    Figure::NestedAfter,
    Figure::SecondsIdentify,
    Figure::SecondsDiscover,
    Figure::Processors,
    Figure::SecondsNested,
];

/// What became of one robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    pub number: u64,
    pub seed: u64,
    pub make: String,
    pub hidden: String,
    pub style: String,
    pub spoil: String,
    pub poses: usize,
    pub rows: usize,
    pub targets: usize,
    /// `base`, `tool`, `targets`, as far as they were unknown; `turns` where orientations were measured.
    pub given: String,
    pub noise_mm: f64,
    /// NaN where it was not requested, or rejected.
    pub figures: [f64; FIGURES.len()],
    /// What was found.
    pub finds: String,
    /// `verb: why`, of verbs that gave no answer; a panic begins with the word.
    pub refused: Vec<String>,
}

impl Record {
    pub fn get(&self, figure: Figure) -> f64 {
        self.figures[figure as usize]
    }

    pub fn set(&mut self, figure: Figure, value: f64) {
        self.figures[figure as usize] = value;
    }

    /// Notes that a verb gave no answer.
    pub fn refuse(&mut self, verb: &str, why: &str) {
        self.refused.push(format!("{verb}: {}", why.replace([',', '\n', ';', '"'], " ")));
    }
}

impl Line for Record {
    const HEADER: &'static str = "number,seed,make,hidden,style,spoil,poses,rows,targets,given,noise_mm,\
        nominal,constants,clean,tukey,huber,ridge,discover,export,export_written,drive_nominal,drive_constants,drive_discover,driven,\
        nested_before,nested_after,s_identify,s_discover,processor_s,s_nested,finds,refused";

    fn row(&self) -> String {
        let mut cells = vec![
            self.number.to_string(),
            self.seed.to_string(),
            self.make.clone(),
            self.hidden.clone(),
            self.style.clone(),
            self.spoil.clone(),
            self.poses.to_string(),
            self.rows.to_string(),
            self.targets.to_string(),
            self.given.clone(),
            self.noise_mm.to_string(),
        ];
        cells.extend(self.figures.iter().map(f64::to_string));
        cells.push(self.finds.replace([',', '\n'], " "));
        cells.push(self.refused.join(";"));
        cells.join(",")
    }

    fn of(row: &str) -> Option<Self> {
        let cells: Vec<&str> = row.split(',').collect();
        if cells.len() != 13 + FIGURES.len() {
            return None;
        }
        let mut figures = [f64::NAN; FIGURES.len()];
        for (figure, cell) in figures.iter_mut().zip(&cells[11..]) {
            *figure = cell.parse().ok()?;
        }
        let tail = &cells[11 + FIGURES.len()..];
        Some(Record {
            number: cells[0].parse().ok()?,
            seed: cells[1].parse().ok()?,
            make: cells[2].into(),
            hidden: cells[3].into(),
            style: cells[4].into(),
            spoil: cells[5].into(),
            poses: cells[6].parse().ok()?,
            rows: cells[7].parse().ok()?,
            targets: cells[8].parse().ok()?,
            given: cells[9].into(),
            noise_mm: cells[10].parse().ok()?,
            figures,
            finds: tail[0].into(),
            refused: tail[1].split(';').filter(|why| !why.is_empty()).map(String::from).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back() {
        let mut record = Record {
            number: 7,
            seed: 7007,
            make: "small".into(),
            hidden: "gear".into(),
            style: "grid".into(),
            spoil: "zeros".into(),
            poses: 20,
            rows: 40,
            targets: 2,
            given: "base".into(),
            noise_mm: 0.1 + 0.2,
            figures: std::array::from_fn(|k| 0.1 * k as f64),
            finds: "transmission j1; backlash j2".into(),
            refused: Vec::new(),
        };
        record.refuse("discover", "too few, by far");
        let back = Record::of(&record.row()).expect("a record");
        assert_eq!(back, record);
        assert_eq!(Record::HEADER.split(',').count(), record.row().split(',').count());
        assert!(FIGURES.iter().enumerate().all(|(k, &figure)| figure as usize == k));
    }
}
