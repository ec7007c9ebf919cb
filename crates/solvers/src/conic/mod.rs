//! Bounds, absolute values and Huber's loss, as conic programs on clarabel (feature `clarabel`).
//!
//! minimise ½ ‖r‖² + penalty(u) subject to M u − r = z and cones
//!
//! | problem | added variables | cones |
//! | --- | --- | --- |
//! | bounds | – | u ≤ upper, −u ≤ −lower |
//! | lasso, elastic net | t ≥ \|u\| | 2 p inequalities |
//! | group lasso | g ≥ ‖u_G‖ | one second-order cone a group |
//! | Huber | o, the part of the residual that counts linearly; t ≥ ‖o_g‖ | one second-order cone a visit |
//!
//! The residual r is a variable, so that AᵀA is never formed. Except for Huber, M is the triangle of the rows, not the
//! rows. The interior point ends near the answer, with zeros that are not zero; the active set that it found is then
//! solved by QR until the optimality conditions hold to round-off, and these are measured here, not by clarabel. Source:
//! Goulart and Chen, *Clarabel* (2024).

mod absolute;
mod bounded;
mod box_descent;
mod core;
mod group_lasso;
mod huber;
mod lasso;
mod newton;
mod penalised;
mod program;
mod shifted;

pub use bounded::Bounded;
pub use group_lasso::{GroupLasso, group_lasso_path};
pub use huber::ExactHuber;
pub use lasso::{ElasticNet, Lasso, elastic_net_path, lasso_path};
pub use penalised::Strength;
