//! The nominal robot.

use crate::arrays::{Given2, beside, columns, joints, matrices, matrix, transforms};
use crate::error::{input, of_io, warnings};
use numpy::{PyArray2, PyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use truepose_errormodel::lanes::{JacobianGram, error_variances};
use truepose_errormodel::{EffectRegistry, ErrorModel, FittedModel, SessionRules, Surroundings};
use truepose_identify::{PostureScales, posture_observability};
use truepose_io::{
    ColumnMap, RobotDetails, RobotOptions, fit_json, parse_fit, read_robot, read_text, robot_beside,
    robot_from_text, robot_toml,
};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, Conditions, JointKind, Posture, PostureBuffer, joint_jacobian};
use truepose_workflow::{
    Known, ROBOTS, Undeclared, record_columns, record_details, recorded_columns, recorded_frames,
    recorded_units,
};

/// A robot with what its description says besides.
#[pyclass(frozen, module = "truepose._core")]
pub struct Robot {
    pub chain: Arc<Chain>,
    pub details: RobotDetails,
    pub columns: ColumnMap,
    pub warnings: Vec<String>,
    pub beside: Beside,
    /// Whether base and tool are unknown where an instrument measured: of a URDF, which states neither.
    pub undeclared: Undeclared,
}

/// What a description says of sessions and of landmarks, and its text where it says something: name of the file, text.
#[derive(Clone, Default)]
pub struct Beside {
    pub rules: SessionRules,
    pub surroundings: Arc<Surroundings>,
    text: Option<(String, String)>,
}

impl Beside {
    /// Of the text of a description, and its columns and details.
    fn of(name: &str, text: &str) -> PyResult<(Self, ColumnMap, RobotDetails)> {
        let read = robot_beside(name, text).map_err(of_io)?;
        let (rules, around) = (read.sessions, Arc::new(read.surroundings));
        let says = rules != SessionRules::default() || !around.landmarks.is_empty();
        let text = says.then(|| (name.to_owned(), text.to_owned()));
        Ok((Beside { rules, surroundings: around, text }, read.columns, read.details))
    }
}

/// Where the bytes of a robot have the text of its description.
const DESCRIPTION: &str = "description";
/// Where they state that gravity was not declared.
const ASSUMED: &str = "gravity_assumed";
/// Where they state that base and tool are unknown where an instrument measured.
const UNDECLARED: &str = "undeclared";

impl Robot {
    /// Of a chain, with what a fit has recorded of its description.
    pub fn of(chain: &Chain, fitted: &FittedModel) -> Self {
        let (units, frames) = (recorded_units(fitted), recorded_frames(fitted));
        Robot {
            chain: Arc::new(chain.clone()),
            details: RobotDetails { units, frames, certificate: None, gravity: true },
            columns: recorded_columns(fitted),
            warnings: Vec::new(),
            beside: Beside::default(),
            undeclared: Undeclared::default(),
        }
    }

    /// One of a chain alone, for effects that are asked about another robot.
    pub fn bare(chain: &Chain) -> Self {
        Robot {
            chain: Arc::new(chain.clone()),
            details: RobotDetails { gravity: true, ..RobotDetails::default() },
            columns: ColumnMap::default(),
            warnings: Vec::new(),
            beside: Beside::default(),
            undeclared: Undeclared::default(),
        }
    }

