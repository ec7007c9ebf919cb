//! What the search believes before it has seen the data: every belief of the crate, in one place.
//!
//! A belief decides *what* is found: prior odds, thresholds, what counts as absorbed, how fine the grids are. How much work is spent is a
//! [`crate::Budget`]. Tolerances of numerical methods (series, bisections, difference steps) stay where they are used, and grids of a hypothesis
//! (numbers of pieces, instants, shares of a load) with the hypothesis: they are part of what it is.
//!
//! *In-sample* means that the value was set while looking at a study of this repository, so that the study's figures flatter it.
//! *Convention* means that it was chosen beforehand and not derived. docs/method.md §8 has the same table, which a test keeps up to date.

use crate::constants::constants;

constants! {
    /// The beliefs of a discovery. Scores, penalties and log prior odds are in units of −2 ln L.
    Policy {
        /// Scores (−2 ln of the posterior odds) that differ by less are not distinguishable: odds of 20 to 1, where Kass and Raftery (1995)
        /// begin to call evidence strong.
        tie: f64 = 6.0;
        /// Part of [`tie`](Self::tie) within which variants of one cause are not distinguishable; the simplest is taken. Convention.
        variant_ties: f64 = 0.5;
        /// Times [`tie`](Self::tie) by which a pair without the best competitor has to beat the best competitor's own pair. Convention.
        pair_ties: f64 = 2.0;
        /// κ, prior standard deviation of a candidate's coefficients in expected sizes while it is compared: so wide that it holds only
        /// what the data leaves open. Convention.
        wide: f64 = 100.0;
        /// T, temperature of the probabilities of names: the linearised likelihood is too certain by about as much. Convention, until a study
        /// calibrates it.
        name_temperature: f64 = 2.0;
        /// Log prior odds (−2 ln), for the probability of a name, against causes that the library has no name for: 20 to 1. Convention.
        unnamed_name: f64 = 6.0;
        /// Log prior odds (−2 ln), for the probability of a name, against a link that bends: every drive yields, and the drives have most of an
        /// arm's compliance (Dumas et al. 2011). 20 to 1, convention.
        link_name: f64 = 6.0;
        /// p among surrogates of a channel up to which its name is not doubted: the resolution of 19 of them.
        surrogates_level: f64 = 0.05;
        /// Log prior odds against a structure without a name (−2 ln): a named cause is believed before it. Convention, 3e5 to 1.
        unnamed_penalty: f64 = 25.0;
        /// Log prior odds against what reads the order of poses where the data has no time (−2 ln): what a channel explains as well is worth more,
        /// since later poses have the channel and no place in the order. Convention, 400 to 1: twice [`tie`](Self::tie).
        order_penalty: f64 = 12.0;
        /// Score by which another set of components has to be better. Convention.
        component_margin: f64 = 1.0;
        /// Score by which a named cause may be behind and still try other sets of components. Convention.
        component_reach: f64 = 120.0;
        /// The same of unnamed curves, whose sets of components have many coefficients each. Convention.
        component_reach_unnamed: f64 = 30.0;
        /// Likelihood-ratio statistic less penalty that a partner needs to count in the look-ahead. Convention: twice [`tie`](Self::tie).
        partner_margin: f64 = 12.0;
        /// Difference of −2 ln L within which two explanations of as many unknowns are the same one: their wide priors differ by as much.
        same_explanation: f64 = 0.05;
        /// Prior standard deviation of an accepted candidate's coefficients over the width of the distribution from which they look drawn:
        /// twice, so that the prior of the fit does not pull (a coefficient of average size is half a standard deviation out).
        prior_widths: f64 = 2.0;
        /// Standard deviations by which a compliance may be negative in a contest: the 95 % interval.
        negative_compliance: f64 = 2.0;
        /// Explained fraction of a candidate's direction that is left beside the present model below which it is absorbed: the data cannot
        /// judge it. Convention; a direction of 2e-3 has a variance inflation factor of 500.
        absorbed: f64 = 2e-3;

        /// Smallest p of a screen, in multiples of α, up to which the best candidates are tested under their own noise. Convention.
        second_look: f64 = 50.0;
        /// Times by which a p of that test counts: the noise is fitted beside the candidate, in its favour. In-sample (tuning half of the unseen
        /// study): a candidate that is not there came out at up to a hundredth of its p; ten times that.
        second_look_tests: f64 = 1000.0;
        /// Student's t of the held-out gain over folds that a candidate needs: one-sided 2.5 % of a normal distribution.
        held_out_t: f64 = 2.0;
        /// Fraction of the held-out error that a candidate has to take away where it acts. Convention.
        held_out_gain: f64 = 0.02;
        /// Part of the noise standard deviation (3-D) that may do instead. Convention.
        held_out_noise: f64 = 0.1;
        /// Fraction by which the held-out error of contiguous blocks may grow. As [`held_out_gain`](Self::held_out_gain).
        blocks_loss: f64 = 0.02;
        /// Fraction of half-samples in which a candidate has to be selected: stability selection, Meinshausen and Bühlmann (2010), 0.6 to 0.9.
        stability: f64 = 0.8;
        /// Standard deviations of χ²_k above k from which a candidate counts as selected in a half-sample. Convention.
        half_sample_deviations: f64 = 1.5;
        /// Standard deviations of χ²_k above k within which two halves agree. Convention: three sigma.
        agreement_deviations: f64 = 3.0;
        /// Degrees of freedom of the heavy tail under which held-out rows are scored. Lange, Little and Taylor (1989): 4.
        score_tail: f64 = 4.0;
        /// Fraction of its gain in random folds that a cause of time keeps in contiguous blocks. In-sample: robots 29 to 150 of `harm`.
        time_gain_kept: f64 = 0.5;
        /// Student's t that it has there. In-sample: robots 29 to 150 of `harm`, and three cases with a true drift (t from 1.8 on).
        time_t: f64 = 1.0;

        /// Probability of the Wald test above which the coefficients of a finding are taken for zero. Convention; set while
        /// looking at measured robots (in-sample).
        not_significant: f64 = 0.01;
        /// Largest angle by which a drive errs, rad, or rad for each rad of the joint that drags it: five times the worn transmissions of
        /// the literature (1 to 2 mrad).
        largest_angle: f64 = 1e-2;
        /// Fraction of the position error that counts when refitted models are compared. As [`held_out_gain`](Self::held_out_gain); set while
        /// looking at measured robots (in-sample).
        counts: f64 = 0.02;
        /// Fraction by which a training error may grow where the noise is estimated anew. Convention; set while looking at
        /// measured robots (in-sample).
        training_growth: f64 = 0.01;
        /// Searched poses below which the whole loop is validated in nested folds. In-sample: set after a campaign of 70 poses had
        /// become worse.
        few_poses: usize = 100;
        /// Fraction of the configurations in a test set that is drawn automatically. Convention.
        test_set: f64 = 0.2;
        /// Searched poses below which nested folds are twice as many, so that each search has 90 % of them. Convention.
        small_campaign: usize = 60;
        /// Training poses below which nothing is searched. Convention; set while looking at measured robots
        /// (in-sample).
        fewest_poses: usize = 12;
        /// Level of the tests behind a verdict. Convention.
        verdict_level: f64 = 0.01;

        /// Expected number of good rows that are kept out of fits. Convention: one data set in twenty loses a good row.
        outlier_suspect: f64 = 0.05;
        /// Expected number of good rows that are reported: the family-wise level of the search (default `alpha`).
        outlier_certain: f64 = 0.002;
        /// Posterior odds from which a row is gross rather than one of the tail's: 99 %.
        outlier_odds: f64 = 99.0;
        /// Standard error of the logarithm of the ratio of the 95 % quantile to the median of χ²_3, times √n: from order
        /// statistics.
        outlier_ratio_error: f64 = 1.4;
        /// Robust standard deviations of one axis below which no row is an outlier. Convention.
        outlier_least: f64 = 5.0;
        /// Fraction of the rows above which they are no outliers but an effect. Convention.
        outlier_most: f64 = 0.15;
        /// Probability that suspects have a payload or a stretch of the record in common by chance, below which they may be an effect. Convention;
        /// set while looking at the tuning half of the unseen study (in-sample).
        outlier_shared: f64 = 0.001;

        /// p of the test of independent poses below which a wander is estimated: one campaign in a hundred has one for nothing, which costs it
        /// little. Convention.
        dependence_level: f64 = 0.01;
        /// Independent tests that a screen is worth where a candidate is compared with a wander: between the 400 that the level of the
        /// resampling test is worth for one unknown (a statistic of 21) and the 10⁴ that are made. Convention.
        dependence_tests: f64 = 1000.0;
        /// Factor on the p of an effect that follows the time: a wander whose time constant is estimated from tens of poses is not
        /// distinguishable from a slow effect (autocorrelation 0.9, 40 to 90 poses). In-sample on 190 such campaigns without a cause.
        slow_tests: f64 = 10.0;
        /// p of joints that do not scatter below which their scatter joins the noise of a search that found no further effect: one campaign in a
        /// thousand has it for nothing. Convention.
        joint_noise_level: f64 = 0.001;

        /// Information of a direction times the square of its prior standard deviation below which the data cannot test it: there the data
        /// narrows the prior by less than a factor √2.
        untestable_information: f64 = 1.0;
        /// Explained fraction left beside the declared model below which a cause is the declared model's own. Convention.
        untestable_declared: f64 = 1e-4;
        /// Standard deviations above the critical value at which an effect is detected with a probability of 80 %: Φ⁻¹(0.8).
        power: f64 = 0.84;

        /// ln f of a repeatability limit whose 95 % interval is a factor f to either side: f = 1.25. Convention.
        floor_precision: f64 = 0.223;
        /// Degrees of freedom below which repeats are no estimate of the limit: the interval would exceed a factor of two.
        floor_freedom: f64 = 8.0;
        /// Part of the shortest period over which joints of a neighbourhood may differ: an effect of that period changes by a third of its
        /// amplitude (2π/20), and others by less. Convention.
        near_share: f64 = 0.05;
        /// Cycles per turn or travel of the effects that may not change in the neighbourhoods of difference estimates: twice a turn's
        /// fourth harmonic. Convention.
        difference_cycles: f64 = 8.0;
        /// Unexplained RMS, in units of the noise, that an adequate model does not have. Convention.
        adequate_margin: f64 = 2.0;

        /// Shortest period looked for: parts of a turn. Convention.
        cycles_per_turn: f64 = 256.0;
        /// Shortest period looked for: parts of a linear axis' visited travel. Convention.
        cycles_per_travel: f64 = 400.0;
        /// Step of the frequency grid, cycles over the visited range: a quarter, so that no peak is missed by more than
        /// an eighth of a cycle (sinc²(1/8) = 0.95 of its power).
        frequency_step: f64 = 0.25;
        /// First-order lags tried for each temperature, in equal ratios. Convention.
        lags: usize = 12;
        /// Longest lag, of the length of the record: what is slower cannot be distinguished from a drift.
        longest_lag: f64 = 1.0 / 3.0;
    }
}

