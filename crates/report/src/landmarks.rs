//! Spread at landmarks, and distances between them.

use crate::document::Document;
use crate::layout::Alignment;
use crate::observers::{SuspectSummary, sentences};
use crate::{PositionStatistics, significant};
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::{Contact, LandmarkFold, Residuals, Touched};
use truepose_kinematics::nalgebra::Vector3;

/// A campaign at landmarks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LandmarksSummary {
    /// Each landmark of unknown place.
    pub points: Vec<LandmarkSummary>,
    /// Points of the robot that met each other.
    #[serde(default)]
    pub contacts: Vec<ContactSummary>,
    /// Spread of the rows of all landmarks about their own mean, each group of landmarks predicted without its rows.
    pub held_out: Option<PositionStatistics>,
    /// Rows of the data in which they stand.
    #[serde(default)]
    pub contact_rows: usize,
    /// Known distances that the fit keeps.
    pub distances: Vec<KnownDistanceSummary>,
    /// Whether some row says how long anything is: a known distance, a measured position.
    pub scale_known: bool,
    /// RMS of the error of these distances where their landmarks were left out, mm; null where nothing was left out.
    pub distance_rms_mm: Option<f64>,
    /// What the data leaves open.
    pub remarks: Vec<String>,
    /// Landmarks that did not stay where they were.
    #[serde(default)]
    pub suspects: Vec<SuspectSummary>,
}

/// One landmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LandmarkSummary {
    /// Its name.
    pub name: String,
    /// Rows that touched it.
    pub rows: usize,
    /// Where it is, mm, measurement frame (that of the base where nothing outside was measured).
    pub xyz_mm: [f64; 3],
    /// Spread of its rows with the fit.
    pub train: PositionStatistics,
    /// The same by a fit without them.
    pub held_out: Option<PositionStatistics>,
}

/// Two points of the robot that met in several rows: the gap between them, or the error of their distance where one is stated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactSummary {
    /// The points.
    pub between: [String; 2],
    /// Rows in which they met.
    pub rows: usize,
    /// With the fit.
    pub train: PositionStatistics,
    /// By a fit without them.
    pub held_out: Option<PositionStatistics>,
}

/// A known distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownDistanceSummary {
    /// The landmarks.
    pub between: [String; 2],
    /// As it is stated, mm.
    pub stated_mm: f64,
    /// By a fit without the rows of both, mm; null where no other row would state how long anything is.
    pub held_out_mm: Option<f64>,
}

/// Spread of a landmark in units of the median of all, from which on it is named. With thirty rows each a spread is known to a tenth: two and
/// a half times the median is no chance.
const STRANGE: f64 = 2.5;

impl LandmarksSummary {
    /// Of a fit of these rows; `moved` is how far it has moved each landmark, m.
    pub fn new(
        found: &Touched,
        moved: &[Vector3<f64>],
        data: &Dataset,
        (residuals, held_out): (&Residuals, Option<&Residuals>),
        folds: &[LandmarkFold],
    ) -> Self {
        let rows_of = |k: usize| -> Vec<usize> {
            (0..data.len()).filter(|&row| data.landmark(row) == Some(k)).collect()
        };
        let met: Vec<usize> = found.contacts.iter().flat_map(Contact::rows).collect();
        let touched = |k: &usize| rows_of(*k).iter().all(|row| !met.contains(row));
        let points = (0..found.names.len()).filter(touched).map(|k| {
            let rows = rows_of(k);
            let at = found.positions[k] + moved.get(k).copied().unwrap_or_default();
            LandmarkSummary {
                name: found.names[k].clone(),
                rows: rows.len(),
                xyz_mm: (at * 1e3).into(),
                train: residuals.positions_of(&rows).into(),
                held_out: held_out.map(|of| of.positions_of(&rows).into()),
            }
        });
        let own = |row: &usize| data.landmark(*row).is_some() && !met.contains(row);
        let all: Vec<usize> = (0..data.len()).filter(own).collect();
        let place = |k: usize| {
            let judging = folds.iter().filter(|fold| !fold.keeps_scale);
            let mut of = judging.flat_map(|fold| fold.landmarks.iter().zip(&fold.positions));
            of.find(|(landmark, _)| **landmark == k).map(|(_, at)| *at)
        };
        let distances: Vec<KnownDistanceSummary> = found
            .distances
            .iter()
            .filter(|([a, b], _)| touched(a) && touched(b))
            .map(|&([a, b], metres)| KnownDistanceSummary {
                between: [found.names[a].clone(), found.names[b].clone()],
                stated_mm: 1e3 * metres,
                held_out_mm: place(a).zip(place(b)).map(|(a, b)| 1e3 * (b - a).norm()),
            })
            .collect();
        let errors: Vec<f64> =
            distances.iter().filter_map(|d| Some((d.held_out_mm? - d.stated_mm).powi(2))).collect();
        let distance_rms_mm =
            (!errors.is_empty()).then(|| (errors.iter().sum::<f64>() / errors.len() as f64).sqrt());
        LandmarksSummary {
            points: points.collect(),
            contacts: contacts(&found.contacts, residuals, held_out),
            contact_rows: met.len(),
            held_out: held_out.filter(|_| !all.is_empty()).map(|of| of.positions_of(&all).into()),
            distances,
            scale_known: found.has_scale,
            distance_rms_mm,
            remarks: found.remarks.clone(),
            suspects: Vec::new(),
        }
    }

