//! Robustness as composition: any solver, run repeatedly with the weights of suspicious visits lowered (iteratively reweighted least squares).
//!
//! u_g = ‖W^{1/2} (A x − y)‖_g / √n_g,  w_g = ψ(u_g / σ̂) / (u_g / σ̂),  solve with W · w, repeat
//!
//! | symbol | name | shape | unit |
//! | --- | --- | --- | --- |
//! | u_g | root mean square residual of a visit (group of rows) | visits | 1 when whitened |
//! | n_g | rows of the visit that have a weight | visits | 1 |
//! | σ̂ | robust scale of u | 1 | that of u |
//! | w_g | factor on the weights of that visit's rows | visits | 1 |
//!
//! Source: Huber and Ronchetti, *Robust Statistics* (2009), ch. 7; Maronna, Martin, Yohai and Salibián-Barrera, *Robust
//! Statistics* (2019), §5. The scale is re-estimated in the first iterations and then fixed, so that the
//! iterations converge.
//!
//! Weights cost efficiency where no visit is wrong, and a loss that descends may end in a minimum that leaves good visits out. So the robust fit
//! is taken only where the visits are contaminated and it predicts those that it did not see better than the plain fit does: `best` in
//! `visits`. Whole visits are weighted because a bad visit (a bumped target, a wrong pose) spoils all of its rows.

mod composed;
mod contamination;
mod left_out;
mod loss;
mod scale;
mod trimmed;
mod visits;

pub use composed::{Robust, Start};
pub use loss::Loss;
pub use trimmed::Trimming;
