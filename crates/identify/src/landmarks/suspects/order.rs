//! Would the visits in any other order show as much of a change?
//!
//! ```text
//! e(S) = g_Sᵀ G_S⁻¹ g_S,   g_S = Σ_{i ∈ S} A_iᵀ r_i,   G_S = Σ_{i ∈ S} A_iᵀ A_i − D_Sᵀ C D_S,   D_S = Σ_{i ∈ S} X_iᵀ A_i
//! p = (1 + number of orders with max_S e(S) as large) / (1 + number of orders)
//! ```
//!
//! | symbol | here |
//! | --- | --- |
//! | S | the visits from some one on, in the order that is asked for |
//! | A_i, X_i, r_i | what is tested, the design matrix and the residual at visit i |
//!
//! A test of numbers one by one takes them for independent. What a model of the arm lacks moves all numbers of a visit together, and a few visits
//! at which it is large, early or late by chance, look like something that moved. The order of the visits means nothing to
//! the arm: shuffled, they show what chance does (Fisher 1935; Good 2005, ch. 3). Of what follows from the order itself, wear or warming up, this
//! says nothing.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Orders that are tried, and how many of them may show as much.
const ORDERS: usize = 499;
const AS_MUCH: usize = 1;

/// What each visit adds to a test.
struct Part {
    g: DVector<f64>,
    own: DMatrix<f64>,
    across: DMatrix<f64>,
}

/// Some numbers of a design, by visit, in their order.
pub(super) struct Order<'d> {
    covariance: &'d DMatrix<f64>,
    parts: Vec<Part>,
}

impl<'d> Order<'d> {
    /// Of numbers of these visits, which follow each other: X, r, and what the tested unknowns do to them all along; C of the fit.
    pub fn of(
        covariance: &'d DMatrix<f64>,
        visits: &[usize],
        (x, r, a): (&DMatrix<f64>, &DVector<f64>, &DMatrix<f64>),
    ) -> Self {
        let mut parts = Vec::new();
        let mut from = 0;
        while from < visits.len() {
            let count = visits[from..].iter().take_while(|&&visit| visit == visits[from]).count();
            let (x, r, a) = (x.rows(from, count), r.rows(from, count), a.rows(from, count));
            parts.push(Part { g: a.tr_mul(&r), own: a.tr_mul(&a), across: x.tr_mul(&a) });
            from += count;
        }
        Order { covariance, parts }
    }

    /// Whether a change from one of these visits on, by their place, is more than chance shows in other orders.
    pub fn matters(&self, instants: &[usize]) -> bool {
        let mut order: Vec<usize> = (0..self.parts.len()).collect();
        let shown = self.most(&order, instants);
        let mut rng = ChaCha8Rng::seed_from_u64(self.parts.len() as u64);
        let mut as_much = 0;
        for _ in 0..ORDERS {
            order.shuffle(&mut rng);
            as_much += usize::from(self.most(&order, instants) >= shown);
            if as_much > AS_MUCH {
                return false;
            }
        }
        true
    }

    /// The most that a change from one of these places of an order on explains.
    fn most(&self, order: &[usize], instants: &[usize]) -> f64 {
        let Some(first) = self.parts.first() else { return 0.0 };
        let mut g = first.g.clone() * 0.0;
        let (mut own, mut across) = (first.own.clone() * 0.0, first.across.clone() * 0.0);
        let mut most = 0.0f64;
        for (place, &part) in order.iter().enumerate().rev() {
            let part = &self.parts[part];
            g += &part.g;
            own += &part.own;
            across += &part.across;
            if instants.contains(&place) {
                let matrix = &own - across.tr_mul(&(self.covariance * &across));
                let explained = matrix.cholesky().map(|factor| g.dot(&factor.solve(&g)));
                most = most.max(explained.unwrap_or(0.0));
            }
        }
        most
    }
}
