//! The library of effects: one file each.
//!
//! | what errs | effects |
//! | --- | --- |
//! | where things are | [`Geometric`] |
//! | what yields under load | [`JointCompliance`], [`LinkCompliance`], [`BaseCompliance`], [`LoadNonlinearity`] |
//! | what a joint does beyond what it reports | [`Transmission`], [`Backlash`], [`Coupling`], [`Guideway`] |
//! | what changes with time and temperature | [`Thermal`], [`Drift`], [`Shift`] |
//! | the surroundings | [`Landmarks`], [`Observed`] |
//! | another installation | [`Session`] |
//! | what the measurement adds | [`Instrument`] |
//! | what is only data | [`Expansion`], [`Polynomial`] |

mod geometric;

mod base_compliance;
mod joint_compliance;
mod link_compliance;
mod load_nonlinearity;
mod observed;

mod backlash;
mod coupling;
mod guideway;
mod transmission;

mod drift;
mod shift;
mod thermal;

mod landmarks;
mod robot_size;
mod session;

mod instrument;

mod expansion;
mod polynomial;

// Parts that several of them share.
mod checks;
mod free_weight;
mod spot;
mod travel;

pub use backlash::{Backlash, Side};
pub use base_compliance::{BaseCompliance, Tilt};
pub use coupling::{Coupling, CouplingMode};
pub use drift::Drift;
pub use expansion::{Basis, Expansion, Factor, Input, Place};
pub use geometric::{AllTargets, Geometric, Where};
pub use guideway::Guideway;
pub use instrument::{Instrument, InstrumentMode};
pub use joint_compliance::{ComplianceMode, JointCompliance};
pub use landmarks::{Landmarks, Point, Tied};
pub use link_compliance::{LinkCompliance, OwnWeight, Section};
pub use load_nonlinearity::LoadNonlinearity;
pub use observed::{Observed, Sensor, Unknown};
pub use polynomial::{GroupedError, Order, Polynomial, WrenchComponent, WrenchOf};
pub use session::{Own, Session};
pub use shift::Shift;
pub use spot::Spot;
pub use thermal::{Grows, Thermal};
pub use transmission::{Transmission, TransmissionMode};
