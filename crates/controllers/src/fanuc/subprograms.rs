//! What the other programs of a controller do where they are called.

use super::settings::{Selected, Setting, WHAT, setting};
use super::statements::{called, jumps, statements};
use crate::lines::lines;
use crate::reference::Reference;
use std::collections::BTreeMap;

/// Further programs by their names.
#[derive(Debug, Default)]
pub(super) struct Subprograms(BTreeMap<String, Subprogram>);

/// A program's selections and calls, in their order.
#[derive(Debug)]
struct Subprogram {
    steps: Vec<Step>,
    /// Whether lines are left out or run in another order.
    jumps: bool,
}

#[derive(Debug)]
enum Step {
    Set(usize, Reference),
    Call(String),
}

/// What a call leaves selected; none: what was.
type Left = [Option<Reference>; 3];

/// Of a program that is not given.
const MAY: &str = "may change";

/// Calls in calls, at most.
const DEEPEST: usize = 32;

impl Subprograms {
    pub(super) fn of<'t>(texts: impl Iterator<Item = &'t [u8]>) -> Subprograms {
        let mut all = Subprograms::default();
        for text in texts {
            let lines = lines(text);
            let name = lines.iter().find_map(|line| line.after("/PROG"));
            let name = String::from_utf8_lossy(name.unwrap_or_default());
            let Some(name) = name.split_whitespace().next().map(str::to_uppercase) else { continue };
            let mut found = Subprogram { steps: Vec::new(), jumps: false };
            for (text, line) in statements(&lines) {
                if let Some(Setting::To(which, to)) = setting(&text, line) {
                    found.steps.push(Step::Set(which, to));
                }
                found.jumps |= jumps(&text);
                found.steps.extend(called(&text).into_iter().map(Step::Call));
            }
            all.0.insert(name, found);
        }
        all
    }

    /// Changes what is selected as a call in a line does.
    pub(super) fn call(&self, name: &str, line: usize, selected: &mut Selected) {
        let unknown = |which: usize, words: &str| {
            let remedy = if words == MAY { " (--with the program that is called)" } else { "" };
            Reference::Unknown(format!(
                "{name} is called in line {line}, which {words} {}{remedy}",
                WHAT[which]
            ))
        };
        for (which, left) in self.left(name, 0).into_iter().enumerate() {
            match left {
                None => {}
                Some(Reference::Unknown(words)) => selected[which] = unknown(which, &words),
                Some(known) => selected[which] = known,
            }
        }
    }

    fn left(&self, name: &str, depth: usize) -> Left {
        let may = |words: &str| [0, 1, 2].map(|_| Some(Reference::Unknown(words.into())));
        let Some(program) = self.0.get(name).filter(|_| depth < DEEPEST) else {
            return may(MAY);
        };
        let mut left: Left = [None, None, None];
        for step in &program.steps {
            match step {
                Step::Set(which, to) => {
                    let open = matches!(to, Reference::Unknown(_));
                    left[*which] = Some(if open { Reference::Unknown("changes".into()) } else { to.clone() });
                }
                Step::Call(other) => {
                    for (mine, other) in left.iter_mut().zip(self.left(other, depth + 1)) {
                        *mine = other.or(mine.take());
                    }
                }
            }
        }
        if program.jumps {
            let open = |to: &&mut Reference| **to != Reference::Unknown(MAY.into());
            left.iter_mut().flatten().filter(open).for_each(|to| *to = Reference::Unknown("changes".into()));
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_call_leaves_what_the_last_statement_of_it_selects() {
        let texts = [
            "/PROG  INIT\n/MN\n 1:  UFRAME_NUM=2 ;\n 2:  CALL TOOLS ;\n/POS\n/END\n",
            "/PROG  TOOLS\n/MN\n 1:  UTOOL_NUM=1 ;\n 2:  UTOOL_NUM=3 ;\n/POS\n/END\n",
            "/PROG  MAYBE\n/MN\n 1:  IF R[1]=1,JMP LBL[1] ;\n 2:  PAYLOAD[2] ;\n 3:  LBL[1] ;\n/POS\n/END\n",
            "/PROG  RING\n/MN\n 1:  CALL RING ;\n/POS\n/END\n",
        ];
        let all = Subprograms::of(texts.iter().map(|text| text.as_bytes()));
        let before = || [0, 1, 2].map(|k| Reference::Named(format!("old {k}")));
        let after = |name: &str| {
            let mut selected = before();
            all.call(name, 9, &mut selected);
            selected
        };
        let [frame, tool, load] = after("INIT");
        assert_eq!((frame.words(), tool.words(), load.words()), ("UF2".into(), "UT3".into(), "old 2".into()));
        let [frame, tool, load] = after("MAYBE");
        assert_eq!((frame.words(), tool.words()), ("old 0".into(), "old 1".into()));
        assert_eq!(load, Reference::Unknown("MAYBE is called in line 9, which changes PAYLOAD".into()));
        for open in ["NOWHERE", "RING"] {
            assert!(after(open).iter().all(|one| matches!(one, Reference::Unknown(_))), "{open}");
        }
    }
}
