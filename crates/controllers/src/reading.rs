//! Reading a program in any language.

use crate::dialect::URP;
use crate::{ControllerError, Dialect, Program};
use crate::{fanuc, inform, krl, rapid, urscript, val3};

impl Program {
    /// Reads the files of one program, each with all others: the points of each, and what they use.
    ///
    /// # Errors
    /// As [`Program::read`], with the place of the file.
    pub fn read_all(texts: &[&[u8]], dialect: Dialect) -> Result<Vec<Program>, (usize, ControllerError)> {
        // Each alone first, so that an error has the place of its own file.
        for (k, text) in texts.iter().enumerate() {
            Program::read(text, &[], dialect).map_err(|error| (k, error))?;
        }
        let one = |(k, text): (usize, &&[u8])| {
            let others: Vec<&[u8]> =
                texts.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, text)| *text).collect();
            Program::read(text, &others, dialect).map_err(|error| (k, error))
        };
        texts.iter().enumerate().map(one).collect()
    }

    /// Reads a program; `others` are further files with what it uses: declarations, frames, motions.
    ///
    /// # Errors
    /// When the text breaks the grammar of its language's point statements, or is something else.
    pub fn read(text: &[u8], others: &[&[u8]], dialect: Dialect) -> Result<Program, ControllerError> {
        for text in std::iter::once(&text).chain(others) {
            if text.starts_with(&[0x1f, 0x8b]) {
                return Err(ControllerError::NotAProgram(URP.into()));
            }
            if text.contains(&0) {
                return Err(ControllerError::NotAProgram(
                    "it has bytes of value 0: it is binary or UTF-16; save it as text in UTF-8 or the controller's code page".into(),
                ));
            }
        }
        match dialect {
            Dialect::Krl => krl::read(text, others),
            Dialect::Rapid => rapid::read(text, others),
            Dialect::Fanuc => fanuc::read(text, others),
            Dialect::UrScript => urscript::read(text, others),
            Dialect::Inform => inform::read(text, others),
            Dialect::Val3 => val3::read(text, others),
        }
    }
}