    /// Evaluates postures row by row.
    fn each<T>(
        &self,
        py: Python<'_>,
        q: &Given2<'_, f64>,
        of: impl Fn(Posture<'_>) -> T + Send + Sync,
    ) -> PyResult<Vec<T>>
    where
        T: Send,
    {
        let rows = joints(&self.chain, q)?;
        Ok(py.detach(|| {
            let mut buffer = PostureBuffer::new(&self.chain);
            rows.iter()
                .map(|row| {
                    let conditions = Conditions::at(&self.chain, row);
                    of(buffer.update(&self.chain, &conditions))
                })
                .collect()
        }))
    }
}

fn slices(columns: &[Vec<f64>]) -> Vec<&[f64]> {
    columns.iter().map(Vec::as_slice).collect()
}

/// A moving joint: name, unit, limits of the controller's value.
type Described = (String, &'static str, Option<(f64, f64)>);

#[pymethods]
impl Robot {
    /// Of a file, `.toml` or `.urdf`; `known`: whether base and tool of a URDF are those of the measurements.
    #[staticmethod]
    #[pyo3(signature = (path, base, tip, known=[false, false]))]
    pub fn from_file(
        path: PathBuf,
        base: Option<String>,
        tip: Option<String>,
        known: [bool; 2],
    ) -> PyResult<Self> {
        let (chain, said) = read_robot(&path, &RobotOptions { base, tip }).map_err(of_io)?;
        let toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        // What is no regular file can be read once.
        let (beside, columns, details) = match toml && path.is_file() {
            true => Beside::of(&path.display().to_string(), &read_text(&path).map_err(of_io)?)?,
            false => (Beside::default(), ColumnMap::default(), RobotDetails::default()),
        };
        let urdf = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
        let [base, tool] = known.map(|known| urdf && !known);
        let undeclared = Undeclared { base, tool };
        Ok(Robot { chain: Arc::new(chain), details, columns, warnings: warnings(&said), beside, undeclared })
    }

    /// Of the text of a TOML description.
    #[staticmethod]
    fn from_text(name: &str, text: &str) -> PyResult<Self> {
        let (chain, said) = robot_from_text(name, text, &RobotOptions::default()).map_err(of_io)?;
        let (beside, columns, details) = Beside::of(name, text)?;
        let undeclared = Undeclared::default();
        Ok(Robot { chain: Arc::new(chain), warnings: warnings(&said), columns, beside, details, undeclared })
    }

    /// Robots of the library: name, maker and model.
    #[staticmethod]
    fn library() -> Vec<(&'static str, &'static str)> {
        ROBOTS.iter().map(|robot| (robot.name, robot.title())).collect()
    }

    /// One of them.
    #[staticmethod]
    fn named(name: &str) -> PyResult<Self> {
        let Some(Known { name: known, text }) = Known::named(name) else {
            let near = Known::near(name).join(", ");
            let hint = if near.is_empty() { near } else { format!("; did you mean {near}?") };
            return Err(input(format!("the library has no robot `{name}`{hint}")));
        };
        Robot::from_text(&format!("{known}.toml"), text)
    }

    /// Every digit of it, for [`Robot::from_bytes`].
    fn to_bytes(&self) -> PyResult<String> {
        let model = ErrorModel::new((*self.chain).clone(), Vec::new()).map_err(input)?;
        let mut fitted = FittedModel::new(model, Vec::new(), DMatrix::zeros(0, 0)).map_err(input)?;
        record_details(&mut fitted, &self.details);
        record_columns(&mut fitted, &self.columns);
        if !self.details.gravity {
            fitted.provenance.insert(ASSUMED.into(), true.into());
        }
        let Undeclared { base, tool } = self.undeclared;
        if base || tool {
            fitted.provenance.insert(UNDECLARED.into(), serde_json::json!([base, tool]));
        }
        if let Some((name, text)) = &self.beside.text {
            fitted.provenance.insert(DESCRIPTION.into(), serde_json::json!([name, text]));
        }
        fit_json("robot", &fitted).map_err(of_io)
    }

    #[staticmethod]
    fn from_bytes(text: &str) -> PyResult<Self> {
        let fitted = parse_fit(text, &EffectRegistry::empty()).map_err(of_io)?;
        let word = |k: usize| fitted.provenance.get(DESCRIPTION)?.get(k)?.as_str();
        let beside = match (word(0), word(1)) {
            (Some(name), Some(text)) => Beside::of(name, text)?.0,
            _ => Beside::default(),
        };
        let mut robot = Robot { beside, ..Robot::of(fitted.chain(), &fitted) };
        robot.details.gravity = !fitted.provenance.contains_key(ASSUMED);
        let open = |k: usize| fitted.provenance.get(UNDECLARED).and_then(|of| of.get(k)?.as_bool());
        let [base, tool] = [0, 1].map(|k| open(k).unwrap_or(false));
        robot.undeclared = Undeclared { base, tool };
        Ok(robot)
    }

    #[getter]
    fn name(&self) -> &str {
        self.chain.name()
    }

    /// Of each moving joint: name, unit, limits of the controller's value.
    #[getter]
    fn joints(&self) -> Vec<Described> {
        let one = |&joint: &_| {
            let unit = if self.chain.joint(joint).kind == JointKind::Prismatic { "m" } else { "rad" };
            (self.chain.joint(joint).name.clone(), unit, self.chain.controller_limits(joint))
        };
        self.chain.movable().iter().map(one).collect()
    }

    /// Names of the frames: base, joints, tool.
    #[getter]
    fn frames(&self) -> Vec<String> {
        self.chain.frames().map(|frame| self.chain.frame_word(frame).to_owned()).collect()
    }

    /// How many of them, after the base, are of joints.
    #[getter]
    fn joint_frames(&self) -> usize {
        self.chain.joints().len()
    }

    /// Of each target: name, position in the tool's frame, m, whether it is known.
    #[getter]
    fn targets(&self) -> Vec<(String, [f64; 3], bool)> {
        self.chain.targets().iter().map(|t| (t.name.clone(), t.position.into(), t.known)).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The tool in the measurement frame.
    fn fk<'py>(&self, py: Python<'py>, q: Given2<'py, f64>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let poses = self.each(py, &q, |posture| *posture.tool())?;
        Ok(transforms(py, &poses))
    }

    /// 6 × dof for each row: [v; ω] of the tool per unit of each joint's variable.
    fn jacobian<'py>(&self, py: Python<'py>, q: Given2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let all = self.each(py, &q, |posture| joint_jacobian(&posture, &posture.tool().translation))?;
        let dof = self.chain.movable().len();
        // The controller's values, where joints are coupled.
        let mut change = DMatrix::identity(dof, dof);
        for k in 0..dof {
            let (mut unit, mut zero) = (vec![0.0; dof], vec![0.0; dof]);
            unit[k] = 1.0;
            self.chain.joints_from_controller(&mut unit);
            self.chain.joints_from_controller(&mut zero);
            (0..dof).for_each(|i| change[(i, k)] = unit[i] - zero[i]);
        }
        let mut flat = DMatrix::zeros(6 * all.len(), dof);
        for (k, jacobian) in all.iter().enumerate() {
            flat.rows_mut(6 * k, 6).copy_from(&(jacobian * &change));
        }
        Ok(matrix(py, &flat))
    }

    /// Σ JᵀJ of the error Jacobians of these rows: of position and of rotation, 6n × 6n for n joints.
    fn jacobian_gram<'py>(
        &self,
        py: Python<'py>,
        q: Given2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let columns = columns(&self.chain, &q)?;
        let gram = py.detach(|| JacobianGram::of(&self.chain, &slices(&columns))).map_err(input)?;
        Ok(matrices(py, &[gram.position(), &gram.rotation()]))
    }

