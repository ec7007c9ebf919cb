//! Robots, plants and fits as several studies need them.

use crate::prelude::*;
pub use truepose_compensate::Target as Goal;

/// A pose that is declared known.
pub fn known(pose: Pose) -> Placed {
    Placed { pose, known: true }
}

/// A target that is declared known, on the first tool.
pub fn target(name: impl Into<String>, position: Vector3<f64>) -> Target {
    Target { name: name.into(), position, known: true, tool: ToolId::FIRST }
}

/// The robot with other joints: same base, tool, gravity and targets.
pub fn with_joints(chain: &Chain, joints: Vec<Joint>) -> Outcome<Chain> {
    Ok(Chain::new(chain.name(), joints)?
        .with_base(*chain.base())?
        .with_tool(*chain.tool())?
        .with_gravity(*chain.gravity())?
        .with_targets(chain.targets().to_vec())?)
}

/// The name of a joint.
pub fn name_of(chain: &Chain, joint: JointId) -> String {
    chain.joint(joint).name.clone()
}

/// Whether a joint is prismatic.
pub fn slides(chain: &Chain, joint: JointId) -> bool {
    chain.joint(joint).kind == JointKind::Prismatic
}

/// Compliance of a joint, N·m/rad or N/m.
pub fn spring(joint: String, stiffness: f64) -> flaws::JointCompliance {
    flaws::JointCompliance { joint, stiffness: Some(stiffness), ..Default::default() }
}

/// Backlash by the direction of approach: mrad of a turn, mm of a slide.
pub fn backlash(joint: String, slide: bool, milli: f64) -> flaws::Backlash {
    let (width_mrad, width_mm) = ((!slide).then_some(milli), slide.then_some(milli));
    flaws::Backlash { joint, width_mrad, width_mm, ..Default::default() }
}

/// Transmission error of a turn: of its teeth where there are cycles, else of an eccentric wheel.
pub fn gear(joint: String, amplitude_mrad: f64, cycles: Option<f64>) -> flaws::Transmission {
    let wheel = if cycles.is_some() { flaws::Wheel::Mesh } else { flaws::Wheel::Eccentric };
    flaws::Transmission { joint, wheel, amplitude_mrad, cycles, phase_deg: None }
}

/// Constant errors alone, as `identify` declares them.
pub fn constant_errors() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default())]
}

/// Constant errors and joint compliance.
pub fn elastic_errors() -> Vec<Box<dyn AnyEffect>> {
    vec![Box::new(Geometric::default()), Box::new(JointCompliance::default())]
}

/// A fit of declared effects by pivoted QR.
pub fn fitted(
    chain: &Chain,
    declared: &[Box<dyn AnyEffect>],
    data: &Dataset,
    options: &FitOptions,
) -> Outcome<Fit> {
    let model = ErrorModel::new(chain.clone(), declared.to_vec())?;
    Ok(fit(&model, data, &PivotedQr::default(), options)?)
}

/// Coefficients with which the reduced model of a fit is the plant: fitted to what is measured without noise.
pub fn coefficients_of_plant(
    model: &ErrorModel,
    found: &Fit,
    noise_free: &Dataset,
    noise: NoiseModel,
) -> Outcome<Vec<f64>> {
    let options =
        FitOptions { prior: PriorStrength::None, noise: NoiseSource::Fixed(noise), ..FitOptions::default() };
    let prior = Prior::new(model, &found.reduction, PriorStrength::None);
    let fit = refit(model, noise_free, &PivotedQr::default(), &options, &found.reduction, &prior)?;
    Ok(fit.fitted.coefficients().to_vec())
}

/// The plant without the noise of its instrument and its joints.
pub fn noise_free(plant: &Plant) -> Plant {
    let mut plant = plant.clone();
    let instrument = &mut plant.instrument;
    (instrument.sd, instrument.radial_per_metre, instrument.transverse_per_metre) = (0.0, 0.0, 0.0);
    instrument.orientation_sd = instrument.orientation_sd.map(|_| 0.0);
    plant.repeatability.sd = 0.0;
    plant
}

/// Largest load of each movable joint of the robot as described under these conditions, N·m or N.
pub fn largest_loads(chain: &Chain, conditions: impl Iterator<Item = Conditions>) -> Outcome<Vec<f64>> {
    let plant = Plant::perfect(chain)?;
    let mut largest = vec![0.0f64; chain.movable().len()];
    for conditions in conditions {
        for (most, load) in largest.iter_mut().zip(plant.joint_loads(&conditions)?) {
            *most = most.max(load.abs());
        }
    }
    Ok(largest)
}

/// Where the nominal robot has a target: the position, and the pose as a goal; with fewer joints than six the position alone.
pub fn nominal_goal(
    chain: &Chain,
    conditions: &Conditions,
    target: Option<TargetId>,
) -> (Vector3<f64>, Goal) {
    let pose = chain.forward(&conditions.joints);
    let position = pose.apply(&target.map_or(Vector3::zeros(), |t| chain.targets()[t.0].position));
    let goal = Goal::at(position).of(target);
    (position, if chain.movable().len() >= 6 { goal.turned(pose.rotation) } else { goal })
}

/// 3-D RMS of the noise of these rows, m.
pub fn noise_of(seen: &Observation, rows: &[usize]) -> f64 {
    let square = |&row: &usize| (seen.data.measured_position(row) - seen.true_positions[row]).norm_squared();
    (rows.iter().map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt()
}

/// The result of some work, or in words why there is none; a panic is `panic`.
pub fn caught<T>(work: impl FnOnce() -> Outcome<T>) -> Result<T, String> {
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|error| error.to_string()),
        Err(_) => Err("panic".into()),
    }
}

/// Without what would break a row of a table.
pub fn plain(text: &str) -> String {
    text.replace([',', '\n', '\r', '"'], " ")
}
