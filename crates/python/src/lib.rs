#![doc = include_str!("../README.md")]

mod acceptance;
mod accumulate;
mod arrays;
mod arrow;
mod check;
mod compare;
mod data;
mod discover;
mod effect;
mod error;
mod files;
mod fit;
mod hypothesis;
mod identify;
mod inputs;
mod log;
mod model;
mod options;
mod packed;
mod page;
mod plan;
mod postures;
mod predicted;
mod program;
mod rewrite;
mod robot;
mod run;
mod search;
mod simulate;
mod streamed;
mod table;
mod texts;
mod upkeep;

use pyo3::prelude::*;

/// The compiled part of the package `truepose`; private: its functions are called by the package, which documents what there is to call.
#[pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::acceptance::{Acceptance, iso9283};
    #[pymodule_export]
    use crate::accumulate::Accumulator;
    #[pymodule_export]
    use crate::arrow::arrow_stream;
    #[pymodule_export]
    use crate::check::check;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::data::{Data, read_data, take_data};
    #[pymodule_export]
    use crate::discover::Discovery;
    #[pymodule_export]
    use crate::error::InputError;
    #[pymodule_export]
    use crate::files::write_text;
    #[pymodule_export]
    use crate::fit::Fit;
    #[pymodule_export]
    use crate::identify::identify;
    #[pymodule_export]
    use crate::log::standstills;
    #[pymodule_export]
    use crate::model::families;
    #[pymodule_export]
    use crate::plan::{plan, plan_observed};
    #[pymodule_export]
    use crate::program::run;
    #[pymodule_export]
    use crate::rewrite::rewrite;
    #[pymodule_export]
    use crate::robot::Robot;
    #[pymodule_export]
    use crate::search::Search;
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::streamed::{Streaming, take_block};
    #[pymodule_export]
    use crate::table::{Table, read_table};
    #[pymodule_export]
    use crate::upkeep::{fleet, identify_sister, monitor, monitoring, transfer};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::error::complete(module.py())
    }
}
