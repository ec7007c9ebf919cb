//! What the other programs of a controller do where they are called.

use super::statements::{PAYLOADS, called, statements};
use crate::lines::lines;
use std::collections::BTreeMap;

/// Further programs by their names.
#[derive(Debug, Default)]
pub(super) struct Subprograms(BTreeMap<String, Subprogram>);

#[derive(Debug)]
struct Subprogram {
    /// Whether it selects a payload.
    payload: bool,
    calls: Vec<String>,
}

impl Subprograms {
    pub(super) fn of<'t>(texts: impl Iterator<Item = &'t [u8]>) -> Subprograms {
        let mut all = Subprograms::default();
        for text in texts {
            let lines = lines(text);
            let name = lines.iter().find_map(|line| line.after("/PROG"));
            let name = String::from_utf8_lossy(name.unwrap_or_default());
            let Some(name) = name.split_whitespace().next().map(str::to_uppercase) else { continue };
            let statements = statements(&lines);
            let payload = |(text, _): &(String, usize)| PAYLOADS.iter().any(|word| text.starts_with(word));
            let found = Subprogram {
                payload: statements.iter().any(payload),
                calls: statements.iter().flat_map(|(text, _)| called(text)).collect(),
            };
            all.0.insert(name, found);
        }
        all
    }

    /// How a called program may change the payload, in words; none: it keeps it.
    pub(super) fn payload(&self, name: &str) -> Option<&'static str> {
        let mut seen: Vec<&str> = vec![name];
        let mut at = 0;
        while let Some(name) = seen.get(at).copied() {
            let Some(program) = self.0.get(name) else {
                return Some("which may change PAYLOAD (--with the program that is called)");
            };
            if program.payload {
                return Some("which changes PAYLOAD");
            }
            seen.extend(
                program
                    .calls
                    .iter()
                    .map(String::as_str)
                    .filter(|call| !seen.contains(call))
                    .collect::<Vec<_>>(),
            );
            at += 1;
        }
        None
    }
}
