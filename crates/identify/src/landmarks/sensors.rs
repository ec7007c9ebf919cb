//! Rows that measured one number: linearised at the robot and at their sensors as these are known, and weighed by kind.
//!
//! ```text
//! w = μ H,   P = p₀ + Hᵀ (z − h₀)/‖H‖²,   μ = σ₀/σ_k           (errormodel: [`Ray`])
//! σ_k² = Σ (r² − (1 − λ_i) ρ²‖w‖²) / Σ (1 − λ_i),   λ_i = a_i C a_iᵀ/(σ² + ρ²‖w‖²)   over the rows of kind k
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | h₀, H, K | [`Observation::read`] at the present robot | |
//! | σ₀, σ_k | standard deviation of a number of the reference (rows with a position; else the kind with most rows), and of kind k | m, the kind's unit |
//! | λ_i, a_i | leverage of a number, its row of the design matrix | 1 |
//! | C | covariance of the coefficients | |
//! | ρ | `visit_sd`: what the numbers of a standstill share | m |
//!
//! The second line is the equation of restricted maximum likelihood for variance components (Searle, Casella and McCulloch 1992, ch. 6), solved by
//! repetition beside the linearisation. So a table that is not flat counts as little as it should.

use super::carried::Carried;
use crate::linearise::Lineariser;
use crate::{Fit, IdentifyError};
use nalgebra::{DVector, Vector3};
use std::any::Any;
use truepose_errormodel::effects::{Observed, Sensor, Unknown};
use truepose_errormodel::observation::{Camera, Observation, Reading, Seen};
use truepose_errormodel::{Dataset, FittedModel, Ray, Surroundings};
use truepose_kinematics::{Conditions, Pose};

/// A thing of which rows measured numbers.
#[derive(Debug, Clone)]
pub struct SensorFound {
    /// Its name.
    pub name: String,
    /// What it is, its unknowns as they were found.
    pub observation: Box<dyn Observation>,
    /// Its rows.
    pub rows: Vec<usize>,
    /// σ_k of its kind, in its unit: as stated, or as found.
    pub sd: f64,
    /// μ, m per unit: how much its rows count.
    pub weight: f64,
    /// Whether the standard deviation is stated.
    stated: bool,
}

impl SensorFound {
    /// The camera, where it is one.
    pub(super) fn camera(&self) -> Option<&Camera> {
        (&*self.observation as &dyn Any).downcast_ref()
    }
}

/// Standard deviation with which a kind begins, m and px: what [`truepose_errormodel::NoiseModel`] begins with, and what it is as an angle.
const FIRST_SD: f64 = 1e-4;
const FIRST_PIXELS: f64 = 0.3;
/// A standard deviation changes by no more than this factor at a time: the first fits still have the robot's errors in them.
const MOST_CHANGE: f64 = 10.0;
/// Of the numbers of a kind so many are left to scatter at the least, as in [`crate::Freedom`].
const LEAST_LEFT: f64 = 0.02;
/// Of the squares of a kind so much is its own at the least, however much of it the standstills share.
const LEAST_OWN: f64 = 0.01;

/// The sensors of a campaign.
#[derive(Debug, Clone, Default)]
pub(super) struct Sensors {
    pub found: Vec<SensorFound>,
    /// Of each row: its sensor.
    pub of_row: Vec<Option<usize>>,
    /// σ₀, m.
    reference: f64,
    /// What was measured in each row, all its numbers.
    measured: Vec<Vec<f64>>,
    /// Which of them the row stands for.
    which: Vec<usize>,
}

