//! Many commands: those that can be computed side by side are, and the answers are the same as one after the other.

use super::Compensator;
use crate::command::{Command, Status, Wanted};
use crate::lanes::{Block, WIDTH};
use crate::options::Approach;
use crate::search::Walk;

impl Compensator<'_> {
    /// Commands for many desired poses, in their order, appended to `out`: what [`Compensator::command`] answers to each of
    /// them, to the last bit, in less time where the model allows it. Allocates only where `out` has no room.
    pub fn commands(&mut self, wanted: &[Wanted<'_>], out: &mut Vec<Command>) {
        for block in wanted.chunks(WIDTH) {
            let found = self.together(block);
            for (one, found) in block.iter().zip(found) {
                out.push(match found {
                    Some(walk) => {
                        self.take_over(one.conditions);
                        self.answer(one.target.orientation.is_some(), &walk, Status::Ok, walk.rounds, true)
                    }
                    None => self.command(&one.target, one.conditions, one.seed),
                });
            }
        }
    }

    /// The straight ways of those that have one.
    fn together(&mut self, wanted: &[Wanted<'_>]) -> [Option<Walk>; WIDTH] {
        let mut found = [None; WIDTH];
        if self.kernel.is_none() || self.options.approach != Approach::Stated {
            return found;
        }
        let mut block = Block::empty();
        let mut lanes = [None; WIDTH];
        for (one, lane) in wanted.iter().zip(&mut lanes) {
            let Some(seed) = one.seed else { continue };
            let Some(task) = self.enter(&one.target, one.conditions, one.seed) else { continue };
            let point = self.real.still_point(task.target);
            *lane = block.push(&task, &point, &self.conditions.load, &self.seed(seed));
        }
        if let Some(kernel) = &self.kernel {
            kernel.walk(&mut block);
        }
        for (found, lane) in found.iter_mut().zip(lanes) {
            *found = lane.and_then(|lane| block.found(lane));
        }
        found
    }
}