    /// Whether the fit has unknown places: landmarks, or those of contacts between which it holds a distance.
    pub(crate) fn has_places(&self) -> bool {
        let contacts: usize = self.contacts.iter().map(|contact| contact.rows).sum();
        !self.points.is_empty() || self.contact_rows > contacts
    }

    /// Spread before and after, in one sentence: RMS of each stage over so many rows, mm, with its name. None where neither landmarks nor contacts
    /// alone were measured.
    pub(crate) fn verdict(&self, stages: &[(f64, &str)], rows: usize) -> Option<String> {
        let contacts: usize = self.contacts.iter().map(|contact| contact.rows).sum();
        // Whether it stands as one row or as two, the squares of a contact add up to half of that of its gap.
        let (what, factor, held_out, left_out) = match self.points.is_empty() {
            true if self.contact_rows < rows => return None,
            true => (
                "Gap between points that meet",
                (2.0 * rows as f64 / contacts.max(1) as f64).sqrt(),
                self.contacts.iter().any(|contact| contact.held_out.is_some()),
                "each predicted without its row",
            ),
            false => (
                "Spread at the landmarks",
                1.0,
                self.held_out.is_some(),
                "each group of landmarks predicted without its rows",
            ),
        };
        let on = if held_out { left_out } else { "on the rows of the fit (no rows were held out)" };
        let each = |(rms, name): &(f64, &str)| format!("{} mm ({name})", significant(rms * factor, 3));
        let stages: Vec<String> = stages.iter().map(each).collect();
        Some(format!("{what} (3-D RMS), {on}: {}.", stages.join(" → ")))
    }

    /// The landmarks of a group whose spread is out of line with the others: its rows, or its socket, are bad.
    fn strange(&self) -> Vec<&LandmarkSummary> {
        let spread = |point: &LandmarkSummary| point.held_out.unwrap_or(point.train).rms_mm;
        let mut all: Vec<f64> = self.points.iter().map(spread).collect();
        all.sort_by(f64::total_cmp);
        let Some(&median) = all.get(all.len() / 2).filter(|_| all.len() >= 4) else { return Vec::new() };
        self.points.iter().filter(|point| spread(point) > STRANGE * median).collect()
    }

