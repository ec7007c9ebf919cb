//! One campaign: fitted, and held against the plant.

use super::cell::{Fault, Kind, Made, Size, eye_place, made};
use crate::prelude::*;
use std::any::Any;
use truepose_errormodel::observation::Camera;
use truepose_identify::reduction::Group;
use truepose_identify::{Suspect, Touched, suspects, touched};
use truepose_kinematics::{Site, nearest_rotation, rotation_log};

/// A campaign and its fit.
pub struct Trial {
    made: Made,
    found: Fit,
    pub(super) touched: Touched,
    recipe: (Vec<Kind>, Option<Fault>, Size, u64),
}

/// Poses at which a fit is held against the plant.
const FRESH: usize = 200;
/// Of the noise, so much is in the campaign that stands for the truth.
const QUIET: f64 = 1e-3;
/// Of the width of an interval, what that campaign leaves of it where the data determines it.
const NARROW: f64 = 0.1;

impl Trial {
    /// The campaign of these kinds.
    pub fn of(kinds: &[Kind], fault: Option<Fault>, size: Size, seed: u64) -> Outcome<Self> {
        let made = made(kinds, fault, size, seed)?;
        let (solver, options) = (PivotedQr::default(), FitOptions::default());
        let declared = constant_errors();
        let touched = touched(&made.chain, &declared, &made.data, &made.described, (&solver, &options))?;
        let model = ErrorModel::new(touched.chain.clone(), touched.effects.clone())?;
        let found = fit(&model, &touched.data, &solver, &touched.options(&options))?;
        Ok(Trial { made, found, touched, recipe: (kinds.to_vec(), fault, size, seed) })
    }

    /// The same without noise to speak of.
    pub fn quiet(&self) -> Outcome<Trial> {
        let (kinds, fault, size, seed) = &self.recipe;
        Trial::of(kinds, *fault, Size { noise: QUIET * size.noise, ..*size }, *seed)
    }

    /// RMS of the distance between the fitted and the real arm over its workspace, mm, each put onto the other as well as it can be.
    pub fn accuracy(&self) -> Outcome<f64> {
        let robot = self.found.fitted.without_landmarks()?;
        let mut predictor = robot.bind(&Default::default())?;
        let mut rng = ChaCha8Rng::seed_from_u64(self.recipe.3 ^ 0x7071);
        let (mut real, mut predicted) = (Vec::new(), Vec::new());
        for _ in 0..FRESH {
            let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
            let at = Conditions::at(&self.made.chain, &joints);
            real.push(self.made.plant.true_position(&at, None)?);
            predicted.push(predictor.predict(&at, None).translation);
        }
        let count = FRESH as f64;
        let middle = |of: &[Vector3<f64>]| of.iter().sum::<Vector3<f64>>() / count;
        let (a, b) = (middle(&real), middle(&predicted));
        let pairs = || real.iter().zip(&predicted);
        let cross: Matrix3<f64> = pairs().map(|(p, q)| (p - a) * (q - b).transpose()).sum();
        let turn = nearest_rotation(&cross).ok_or("the predicted points are no numbers")?;
        let squares: f64 = pairs().map(|(p, q)| (p - a - turn * (q - b)).norm_squared()).sum();
        Ok(1e3 * (squares / count).sqrt())
    }

    /// Of the 95 % intervals of the arm's grouped errors, how many hold the truth, and how many there are.
    ///
    /// That is what a campaign without noise gives. Where that is no narrower either, two errors move the same numbers alike (a camera on the
    /// tool and the tool itself): then it is the group's sum of the plant's own errors. Groups that hold a sensor's or landmark's own unknown are left out there.
    pub fn coverage(&self, quiet: &Trial) -> Outcome<(usize, usize)> {
        let truth = coefficients_of_plant(
            quiet.found.fitted.model(),
            &self.found,
            &quiet.touched.data,
            quiet.found.noise,
        )?;
        let (own, half) = (self.found.fitted.coefficients(), self.found.half_widths());
        let narrow = quiet.found.half_widths();
        let of_arm = self.found.fitted.model().columns_of(0);
        let mut counts = (0, 0);
        for group in self.found.reduction.groups.iter().filter(|group| of_arm.contains(&group.column)) {
            let column = group.column;
            let held = match narrow[column] <= NARROW * half[column] {
                true => Some(truth[column]),
                false => self.summed(group),
            };
            let Some(held) = held else { continue };
            counts.0 += usize::from((own[column] - held).abs() <= half[column]);
            counts.1 += 1;
        }
        Ok(counts)
    }

    /// What a group of constant errors comes to with the plant's own; none where other unknowns belong to it.
    fn summed(&self, group: &Group) -> Option<f64> {
        let columns = self.found.fitted.model().columns();
        let frames = &self.made.plant.truth().frames;
        let of_plant = |column: usize| match columns[column].site? {
            Site::Frame(frame, axis) => Some(frames.get(frame.0)?[axis.index()]),
            Site::Target(..) => None,
        };
        let members = group.members.iter().map(|&(column, by)| Some(by * of_plant(column)?));
        members.sum::<Option<f64>>().and_then(|sum| Some(sum + of_plant(group.column)?))
    }

    /// What the program suspects of landmarks and sensors, unasked.
    pub fn suspects(&self) -> Outcome<Vec<Suspect>> {
        Ok(suspects(&self.found, &self.touched.data, &self.touched)?)
    }

    /// Of the six 95 % intervals of the place of the camera on the robot, how many hold where it is.
    pub fn eye_within(&self) -> Outcome<usize> {
        let missing = "no camera on the robot was found";
        let number = self.touched.sensors.iter().position(|found| found.name == "eye").ok_or(missing)?;
        let camera = (&*self.touched.sensors[number].observation as &dyn Any).downcast_ref::<Camera>();
        let found = camera.and_then(|camera| camera.place).ok_or(missing)?;
        let sd = self.found.fitted.sensors_uncertain().ok_or("no sensor has an interval")?;
        let truth = eye_place();
        let turn = rotation_log(&(found.rotation * truth.rotation.transpose()));
        let shift = found.translation - truth.translation;
        let off = shift.iter().chain(turn.iter());
        Ok(off.zip(&sd[number]).filter(|(off, sd)| off.abs() <= 1.96 * **sd).count())
    }
}
