//! Many commands: those that can be computed side by side are, and the answers are the same as one after the other.

use super::Compensator;
use crate::command::{Command, CommandRequest, Status};
use crate::lanes::{Block, WIDTH};
use crate::options::Approach;

impl Compensator<'_> {
    /// Commands for many desired poses, in their order, appended to `out`: what [`Compensator::command`] answers to each of
    /// them, to the last bit, in less time where the model allows it. Allocates only where `out` has no room.
    pub fn commands(&mut self, wanted: &[CommandRequest<'_>], out: &mut Vec<Command>) {
        for some in wanted.chunks(WIDTH) {
            let (block, lanes) = self.together(some);
            for (one, lane) in some.iter().zip(lanes) {
                let found = lane.and_then(|lane| block.found(lane));
                out.push(match found.filter(|walk| self.fits(&walk.x)) {
                    Some(walk) => {
                        self.take_over(one.conditions);
                        let oriented = one.target.orientation.is_some();
                        let found = self.answer(oriented, &walk, Status::Ok, walk.rounds, true);
                        match &mut self.beyond {
                            Some(beyond) => beyond.fallen_back(found, &one.target, one.conditions),
                            None => found,
                        }
                    }
                    None => self.command(&one.target, one.conditions, one.seed),
                });
            }
        }
    }

    /// The requests that can be solved in a batch, and their places in the block.
    fn together(&mut self, wanted: &[CommandRequest<'_>]) -> (Block, [Option<usize>; WIDTH]) {
        let (mut block, mut lanes) = (Block::empty(), [None; WIDTH]);
        if self.kernel.is_none() || self.options.approach != Approach::Stated {
            return (block, lanes);
        }
        for (one, lane) in wanted.iter().zip(&mut lanes) {
            let Some(seed) = one.seed else { continue };
            let Some(task) = self.enter(&one.target, one.conditions, one.seed) else { continue };
            let point = self.real.still_point(task.target);
            *lane = block.push(&task, &point, &self.conditions.load, &self.seed(seed));
        }
        if let Some(kernel) = &self.kernel {
            kernel.walk(&mut block);
        }
        (block, lanes)
    }
}
