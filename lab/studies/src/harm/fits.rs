//! The fits of one robot, and what became of a verb that makes one.

use super::record::Record;
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use truepose_errormodel::FittedModel;

/// Fits of one robot, as far as there are any.
pub struct Fits {
    pub nominal: Option<FittedModel>,
    pub constants: Option<FittedModel>,
    pub discover: Option<FittedModel>,
}

/// What a verb answers; a refusal and a panic are noted.
pub fn attempt<T>(
    record: &mut Record,
    verb: &str,
    work: impl FnOnce() -> Result<T, Box<dyn Error>>,
) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(answer)) => Some(answer),
        Ok(Err(error)) => {
            record.refuse(verb, &error.to_string());
            None
        }
        Err(_) => {
            record.refuse(verb, "panic");
            None
        }
    }
}