    /// What it comes to, in sentences.
    pub fn sentences(&self) -> String {
        let mut text = match &self.held_out {
            Some(spread) => format!(
                "{} mm RMS (3-D) at landmarks that are left out of the fit in turn is precision at these places, not accuracy in the workspace.",
                significant(spread.rms_mm, 3),
            ),
            None if self.points.is_empty() => String::new(),
            None => {
                "All landmarks are of one group: nothing could be left out, and no figure here is held out."
                    .into()
            }
        };
        if !self.contacts.is_empty() {
            let space = if text.is_empty() { "" } else { " " };
            text += space;
            text += "The gap between points that meet is how well these find each other, not accuracy in the workspace. Among position errors a contact counts with its gap over √2, which has the noise of the position of one point.";
        }
        let strange = self.strange();
        if !strange.is_empty() {
            let names: Vec<&str> = strange.iter().map(|point| point.name.as_str()).collect();
            let spreads: Vec<String> = strange
                .iter()
                .map(|point| significant(point.held_out.unwrap_or(point.train).rms_mm, 3))
                .collect();
            text += &format!(
                "\nOut of line with the others: {} ({} mm). Look for rows with another socket, a socket that moved, or joints near a limit; leave them out (`--exclude`, `use`) and compare.",
                names.join(", "),
                spreads.join(", ")
            );
        }
        match (self.distance_rms_mm, self.scale_known) {
            (Some(rms), _) => {
                text += &format!(
                    "\nKnown distances, of landmarks that were left out: {} mm RMS of error over {}.",
                    significant(rms, 2),
                    crate::count(
                        self.distances.iter().filter(|d| d.held_out_mm.is_some()).count(),
                        "distance"
                    )
                );
            }
            (None, false) => text += "\nNo distance is known: the spread says nothing about lengths.",
            (None, true) if self.held_out.is_some() && !self.distances.is_empty() => {
                text += "\nThe known distances are of one group of landmarks. Without its rows nothing states how long anything is: they are predicted with the scale of the whole fit, and no distance is judged.";
            }
            (None, true) => {}
        }
        if !self.suspects.is_empty() {
            text += &format!("\n{}", sentences(&self.suspects).trim_end());
        }
        text
    }

    const CONTACT_HEAD: [&str; 6] =
        ["points that meet", "rows", "RMS, mm", "max, mm", "held out: RMS, mm", "max, mm"];

    /// A row a pair of points, under [`Self::CONTACT_HEAD`].
    fn contact_cells(&self) -> Vec<Vec<String>> {
        let two = |gap: Option<PositionStatistics>| match gap {
            Some(gap) => [gap.rms_mm, gap.max_mm].map(|mm| significant(mm, 3)),
            None => ["-".into(), "-".into()],
        };
        let row = |contact: &ContactSummary| {
            let mut cells = vec![contact.between.join(" – "), contact.rows.to_string()];
            cells.extend(two(Some(contact.train)));
            cells.extend(two(contact.held_out));
            cells
        };
        self.contacts.iter().map(row).collect()
    }

    const HEAD: [&str; 7] = ["landmark", "rows", "x, mm", "y, mm", "z, mm", "spread, mm", "held out, mm"];

    /// A row a landmark, under [`Self::HEAD`].
    fn cells(&self) -> Vec<Vec<String>> {
        let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |mm| significant(mm, 3));
        let row = |point: &LandmarkSummary| {
            let mut cells = vec![point.name.clone(), point.rows.to_string()];
            cells.extend(point.xyz_mm.map(|v| format!("{v:.2}")));
            cells.push(number(Some(point.train.rms_mm)));
            cells.push(number(point.held_out.map(|spread| spread.rms_mm)));
            cells
        };
        self.points.iter().map(row).collect()
    }

    /// Tables of all landmarks and of points that met.
    pub(crate) fn show(&self, document: &mut Document) {
        use Alignment::{Left, Right};
        if !self.points.is_empty() {
            let sides = [Left, Right, Right, Right, Right, Right, Right];
            let caption = "landmarks, RMS of the 3-D distance from their mean";
            document.table(caption, &Self::HEAD, &sides, self.cells());
        }
        if !self.contacts.is_empty() {
            let sides = [Left, Right, Right, Right, Right, Right];
            let caption = "gap between points that meet, or error of their stated distance";
            document.table(caption, &Self::CONTACT_HEAD, &sides, self.contact_cells());
        }
    }
}

/// Gaps, pair by pair.
fn contacts(all: &[Contact], residuals: &Residuals, held_out: Option<&Residuals>) -> Vec<ContactSummary> {
    let mut pairs: Vec<&[String; 2]> = Vec::new();
    for contact in all {
        if !pairs.contains(&&contact.between) {
            pairs.push(&contact.between);
        }
    }
    let summary = |between: &&[String; 2]| {
        let own: Vec<&Contact> = all.iter().filter(|contact| contact.between == **between).collect();
        let gaps = |of: &Residuals| -> PositionStatistics {
            let position: Vec<Vector3<f64>> = own.iter().map(|contact| contact.gap(of)).collect();
            Residuals { orientation: vec![None; position.len()], position }.positions().into()
        };
        let (train, held_out) = (gaps(residuals), held_out.map(gaps));
        ContactSummary { between: (*between).clone(), rows: own.len(), train, held_out }
    };
    pairs.iter().map(summary).collect()
}