impl Sensors {
    /// The rows of things that are observed by numbers; `landmark` is the declared landmark of each row.
    pub fn of(
        data: &Dataset,
        landmark: &[Option<usize>],
        surroundings: &Surroundings,
    ) -> Result<Self, IdentifyError> {
        let which = which(data, landmark, surroundings);
        let mut sensors = Sensors {
            of_row: vec![None; data.len()],
            reference: FIRST_SD,
            measured: vec![Vec::new(); data.len()],
            which,
            ..Sensors::default()
        };
        for (k, declared) in surroundings.landmarks.iter().enumerate() {
            let Some(observation) = &declared.observed else { continue };
            let rows: Vec<usize> = (0..data.len()).filter(|&row| landmark[row] == Some(k)).collect();
            if rows.is_empty() {
                continue;
            }
            let unknowns = observation.unknowns(&declared.name, 1.0).len();
            let count = rows.len() / observation.numbers();
            if rows.len() <= unknowns {
                return Err(IdentifyError::Landmark {
                    name: declared.name.clone(),
                    why: format!(
                        "{} for its {unknowns} unknowns {} nothing about the robot: measure it from more postures, declare what is known of it, or leave it out",
                        if count == 1 { "one row".into() } else { format!("{count} rows") },
                        if count == 1 { "says" } else { "say" },
                    ),
                });
            }
            for &row in &rows {
                sensors.of_row[row] = Some(sensors.found.len());
                let numbers = (0..observation.numbers()).map(|which| data.scalar(row, which).unwrap_or(0.0));
                sensors.measured[row] = numbers.collect();
            }
            let first = if observation.unit() == "px" { FIRST_PIXELS } else { FIRST_SD };
            let sd = declared.sd.unwrap_or(first);
            sensors.found.push(SensorFound {
                name: declared.name.clone(),
                observation: observation.clone(),
                rows,
                sd,
                weight: FIRST_SD / sd,
                stated: declared.sd.is_some(),
            });
        }
        Ok(sensors)
    }

    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Whether a row is another number of the row before it.
    pub fn follows(&self, row: usize) -> bool {
        self.which[row] > 0
    }

    /// Which of the numbers of its observation a row stands for.
    pub fn which(&self, row: usize) -> usize {
        self.which[row]
    }

    /// All numbers that were measured with a row.
    pub fn numbers(&self, row: usize) -> &[f64] {
        &self.measured[row]
    }

