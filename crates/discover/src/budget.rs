//! How much work a search spends: how many are tried, iterations, folds, sample sizes.
//!
//! A budget decides how long a search takes and, where it is too small, that something is missed. What is believed is a [`crate::Policy`].
//! Block sizes and the numbers of terms in series are neither and stay where they are used. All values are conventions.

use crate::constants::constants;

constants! {
    /// The budgets of a discovery.
    Budget {
        /// Rows that are searched at once; of more than a quarter above, whole poses are drawn.
        sample_rows: usize = 1000;
        /// Rows that are fitted and judged at once; of more than a quarter above, whole poses are drawn, and coefficients come from sums over
        /// all rows.
        fitted_rows: usize = 20000;
        /// Findings that all rows may add to those of a sample.
        census: usize = 8;
        /// Noise estimates of one likelihood.
        noise_iterations: usize = 5;
        /// Passes over outliers of one fit.
        outlier_iterations: usize = 4;
        /// The same where declared masses move with the stiffnesses that carry them.
        load_iterations: usize = 8;

        /// Causes of a screen that are compared in a contest.
        causes: usize = 10;
        /// Variants of each.
        variants: usize = 3;
        /// Richer variants of a cause (a part of the travel, an interval, a second time constant) that are compared, of those that are proposed;
        /// and variants of it that they are proposed for.
        richer: usize = 2;
        /// Transmissions that may be given further periods in one contest.
        transmissions: usize = 2;
        /// Further periods of one transmission.
        periods: usize = 12;
        /// Peaks of one joint's periodogram that become causes.
        peaks: usize = 3;
        /// Competitors that are given a partner in the look-ahead.
        competitors: usize = 8;
        /// Partners tried.
        partners: usize = 80;
        /// Unnamed causes that may replace a finding when it is reconsidered.
        shortlist: usize = 60;
        /// Surrogates of a channel that a finding reads.
        surrogates: usize = 19;
        /// Contests that may end without a winner.
        contests: usize = 4;
        /// Competitors of each contest that are tested.
        tested: usize = 2;
        /// Candidates that may fail as part of the refitted model before the search ends.
        failures: usize = 3;
        /// Findings up to which all of them are reconsidered after each new one.
        reconsidered: usize = 4;
        /// Passes over the nonlinear parameters of a finding with several effects.
        sweeps: usize = 2;
        /// Nonlinear parameters that are optimised jointly; more stay where the search found them.
        joint_parameters: usize = 24;

        /// Random folds of the evidence.
        folds: usize = 10;
        /// Contiguous blocks of the evidence.
        blocks: usize = 5;
        /// Random halves of the evidence, each with its complement.
        halves: usize = 10;
        /// Folds of the refits that compare two models.
        refit_folds: usize = 5;
        /// Folds of the nested validation.
        nested_folds: usize = 5;
        /// Resamples of a bootstrap interval.
        bootstrap: usize = 1999;
        /// Iterations of the fit that judges a finding's competitor on held-out rows.
        trial_iterations: usize = 6;
        /// Competing hypotheses that are listed with a finding.
        listed: usize = 4;
        /// How many of them may be unnamed.
        listed_unnamed: usize = 2;
        /// Competing hypotheses of a finding that are fitted, where that is asked for.
        fitted: usize = 2;
    }
}
