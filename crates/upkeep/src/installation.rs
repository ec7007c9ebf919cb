//! What an installation consists of: where the base stands, what the tool is, where the targets are.
//!
//! ```text
//! B ← B (exp ω, t)      ∂p = R_B,   −R_B [B⁻¹ p]×        base axes
//! T ← T (exp ω, t)      ∂p = R,     −R [x]×              tool axes
//! x ← x + δ             ∂p = R                           tool axes
//! ```
//!
//! with R the tool's real orientation and x the target from the tool. These are the derivatives of constant generalized errors of base, tool
//! and targets: with the covariance of an installation the model's own columns of these sites carry it.

use crate::UpkeepError;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_errormodel::effects::{AllTargets, Geometric, Where};
use truepose_errormodel::{FittedModel, error_matrix};
use truepose_identify::{IdentifyError, Placement};
use truepose_kinematics::{Axis, Chain, ChainError, Placed, Pose, Site, Target, TargetId, skew};

/// Which parts of an installation are new.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Installation {
    /// Where the base stands in the measurement frame.
    pub base: bool,
    /// The tool.
    pub tool: bool,
    /// The positions of the targets that were measured.
    pub targets: bool,
}

impl Default for Installation {
    fn default() -> Self {
        Installation { base: true, tool: false, targets: false }
    }
}

impl Installation {
    /// Nothing is new.
    pub const SAME: Installation = Installation { base: false, tool: false, targets: false };

    /// The robot with what is new marked as unknown.
    pub(crate) fn unknown(self, chain: &Chain) -> Result<Chain, UpkeepError> {
        if self.tool && chain.tools().len() > 1 {
            let why = "a new tool is found for robots with one tool; this one has several".into();
            return Err(IdentifyError::Placement { what: "tool".into(), why }.into());
        }
        let targets = chain.targets().iter();
        let targets = targets.map(|t| Target { known: !self.targets, ..t.clone() }).collect();
        Ok(chain
            .clone()
            .with_base(Placed { known: !self.base, ..*chain.base() })
            .and_then(|c| c.map_tools(|tool| Placed { known: !self.tool, ..*tool }))
            .and_then(|c| c.with_targets(targets))
            .map_err(described)?)
    }

    /// Sites of what was found, of targets only those in `seen`; the tool where the placement found it, for targets that are all unknown
    /// do not show it. How the tool is turned is a part where orientations are weighed (`oriented`), or targets show it: where its origin
    /// alone is measured it stays as described.
    ///
    /// # Errors
    /// When the data does not determine the placement otherwise.
    pub(crate) fn sites(
        self,
        placed: &Placement,
        seen: &[TargetId],
        oriented: bool,
    ) -> Result<Vec<Site>, UpkeepError> {
        let turn = oriented || !seen.is_empty();
        if let Some(open) = placed.undetermined.iter().find(|open| turn || !open.turn_of_tools_alone) {
            return Err(UpkeepError::Undetermined { what: open.what.clone(), advice: open.advice.clone() });
        }
        let chain = &placed.chain;
        let mut sites = Vec::new();
        let frame = |frame| Axis::ALL.map(|axis| Site::Frame(frame, axis));
        if self.base
            && let Some(base) = chain.frames().next()
        {
            sites.extend(frame(base));
        }
        if self.tool && placed.found.iter().any(|what| what == "tool") {
            let axes: &[Axis] = if turn { &Axis::ALL } else { &Axis::TRANSLATIONS };
            sites.extend(axes.iter().map(|&axis| Site::Frame(chain.tool_frame(), axis)));
        }
        if self.targets {
            for &target in seen {
                sites.extend(Axis::TRANSLATIONS.map(|axis| Site::Target(target, axis)));
            }
        }
        Ok(sites)
    }
}

/// A robot that cannot be.
fn described(error: ChainError) -> IdentifyError {
    IdentifyError::Placement { what: "the installation".into(), why: error.to_string() }
}