    /// Of a sensor, the first row of each observation.
    pub fn first_rows(&self, sensor: usize) -> impl Iterator<Item = usize> + '_ {
        self.found[sensor].rows.iter().copied().filter(|&row| self.which[row] == 0)
    }

    /// Finds every sensor with the robot as it is; of rows of carried cameras these are poses of the tool.
    pub fn start(&mut self, at: &[Pose], carried: &Carried) -> Result<(), IdentifyError> {
        self.start_those(at, carried, &|_| true)
    }

    /// The same of these sensors alone.
    pub fn start_those(
        &mut self,
        at: &[Pose],
        carried: &Carried,
        wanted: &dyn Fn(&dyn Observation) -> bool,
    ) -> Result<(), IdentifyError> {
        for found in self.found.iter_mut().filter(|found| wanted(&*found.observation)) {
            let first = found.rows.iter().filter(|&&row| self.which[row] == 0);
            let seen: Vec<Seen> = first
                .map(|&row| (carried.seen_from(row, &at[row]).unwrap_or(at[row]), self.measured[row].clone()))
                .collect();
            let why = |why: String| IdentifyError::Landmark { name: found.name.clone(), why };
            found.observation = found.observation.started(&seen).map_err(why)?;
        }
        Ok(())
    }

    /// The rows as a fit takes them, linearised where the robot and the sensors are. Of a carried camera the target stands at the point that it
    /// sees.
    pub fn linearised(
        &self,
        at: &[Pose],
        data: &Dataset,
        carried: &Carried,
    ) -> Result<Vec<Option<Ray>>, IdentifyError> {
        let mut reading = Reading::default();
        let mut rays = Vec::with_capacity(data.len());
        for (row, sensor) in self.of_row.iter().enumerate() {
            let Some(sensor) = *sensor else {
                rays.push(None);
                continue;
            };
            let found = &self.found[sensor];
            let why = |why: &str| {
                let line =
                    data.line.get(row).map_or(format!("row {}", row + 1), |line| format!("line {line}"));
                IdentifyError::Landmark { name: found.name.clone(), why: format!("{line}: {why}") }
            };
            let from = carried.seen_from(row, &at[row]);
            if !found.observation.read(from.as_ref().unwrap_or(&at[row]), &mut reading) {
                return Err(why(
                    "the target cannot be observed from there: it is behind the camera, or at the anchor itself",
                ));
            }
            let which = self.which[row];
            let [x, y, z, turns @ ..] = reading.by_pose[which];
            let (h, place) = match carried.point(row) {
                Some(point) => (-(at[row].rotation * Vector3::new(x, y, z)), point),
                None => (Vector3::new(x, y, z), at[row].translation),
            };
            let square = h.norm_squared();
            if turns.iter().any(|&v| v.abs() > 1e-9 * square.sqrt()) || square <= 0.0 {
                return Err(why("a number that depends on the orientation of the tool is not supported"));
            }
            let left = self.measured[row][which] - reading.value[which];
            rays.push(Some(Ray {
                direction: h * found.weight,
                position: place + h * (left / square),
                sensor: Some(sensor),
                own: reading.by_own[which].iter().map(|k| k / (found.weight * square)).collect(),
            }));
        }
        Ok(rays)
    }

    /// Their unknowns as an effect, on a robot of this length, m.
    pub fn effect(&self, length: f64) -> Observed {
        let sensor = |found: &SensorFound| Sensor {
            name: found.name.clone(),
            unknowns: found
                .observation
                .unknowns(&found.name, length)
                .into_iter()
                .map(|column| Unknown { name: column.name, unit: column.unit, scale: column.scale })
                .collect(),
        };
        Observed { sensors: self.found.iter().map(sensor).collect() }
    }

    /// Moves the unknowns to where a fit has them; the largest move in expected sizes.
    pub fn moved(&mut self, by: &[Vec<f64>], length: f64) -> f64 {
        let mut most = 0.0f64;
        for (found, by) in self.found.iter_mut().zip(by) {
            let sizes = found.observation.unknowns(&found.name, length);
            most = sizes.iter().zip(by).fold(most, |most, (column, by)| most.max((by / column.scale).abs()));
            found.observation = found.observation.moved(by);
        }
        most
    }

    /// Standard deviations from what a fit leaves, kind by kind; the largest relative change of a weight.
    pub fn weigh(&mut self, fit: &Fit, data: &Dataset) -> Result<f64, IdentifyError> {
        let strata = strata(fit, data, &self.of_row)?;
        let of = |rows: &dyn Fn(usize) -> bool| -> Option<(f64, f64)> {
            let (mut squares, mut shared, mut left, mut count) = (0.0, 0.0, 0.0, 0.0);
            for number in strata.iter().filter(|number| rows(number.row)) {
                squares += number.residual * number.residual;
                shared += (1.0 - number.leverage) * number.shared;
                left += 1.0 - number.leverage;
                count += 1.0;
            }
            let own = (squares - shared).max(LEAST_OWN * squares);
            (count > 0.0).then(|| (own / left.max(LEAST_LEFT * count), count))
        };
        let kinds: Vec<&'static str> = self.found.iter().map(|found| found.observation.kind()).collect();
        // In metres of the present weights.
        let positions = of(&|row| self.of_row[row].is_none());
        let own: Vec<Option<(f64, f64)>> = kinds
            .iter()
            .map(|kind| of(&|row| self.of_row[row].is_some_and(|sensor| kinds[sensor] == *kind)))
            .collect();
        let largest = own.iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1)).copied();
        let Some((reference, _)) = positions.or(largest) else { return Ok(0.0) };
        self.reference = reference.max(1e-20).sqrt();
        let mut most = 0.0f64;
        for (found, own) in self.found.iter_mut().zip(&own) {
            if let Some((variance, _)) = own.filter(|_| !found.stated) {
                let sd = variance.max(1e-24).sqrt() / found.weight;
                found.sd = sd.clamp(found.sd / MOST_CHANGE, found.sd * MOST_CHANGE);
            }
            let weight = self.reference / found.sd;
            most = most.max((weight / found.weight).ln().abs());
            found.weight = weight;
        }
        Ok(most)
    }
}

/// The data with rows that measured several numbers once for each of them, one after the other.
pub(super) fn one_number_a_row(data: &Dataset, surroundings: &Surroundings) -> Dataset {
    let numbers = |row: usize| {
        let declared = data.landmark(row).and_then(|k| surroundings.landmarks.get(k));
        declared.and_then(|declared| declared.observed.as_ref()).map_or(1, |observed| observed.numbers())
    };
    let rows: Vec<usize> = (0..data.len()).flat_map(|row| std::iter::repeat_n(row, numbers(row))).collect();
    if rows.len() == data.len() {
        return data.clone();
    }
    // They are the whole of the record, not a part of it.
    Dataset { record: None, ..data.select(&rows) }
}

