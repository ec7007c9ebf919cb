//! How well the constants of an export are known: the covariance of the fit, through the projection.
//!
//! ```text
//! ε = argmin Σ_i w |p_i(c) − p_i(ε)|² + |(ε − S c)/3s|²        D = S + (Jᵀ W J + (3s)⁻²)⁻¹ Jᵀ W (J_c − J S)        cov ε = D C Dᵀ
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | S | constants of the fit itself | sites × p | m or rad per unit of a coefficient |
//! | J | how rows move with the constants | 3 or 6 × sites | m, rad |
//! | J_c | how the whole model moves with its coefficients | 3 or 6 × p | m, rad |
//! | w | one over the mean square that the projection leaves | | 1/m², 1/rad² |
//! | s | expected sizes, as in the projection | sites | m, rad |
//!
//! The weight w follows what is left, too: 2/m w² (Jᵀr)(Jᵀr)ᵀ is taken off the matrix, and the same of J_c off the right side (r: what is left, m: its
//! components). Without other effects the projection is not made, and D = S. Directions that the configurations do not fix stay where the fit has them.

use super::super::project::{WIDE, scales};
use super::super::reference::Reference;
use crate::CompensateError;
use nalgebra::{DMatrix, DVector, Vector3};
use truepose_errormodel::{Emission, ErrorJacobian, FittedModel, GeneralizedErrors, RealPosture};
use truepose_kinematics::{Conditions, PostureBuffer, Site, rotation_log};

/// What is left below this, m and rad, is below the resolution of any instrument.
const NEGLIGIBLE: f64 = 1e-6;

/// D: how the constants of every site move with the coefficients.
pub(super) fn sensitivity(
    fitted: &FittedModel,
    reference: &Reference,
    constants: &GeneralizedErrors,
    projected: bool,
) -> Result<DMatrix<f64>, CompensateError> {
    let chain = fitted.chain();
    let sites: Vec<Site> = (0..chain.site_count()).map(|k| chain.site_at(k)).collect();
    let own = own(fitted);
    if !projected {
        return Ok(own);
    }
    let scale = DVector::from_vec(scales(chain, &sites, 0));
    let (schema, _) = crate::accuracy::everything(fitted, &super::super::options::middle_conditions(fitted))?;
    let sample = &fitted.domain.sample;
    let schema = if reference.drawn_from.is_some() { sample.rows().schema.clone() } else { schema };
    let mut predictor = fitted.bind(&schema)?;
    let (mut buffer, mut real) = (PostureBuffer::new(chain), RealPosture::new(chain));
    let n = sites.len();
    let mut gram = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
    let mut pull = [DMatrix::zeros(n, own.ncols()), DMatrix::zeros(n, own.ncols())];
    let (mut slope, mut along) =
        ([DVector::zeros(n), DVector::zeros(n)], [DVector::zeros(own.ncols()), DVector::zeros(own.ncols())]);
    let mut squares = [0.0; 2];
    for row in &reference.rows {
        let nominal = buffer.update(chain, &row.conditions);
        real.update(&nominal, constants);
        let jacobian = ErrorJacobian::new(chain, &real, constants, row.target);
        let whole = predictor.sensitivity(&row.conditions, row.target);
        let left: [Vector3<f64>; 2] = [
            row.point - jacobian.point(),
            rotation_log(&(row.tool.rotation * real.tool().rotation.transpose())),
        ];
        for part in 0..if reference.turned { 2 } else { 1 } {
            let of = |site: Site| if part == 0 { jacobian.position(site) } else { jacobian.rotation(site) };
            let mut rows = DMatrix::zeros(3, n);
            for (k, &site) in sites.iter().enumerate() {
                rows.set_column(k, &(of(site) * scale[k]));
            }
            let mut more = whole.rows(3 * part, 3).into_owned();
            let unscaled = DMatrix::from_fn(3, n, |a, k| rows[(a, k)] / scale[k]);
            more -= unscaled * &own;
            gram[part].gemm_tr(1.0, &rows, &rows, 1.0);
            pull[part].gemm_tr(1.0, &rows, &more, 1.0);
            slope[part].gemv_tr(1.0, &rows, &left[part], 1.0);
            along[part].gemv_tr(1.0, &more, &left[part], 1.0);
            squares[part] += left[part].norm_squared();
        }
    }
    let count = 3.0 * reference.rows.len().max(1) as f64;
    let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, own.ncols()));
    for part in 0..if reference.turned { 2 } else { 1 } {
        let weight = 1.0 / (squares[part] / count).max(NEGLIGIBLE * NEGLIGIBLE);
        // The weight itself follows what is left.
        let (slope, along) = (&slope[part] * weight, &along[part] * weight);
        a += &gram[part] * weight - &slope * slope.transpose() * (2.0 / count);
        b += &pull[part] * weight - &slope * along.transpose() * (2.0 / count);
    }
    let held = a + DMatrix::identity(n, n) / (WIDE * WIDE);
    // Not a Cholesky factor: what is taken off may leave it indefinite.
    let mut moved = held.lu().solve(&b).ok_or(CompensateError::NotInRows)?;
    for (k, scale) in scale.iter().enumerate() {
        moved.row_mut(k).scale_mut(*scale);
    }
    Ok(own + moved)
}

/// S: the constants of the fit itself, as `constant_errors` adds them up.
fn own(fitted: &FittedModel) -> DMatrix<f64> {
    let (model, chain) = (fitted.model(), fitted.chain());
    let mut own = DMatrix::zeros(chain.site_count(), fitted.coefficients().len());
    let conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]);
    let mut buffer = PostureBuffer::new(chain);
    let posture = buffer.update(chain, &conditions);
    let mut emission = Emission::new();
    for (k, effect) in model.effects().iter().enumerate() {
        let columns = model.columns_of(k);
        if model.columns()[columns.clone()].iter().all(|c| c.site.is_some()) {
            emission.clear();
            effect.eval(&posture, &mut emission);
            for entry in emission.entries() {
                own[(chain.site_index(entry.site), columns.start + entry.column)] += entry.value;
            }
        }
    }
    own
}