/// Derivatives of position (rows 0 to 2) and orientation (rows 3 to 5) of a predicted target with respect to constant errors at these
/// sites, 6 × k; measurement axes, m or rad per m or rad.
pub(crate) fn derivatives(
    chain: &Chain,
    sites: &[Site],
    (tool, point): (&Pose, &Vector3<f64>),
    target: Option<TargetId>,
) -> DMatrix<f64> {
    let base = &chain.base().pose;
    let from_base = base.inverse().apply(point);
    let from_tool = tool.rotation.transpose() * (point - tool.translation);
    let first = chain.frames().next();
    let mut out = DMatrix::zeros(6, sites.len());
    for (k, &site) in sites.iter().enumerate() {
        let (rotation, at) = match site {
            Site::Frame(frame, _) if Some(frame) == first => (base.rotation, from_base),
            Site::Frame(..) => (tool.rotation, from_tool),
            Site::Target(which, _) if Some(which) == target => (tool.rotation, Vector3::zeros()),
            Site::Target(..) => continue,
        };
        let axis = site.axis();
        let turn: Matrix3<f64> = -rotation * skew(&at);
        let number = Axis::ALL.iter().position(|a| *a == axis).unwrap_or(0);
        let direction = number % 3;
        let mut column = out.column_mut(k);
        if axis.is_rotation() {
            column.rows_mut(0, 3).copy_from(&turn.column(direction));
            column.rows_mut(3, 3).copy_from(&rotation.column(direction));
        } else {
            column.rows_mut(0, 3).copy_from(&rotation.column(direction));
        }
    }
    out
}

/// The robot with an installation moved by these small errors at `sites`.
pub(crate) fn moved(chain: &Chain, sites: &[Site], by: &DVector<f64>) -> Result<Chain, UpkeepError> {
    let first = chain.frames().next();
    let (mut base, mut tool) = ([0.0; 6], [0.0; 6]);
    let mut targets = chain.targets().to_vec();
    for (&site, &value) in sites.iter().zip(by.iter()) {
        let number = Axis::ALL.iter().position(|a| *a == site.axis()).unwrap_or(0);
        match site {
            Site::Frame(frame, _) if Some(frame) == first => base[number] = value,
            Site::Frame(..) => tool[number] = value,
            Site::Target(target, _) => targets[target.0].position[number % 3] += value,
        }
    }
    let (at_base, at_tool) = (chain.base(), chain.tool());
    Ok(chain
        .clone()
        .with_base(Placed { pose: (at_base.pose * error_matrix(&base)).renormalised(), ..*at_base })
        .and_then(|c| {
            c.with_tool(Placed { pose: (at_tool.pose * error_matrix(&tool)).renormalised(), ..*at_tool })
        })
        .and_then(|c| c.with_targets(targets))
        .map_err(described)?)
}

/// The fit with a column for each of these sites, and where they are; what it lacks is added, with a coefficient of zero that is known.
pub(crate) fn with_columns(
    fitted: &FittedModel,
    sites: &[Site],
) -> Result<(FittedModel, Vec<usize>), UpkeepError> {
    let place = |fitted: &FittedModel, site: Site| {
        fitted.model().columns().iter().position(|column| column.site == Some(site))
    };
    let mut fitted = fitted.clone();
    let missing: Vec<Site> = sites.iter().copied().filter(|&site| place(&fitted, site).is_none()).collect();
    let mut added: Vec<Where> = Vec::new();
    for site in missing {
        let part = match site {
            Site::Frame(frame, _) => Where::Frame(frame),
            Site::Target(..) => Where::Targets(AllTargets::All),
        };
        if !added.contains(&part) {
            added.push(part);
        }
    }
    if !added.is_empty() {
        let effect = Geometric { frames: Some(added), components: None };
        let model = fitted.model().with(Box::new(effect))?;
        let unknowns = model.columns().len();
        let mut coefficients = fitted.coefficients().to_vec();
        coefficients.resize(unknowns, 0.0);
        let covariance = fitted.covariance().clone().resize(unknowns, unknowns, 0.0);
        fitted = FittedModel::new(model, coefficients, covariance)?
            .with_channels(fitted.channels)
            .with_domain(fitted.domain)
            .with_noise(fitted.noise)
            .with_repeatability(fitted.repeatability_sd)
            .with_fallback(fitted.fallback)
            .with_loads(fitted.loads)
            .with_provenance(fitted.provenance);
    }
    let places = sites.iter().filter_map(|&site| place(&fitted, site)).collect();
    Ok((fitted, places))
}
