#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod assess;
mod attained;
mod best_fit;
mod budget;
mod characteristics;
mod compliance;
mod cube;
mod distance;
mod drift;
mod error;
mod figure;
mod guard_band;
mod model_budget;
mod multi_direction;
mod path;
mod pose;
mod remark;
mod scatter;

pub use assess::{Assessment, AssessmentOptions, assess};
pub use attained::{Alignment, Attained, Cycle, TestPose, attained};
pub use best_fit::best_fit;
pub use budget::{Budget, Contribution, Evaluation};
pub use characteristics::{Characteristics, NamedFigures};
pub use compliance::{Compliance, compliance};
pub use cube::{IsoCube, IsoPose, TestCube, test_cube};
pub use distance::{DistanceFigures, distance_figures};
pub use drift::{BLOCK, DriftFigures, drift_figures};
pub use error::AcceptanceError;
pub use figure::{Figure, Method};
pub use guard_band::{Conformity, GuardBand, one_sided_factor};
pub use multi_direction::{MultiDirection, multi_direction};
pub use path::{PathFigures, path_figures};
pub use pose::{PoseFigures, pose_figures};
pub use remark::Remark;
