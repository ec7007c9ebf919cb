//! What a workload is: what the peers' script calls it, who does it there, and the ways in which we do it.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

/// What went wrong.
pub type Failure = Box<dyn Error>;

/// A result, or what went wrong.
pub type Outcome<T = ()> = Result<T, Failure>;

/// Numbers of an answer by name: `rank`, `rms_fit_um`, …
pub type Answer = BTreeMap<String, f64>;

/// One way of doing a workload.
pub struct Way {
    /// Does the work once.
    pub run: Box<dyn FnMut() -> Outcome>,
    /// What came of the last run: under the names that the peers use, so that both can be held against each other.
    pub check: Box<dyn FnMut() -> Outcome<Answer>>,
}

/// A way, before its data has been read.
#[derive(Clone, Copy)]
pub struct Declared {
    /// `gram`, `stable`, …
    pub name: &'static str,
    /// Peers that it is held against, and the share of their time that is asked for; the strongest decides.
    pub asked: &'static [(&'static str, f64)],
    /// Reads the data and makes ready; the folder is that of the peers' data.
    pub prepare: fn(&Path) -> Outcome<Way>,
}

/// A workload.
#[derive(Clone, Copy)]
pub struct Workload {
    /// As in the peers' script: `W1`, `W3-200k`, …
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Floating-point operations of the dense way, and bytes that any way has to move: who leaves zeros out can be above 100 % of it.
    pub bound: [f64; 2],
    /// Numbers of the answer that have to agree, and to how many digits.
    pub agree: &'static [(&'static str, i32)],
    /// Our ways.
    pub ways: &'static [Declared],
}

impl Declared {
    /// A way with its peers.
    pub const fn of(
        name: &'static str,
        asked: &'static [(&'static str, f64)],
        prepare: fn(&Path) -> Outcome<Way>,
    ) -> Self {
        Declared { name, asked, prepare }
    }
}

impl Workload {
    /// A workload with its bound: operations and bytes.
    pub const fn of(
        name: &'static str,
        about: &'static str,
        bound: [f64; 2],
        agree: &'static [(&'static str, i32)],
        ways: &'static [Declared],
    ) -> Self {
        Workload { name, about, bound, agree, ways }
    }
}
