//! One campaign: fitted, and held against the plant.

use super::cell::{Fault, Kind, Made, Size, made};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::any::Any;
use std::error::Error;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::observation::Camera;
use truepose_errormodel::{AnyEffect, ErrorModel};
use truepose_identify::{
    Fit, FitOptions, NoiseSource, Prior, PriorStrength, Suspect, Touched, fit, refit, suspects, touched,
};
use truepose_kinematics::nalgebra::{Matrix3, Vector3};
use truepose_kinematics::{Conditions, Pose, nearest_rotation, rotation_log};
use truepose_solvers::PivotedQr;

/// A campaign and its fit.
pub struct Trial {
    made: Made,
    found: Fit,
    touched: Touched,
    asked: (Vec<Kind>, Option<Fault>, Size, u64),
}

/// Poses at which a fit is held against the plant.
const FRESH: usize = 200;
/// Of the noise, so much is in the campaign that stands for the truth.
const QUIET: f64 = 1e-3;

impl Trial {
    /// The campaign of these kinds.
    pub fn of(kinds: &[Kind], fault: Option<Fault>, size: Size, seed: u64) -> Result<Self, Box<dyn Error>> {
        let made = made(kinds, fault, size, seed)?;
        let (solver, options) = (PivotedQr::default(), FitOptions::default());
        let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        let touched = touched(&made.chain, &declared, &made.data, &made.described, (&solver, &options))?;
        let model = ErrorModel::new(touched.chain.clone(), touched.effects.clone())?;
        let found = fit(&model, &touched.data, &solver, &options)?;
        Ok(Trial { made, found, touched, asked: (kinds.to_vec(), fault, size, seed) })
    }

    /// The same without noise to speak of.
    pub fn quiet(&self) -> Result<Trial, Box<dyn Error>> {
        let (kinds, fault, size, seed) = &self.asked;
        Trial::of(kinds, *fault, Size { noise: QUIET * size.noise, ..*size }, *seed)
    }

    /// RMS of the distance between the fitted and the real arm over its workspace, mm, each put onto the other as well as it can be.
    pub fn accuracy(&self) -> Result<f64, Box<dyn Error>> {
        let robot = self.found.fitted.without_landmarks()?;
        let mut predictor = robot.bind(&Default::default())?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.asked.3 ^ 0x7071);
        let (mut real, mut told) = (Vec::new(), Vec::new());
        for _ in 0..FRESH {
            let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
            let at = Conditions::at(&self.made.chain, &joints);
            real.push(self.made.plant.true_position(&at, None)?);
            told.push(predictor.predict(&at, None).translation);
        }
        let count = FRESH as f64;
        let middle = |of: &[Vector3<f64>]| of.iter().sum::<Vector3<f64>>() / count;
        let (a, b) = (middle(&real), middle(&told));
        let pairs = || real.iter().zip(&told);
        let cross: Matrix3<f64> = pairs().map(|(p, q)| (p - a) * (q - b).transpose()).sum();
        let turn = nearest_rotation(&cross).ok_or("the predicted points are no numbers")?;
        let squares: f64 = pairs().map(|(p, q)| (p - a - turn * (q - b)).norm_squared()).sum();
        Ok(1e3 * (squares / count).sqrt())
    }

    /// Of the 95 % intervals of the arm's grouped errors, how many hold what a campaign without noise gives, and how many there are.
    pub fn coverage(&self, quiet: &Trial) -> Result<(usize, usize), Box<dyn Error>> {
        let model = quiet.found.fitted.model();
        let options = FitOptions {
            prior: PriorStrength::None,
            noise: NoiseSource::Fixed(quiet.found.noise),
            ..FitOptions::default()
        };
        let prior = Prior::new(model, &self.found.reduction, PriorStrength::None);
        let data = &quiet.touched.data;
        let truth = refit(model, data, &PivotedQr::default(), &options, &self.found.reduction, &prior)?;
        let (own, half) = (self.found.fitted.coefficients(), self.found.half_widths());
        let of_arm = self.found.fitted.model().columns_of(0);
        let groups = self.found.reduction.groups.iter().map(|group| group.column);
        let mut counts = (0, 0);
        for column in groups.filter(|column| of_arm.contains(column)) {
            let off = (own[column] - truth.fitted.coefficients()[column]).abs();
            counts.0 += usize::from(off <= half[column]);
            counts.1 += 1;
        }
        Ok(counts)
    }

    /// What the program suspects of landmarks and sensors, unasked.
    pub fn suspects(&self) -> Result<Vec<Suspect>, Box<dyn Error>> {
        Ok(suspects(&self.found, &self.touched.data, &self.touched)?)
    }

    /// The camera on the robot as it was found.
    fn eye(&self) -> Option<(usize, Pose)> {
        let number = self.touched.sensors.iter().position(|found| found.name == "eye")?;
        let camera = (&*self.touched.sensors[number].observation as &dyn Any).downcast_ref::<Camera>()?;
        Some((number, camera.place?))
    }

    /// Of the six 95 % intervals of the place of the camera on the robot, how many hold where it is.
    pub fn eye_within(&self, quiet: &Trial) -> Result<usize, Box<dyn Error>> {
        let (number, found) = self.eye().ok_or("no camera on the robot was found")?;
        let (_, truth) = quiet.eye().ok_or("no camera on the robot was found")?;
        let sd = self.found.fitted.sensors_uncertain().ok_or("no sensor has an interval")?;
        let turn = rotation_log(&(found.rotation * truth.rotation.transpose()));
        let shift = found.translation - truth.translation;
        let off = shift.iter().chain(turn.iter());
        Ok(off.zip(&sd[number]).filter(|(off, sd)| off.abs() <= 1.96 * **sd).count())
    }
}
