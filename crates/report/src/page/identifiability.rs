//! What the data determines: groups in words, correlations, what is not excited, O1–O5.

use super::Page;
use crate::figure::{heat_map, unit_words};
use crate::identification::groups;
use crate::{advice_words, significant, value_with_interval};
use truepose_errormodel::Dataset;
use truepose_identify::{Excitation, Fit, IdentifyError, Observability, excitation, observability};

/// Coefficients of the heat map.
const SHOWN: usize = 36;

impl Page {
    /// The part, of a fit on this data.
    pub(crate) fn identifiability(&mut self, fit: &Fit, data: &Dataset) -> Result<(), IdentifyError> {
        let visits = truepose_errormodel::Visits::of(data).len();
        let Excitation { weak_directions: weak, advice, .. } = excitation(fit, data)?;
        let indices = observability(fit, visits)?;
        let model = fit.fitted.model();
        self.text(&format!(
            "{} unknowns, of which this robot, this kind of measurement and this data can tell {} apart; each of those is a group. \
             {weak} directions are known worse than by their expected sizes.",
            model.columns().len(),
            fit.reduction.rank(),
        ));
        let all = groups(fit);
        let rows: Vec<Vec<String>> = all
            .iter()
            .map(|group| {
                let (value, half, unit) = value_with_interval(group.value, group.half_width, &group.unit);
                vec![
                    group.words.clone(),
                    format!("{value} ± {half}"),
                    unit_words(&unit),
                    significant(group.against_expected, 2),
                ]
            })
            .collect();
        self.raw("<details><summary>All groups with their values</summary>");
        self.table(
            "Groups: value with its 95 % interval; last column: standard deviation over the size that was expected (1: the data says nothing)",
            &["group", "value", "unit", "against expected"],
            &rows,
            true,
        );
        self.raw("</details>");
        self.correlations(fit);
        if advice.is_empty() {
            self.text("Every joint moved enough to determine what can be determined.");
        } else {
            self.title("What would determine more");
            let chain = fit.fitted.chain();
            self.list(&advice.iter().take(6).map(|a| advice_words(chain, a)).collect::<Vec<_>>());
        }
        self.indices(&indices, fit);
        Ok(())
    }

    fn correlations(&mut self, fit: &Fit) {
        let covariance = fit.fitted.covariance();
        let kept = &fit.reduction.kept;
        let correlation = |a: usize, b: usize| {
            covariance[(a, b)] / (covariance[(a, a)] * covariance[(b, b)]).max(f64::MIN_POSITIVE).sqrt()
        };
        let strongest =
            |a: usize| kept.iter().filter(|&&b| b != a).map(|&b| correlation(a, b).abs()).fold(0.0, f64::max);
        let mut order: Vec<(usize, f64)> = kept.iter().map(|&c| (c, strongest(c))).collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut shown: Vec<usize> = order.iter().take(SHOWN).map(|o| o.0).collect();
        shown.sort_unstable();
        if shown.len() < 2 {
            return;
        }
        let columns = fit.fitted.model().columns();
        let names: Vec<String> = shown.iter().map(|&c| columns[c].name.clone()).collect();
        let words = if shown.len() < kept.len() {
            format!("The {} coefficients, of {}, that go most with another one.", shown.len(), kept.len())
        } else {
            "Correlations of all coefficients.".into()
        };
        let svg =
            heat_map("Correlations between coefficients", &names, |a, b| correlation(shown[a], shown[b]));
        self.figure("correlations", &svg, &words);
    }

    fn indices(&mut self, o: &Observability, fit: &Fit) {
        let row = |name: &str, value: f64, words: &str| {
            vec![name.to_owned(), significant(value, 3), words.to_owned()]
        };
        let rows = [
            row("O1", o.o1, "geometric mean of the singular values, per root of visits"),
            row("O2", o.o2, "inverse of the condition number"),
            row("O3", o.o3, "smallest singular value"),
            row("O4", o.o4, "smallest, squared, over the largest: amplification of noise"),
            row("O5", o.o5, "harmonic sum: average variance"),
        ];
        self.table(
            "Observability of the configurations; larger is better",
            &["index", "value", "what it is"],
            &rows,
            false,
        );
        let columns = fit.fitted.model().columns();
        let weakest: Vec<String> = o
            .weakest
            .iter()
            .filter_map(|(c, share)| Some(format!("{} ({share:.2})", columns.get(*c)?.name)))
            .collect();
        if !weakest.is_empty() {
            self.note(&format!("The weakest direction is mostly: {}.", weakest.join(", ")));
        }
    }
}