/// Penalty of one coefficient: BIC's logarithm of the number of observations (Schwarz 1978).
pub(crate) fn penalty_per_coefficient(observations: usize) -> f64 {
    (observations.max(2) as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_belief_is_scaled_at_a_time() {
        let policy = Policy::default();
        let half = policy.scaled("tie", 0.5).expect("a belief");
        assert_eq!((half.tie, half.wide), (3.0, 100.0));
        assert_eq!(policy.scaled("few_poses", 0.5).expect("a belief").few_poses, 50);
        assert_eq!(policy.scaled("luck", 0.5), None);
    }

    #[test]
    fn the_method_lists_every_belief_with_its_default() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/method.md");
        let text = std::fs::read_to_string(path).expect("docs/method.md");
        for (name, value) in Policy::default().table() {
            let row = text.lines().find(|line| line.starts_with(&format!("| `{name}` | ")));
            let row = row.unwrap_or_else(|| panic!("docs/method.md has no row `{name}`"));
            let stated: f64 = row.split('|').nth(2).expect("a default").trim().parse().expect("a number");
            let value: f64 = value.parse().expect("a number");
            assert!(
                (stated - value).abs() <= 5e-4 * value.abs(),
                "{name}: {stated} in docs/method.md, {value} here"
            );
        }
    }
}