    /// What these rows determine: singular values, O1 to O5, shares of the columns in the weakest direction.
    fn observability(
        &self,
        py: Python<'_>,
        q: Given2<'_, f64>,
        sds: (f64, Option<f64>),
        sizes: (f64, f64),
    ) -> PyResult<(Vec<f64>, [f64; 5], Vec<f64>)> {
        let columns = columns(&self.chain, &q)?;
        let orientation_sd = sds.1.unwrap_or(f64::INFINITY);
        let scales = PostureScales { position_sd: sds.0, orientation_sd, length: sizes.0, angle: sizes.1 };
        let found = py.detach(|| {
            let gram = JacobianGram::of(&self.chain, &slices(&columns))?;
            posture_observability(&gram, scales)
        });
        let found = found.map_err(input)?;
        Ok((found.singular_values, found.indices, found.weakest))
    }

    /// Variances of position and rotation for each row, n × 6, of the covariance of constant errors of the joints' frames.
    fn error_variances<'py>(
        &self,
        py: Python<'py>,
        q: Given2<'py, f64>,
        covariance: Given2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = columns(&self.chain, &q)?;
        let rows = q.shape()[0];
        let c = covariance.as_array();
        let c = DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)]);
        let mut variances = vec![0.0; 6 * rows];
        py.detach(|| error_variances(&self.chain, &slices(&columns), &c, &mut variances)).map_err(input)?;
        let parts: Vec<Vec<f64>> = (0..6).map(|k| variances[k * rows..(k + 1) * rows].to_vec()).collect();
        Ok(beside(py, rows, &parts))
    }

    fn to_toml(&self) -> String {
        robot_toml(&self.chain)
    }

    /// Joint values that are spread over the limits, n × dof: a quick way to poses for trials.
    fn lattice<'py>(&self, py: Python<'py>, count: usize) -> Bound<'py, PyArray2<f64>> {
        // Multiples of the square roots of primes, modulo one (Richtmyer 1951).
        let roots =
            [2.0f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0];
        let columns: Vec<Vec<f64>> = self
            .chain
            .movable()
            .iter()
            .zip(roots.iter().cycle())
            .map(|(&joint, root)| {
                let (lower, upper) = self.chain.controller_limits(joint).unwrap_or((-3.0, 3.0));
                (1..=count).map(|k| lower + (upper - lower) * (k as f64 * root.sqrt()).fract()).collect()
            })
            .collect();
        beside(py, count, &columns)
    }
}
