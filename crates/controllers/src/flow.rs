//! Steps of a file, and which frame, tool and load are active at each, read line by line.
//!
//! A frame that is set inside a branch or a loop is known until the block ends. Behind the block, and in a loop in front of the statement
//! that sets it, it is known only where every way through the block leaves the same one.

use crate::event::{Event, Visit};
use crate::note::Note;
use crate::reference::Reference;

/// Frame, tool and load.
pub(crate) type Active = [Reference; 3];

/// The frame's place in [`Active`].
pub(crate) const FRAME: usize = 0;
/// The tool's.
pub(crate) const TOOL: usize = 1;
/// The load's.
pub(crate) const LOAD: usize = 2;
/// All three.
const ALL: [usize; 3] = [FRAME, TOOL, LOAD];

/// None of the three is known, for this reason.
pub(crate) fn unknown(why: &str) -> Active {
    ALL.map(|_| Reference::Unknown(why.into()))
}

#[derive(Debug, Clone)]
pub(crate) struct Flow {
    active: Active,
    blocks: Vec<Block>,
    /// What was active at each motion.
    pub(crate) uses: Vec<Active>,
}

/// Where a routine stands inside of another one.
#[derive(Debug, Clone)]
pub(crate) struct Outer {
    active: Active,
    blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
struct Block {
    opened: Active,
    exits: Vec<Active>,
    loops: bool,
    /// Motions from this one on are in the block.
    from: usize,
    /// The first motion behind the first change of each.
    changed: [Option<usize>; 3],
}

impl Flow {
    pub(crate) fn new(why: &str) -> Flow {
        Flow { active: unknown(why), blocks: Vec::new(), uses: Vec::new() }
    }

    /// A routine inside of another one begins, with this active; for [`Flow::leave`], what was before.
    pub(crate) fn enter(&mut self, active: Active) -> Outer {
        let blocks = std::mem::take(&mut self.blocks);
        Outer { active: std::mem::replace(&mut self.active, active), blocks }
    }

    /// What is active here, for [`Flow::leave`].
    pub(crate) fn save(&self) -> Outer {
        Outer { active: self.active.clone(), blocks: self.blocks.clone() }
    }

    /// A routine inside of another one ends.
    pub(crate) fn leave(&mut self, outer: Outer) {
        self.active = outer.active;
        self.blocks = outer.blocks;
    }

    /// Begins another routine, with this active.
    pub(crate) fn restart(&mut self, active: Active) {
        self.active = active;
        self.blocks.clear();
    }

    pub(crate) fn set(&mut self, which: usize, to: Reference) {
        let at = self.uses.len();
        self.blocks.iter_mut().for_each(|block| {
            block.changed[which].get_or_insert(at);
        });
        self.active[which] = to;
    }

    /// A motion: the number of its use.
    pub(crate) fn motion(&mut self) -> usize {
        self.uses.push(self.active.clone());
        self.uses.len() - 1
    }

    pub(crate) fn open(&mut self, loops: bool) {
        self.blocks.push(Block {
            opened: self.active.clone(),
            exits: Vec::new(),
            loops,
            from: self.uses.len(),
            changed: [None; 3],
        });
    }

    /// Another branch of the innermost block begins.
    pub(crate) fn branch(&mut self) {
        if let Some(block) = self.blocks.last_mut() {
            block.exits.push(std::mem::replace(&mut self.active, block.opened.clone()));
        }
    }

    pub(crate) fn close(&mut self) {
        let Some(block) = self.blocks.pop() else { return };
        for which in ALL {
            let same =
                block.exits.iter().chain([&self.active]).all(|exit| exit[which] == block.opened[which]);
            if same {
                self.active[which] = block.opened[which].clone();
                continue;
            }
            let words = "it is set in a branch or a loop, and the program may come here without it";
            let unknown = Reference::Unknown(words.into());
            self.active[which] = unknown.clone();
            if block.loops {
                let until = block.changed[which].unwrap_or(self.uses.len());
                self.uses[block.from..until].iter_mut().for_each(|active| active[which] = unknown.clone());
            }
        }
    }
}

/// The one frame, tool and load of all uses of a point.
pub(crate) fn of_all<'a>(uses: impl Iterator<Item = &'a Active>, none: &Active) -> Active {
    let mut all: Option<Active> = None;
    for active in uses {
        let Some(seen) = &mut all else {
            all = Some(active.clone());
            continue;
        };
        for which in ALL {
            if matches!(active[which], Reference::Excluded(_)) {
                seen[which] = active[which].clone();
            }
            let settled = matches!(seen[which], Reference::Unknown(_) | Reference::Excluded(_));
            if seen[which] != active[which] && !settled {
                let words =
                    format!("it is used with {} and with {}", seen[which].words(), active[which].words());
                seen[which] = Reference::Unknown(words);
            }
        }
    }
    all.unwrap_or_else(|| none.clone())
}

/// What happens in a file before its points are known.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    /// A motion, by its number.
    Motion(usize),
    Begin(String),
    End,
    Call(String),
    Control {
        linear: bool,
        followed: bool,
    },
    /// The robot moves without a destination.
    Away {
        linear: bool,
        line: usize,
    },
}

impl Step {
    /// What happens, with the visits of each motion.
    pub(crate) fn events(&self, visits: impl FnOnce(usize) -> Vec<Event>) -> Vec<Event> {
        vec![match self {
            Step::Motion(number) => return visits(*number),
            Step::Begin(name) => Event::Begin(name.clone()),
            Step::End => Event::End,
            Step::Call(name) => Event::Call(name.clone()),
            Step::Control { linear, followed } => Event::Control { linear: *linear, followed: *followed },
            Step::Away { linear, line } => Visit::event(Vec::new(), *linear, *line),
        }]
    }
}

/// A motion without its destinations.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    /// From 1.
    pub(crate) line: usize,
    /// As written.
    pub(crate) shown: String,
    /// Along a line or an arc.
    pub(crate) linear: bool,
    /// Why it is not understood.
    pub(crate) odd: Option<String>,
}

impl Head {
    /// Of a motion in this file that stands against the program.
    pub(crate) fn refusing(&self, file: usize, words: &str) -> Note {
        Note { file, ..Note::refusing(self.line, self.shown.clone(), words.into()) }
    }

    /// Of a motion to a point without a value.
    pub(crate) fn missing(&self, file: usize, point: &str) -> Note {
        Note { file, ..Note::missing(self.line, self.shown.clone(), point.into()) }
    }
}
