//! Rows of one standstill share a lane until the robot is at rest: what several targets see of it is worked out once.
//!
//! | what | one a |
//! | --- | --- |
//! | conditions, Φ, ε, frames, weights while the robot comes to rest | standstill |
//! | the same from then on, levers, measurements | row |

use super::width::LANES;

/// The standstills of a block.
#[derive(Debug, Clone, Default)]
pub(crate) struct Standing {
    /// The first row of each.
    pub rows: Vec<usize>,
    /// The standstill of each lane: never beyond the lane itself.
    seats: Vec<u8>,
}

// A seat is a lane.
const _: () = assert!(LANES <= 1 << u8::BITS);

impl Standing {
    /// Rows that follow one another under the same conditions share a lane, where that spares a quarter of the lanes.
    pub fn gather(&mut self, rows: &[usize], same_conditions: impl Fn(usize, usize) -> bool) {
        self.rows.clear();
        self.seats.clear();
        for (lane, &row) in rows.iter().enumerate() {
            if lane == 0 || !same_conditions(rows[lane - 1], row) {
                self.rows.push(row);
            }
            self.seats.push((self.rows.len() - 1) as u8);
        }
        if 4 * self.rows.len() > 3 * rows.len() {
            self.rows.clear();
            self.rows.extend_from_slice(rows);
            self.seats.clear();
        }
    }

    /// Whether some lanes share a standstill.
    pub fn shared(&self) -> bool {
        !self.seats.is_empty()
    }

    /// Gives every lane the numbers of its standstill, in each of these rows of `LANES` numbers.
    pub fn spread(&self, numbers: &mut [f64]) {
        let (blocks, _) = numbers.as_chunks_mut::<LANES>();
        for block in blocks {
            for (lane, &seat) in self.seats.iter().enumerate().rev() {
                block[lane % LANES] = block[usize::from(seat) % LANES];
            }
        }
    }
}