/// Of each row, which of the numbers of its observation it stands for: rows of one observation follow each other.
fn which(data: &Dataset, landmark: &[Option<usize>], surroundings: &Surroundings) -> Vec<usize> {
    let mut which = vec![0; data.len()];
    let mut row = 0;
    while row < data.len() {
        let declared = landmark[row].and_then(|k| surroundings.landmarks[k].observed.as_ref());
        let numbers = declared.map_or(1, |observed| observed.numbers());
        (0..numbers).filter(|k| row + k < data.len()).for_each(|k| which[row + k] = k);
        row += numbers.max(1);
    }
    which
}

/// A measured number after a fit.
struct Number {
    row: usize,
    /// 0 to 2; 0 along a direction.
    component: usize,
    /// m.
    residual: f64,
    /// Variance that the unknowns give it, m².
    open: f64,
    /// Of the unknowns, so much of it.
    leverage: f64,
    /// Variance that it shares with its standstill, m².
    shared: f64,
}

/// Residual and leverage of every number of a position, or along a direction.
fn strata(fit: &Fit, data: &Dataset, of_row: &[Option<usize>]) -> Result<Vec<Number>, IdentifyError> {
    let mut all = Vec::new();
    let covariance = fit.fitted.covariance();
    let mut lineariser = Lineariser::new(fit.fitted.model(), data, fit.noise, fit.fitted.coefficients())?;
    let width = lineariser.width();
    for row in 0..of_row.len() {
        let block = lineariser.unweighted(&[row]);
        for (numbers, &(_, component)) in block.rows.chunks_exact(width).zip(block.source) {
            if component > 2 {
                continue;
            }
            let a = DVector::from_column_slice(&numbers[..width - 1]);
            let shared =
                fit.noise.visit_sd.powi(2) * data.ray(row).map_or(1.0, |direction| direction.norm_squared());
            let variance = fit.noise.position(data.position_sd[row][component]).powi(2) + shared;
            let open = a.dot(&(covariance * &a)).max(0.0);
            let leverage = (open / variance).min(1.0);
            all.push(Number { row, component, residual: numbers[width - 1], open, leverage, shared });
        }
    }
    Ok(all)
}

/// The share of a fit's unknowns that each of some rows determines: its leverage over the sum of all, by row.
///
/// # Errors
/// When the data does not fit the model.
pub fn leverages(fit: &Fit, data: &Dataset) -> Result<Vec<f64>, IdentifyError> {
    let data = &*data.derived_for(fit.fitted.model())?;
    let mut of_row = vec![0.0; data.len()];
    for number in strata(fit, data, &vec![None; data.len()])? {
        of_row[number.row] += number.leverage;
    }
    let all: f64 = of_row.iter().sum();
    of_row.iter_mut().for_each(|share| *share /= all.max(f64::MIN_POSITIVE));
    Ok(of_row)
}

/// The variance that the unknowns of a fit, those of sensors and landmarks too, give the measured numbers of some rows, by axis, m²: of a number
/// along a direction, its parts on the axes; zero where nothing was measured.
///
/// # Errors
/// When the data does not fit the model.
pub fn open_variances(fit: &Fit, data: &Dataset, rows: &[usize]) -> Result<Vec<[f64; 3]>, IdentifyError> {
    let part = &data.derived_for(fit.fitted.model())?.select(rows);
    let mut of_row = vec![[0.0; 3]; part.len()];
    for number in strata(fit, part, &vec![None; part.len()])? {
        match part.ray(number.row) {
            Some(w) => {
                let square = w.norm_squared();
                (0..3).for_each(|k| of_row[number.row][k] += number.open * (w[k] / square).powi(2));
            }
            None => of_row[number.row][number.component] = number.open,
        }
    }
    Ok(of_row)
}

/// The tool at the measured target in every row, as a robot without landmarks and sensors has it; at the difference of two points that met.
pub(super) fn poses(robot: &FittedModel, data: &Dataset) -> Result<Vec<Pose>, IdentifyError> {
    let data = &*data.derived_for(robot.model())?;
    let mut predictor = robot.bind(&data.schema)?;
    let mut conditions = Conditions::default();
    let mut at = Vec::with_capacity(data.len());
    for row in 0..data.len() {
        data.conditions_into(row, &mut conditions);
        at.push(predictor.predict(&conditions, data.aim(row)));
    }
    Ok(at)
}
