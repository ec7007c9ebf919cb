//! Identifiability: groups, correlations, directions that are not excited, observability indices O1–O5.

use super::Page;
use crate::figure::{heat_map, unit_text};
use crate::identification::groups;
use crate::{advice_text, significant, value_with_interval};
use truepose_errormodel::Dataset;
use truepose_identify::{Excitation, Fit, IdentifyError, Observability, excitation, observability};

/// Coefficients of the heat map.
const SHOWN: usize = 36;

impl Page {
    /// The part, of a fit on this data.
    pub(crate) fn identifiability(&mut self, fit: &Fit, data: &Dataset) -> Result<(), IdentifyError> {
        let visits = truepose_errormodel::Visits::of(data).len();
        let Excitation { weak_directions: weak, advice, .. } = excitation(fit, data)?;
        let weak = match weak {
            0 => String::new(),
            1 => " In 1 direction the standard deviation exceeds that of the prior.".to_owned(),
            n => format!(" In {n} directions the standard deviation exceeds that of the prior."),
        };
        let indices = observability(fit, visits)?;
        let model = fit.fitted.model();
        self.text(&format!(
            "{} of {} unknowns are identifiable with this robot, this kind of measurement and this data; each is a group of errors that act \
             alike.{weak}",
            fit.reduction.rank(),
            model.columns().len(),
        ));
        let all = groups(fit);
        let rows: Vec<Vec<String>> = all
            .iter()
            .map(|group| {
                let (value, half, unit) = value_with_interval(group.value, group.half_width, &group.unit);
                vec![
                    group.words.clone(),
                    format!("{value} ± {half}"),
                    unit_text(&unit),
                    significant(group.ratio_to_prior, 2),
                ]
            })
            .collect();
        self.raw("<details><summary>All groups with their values</summary>");
        self.table(
            "Groups: value with its 95 % interval; last column: standard deviation divided by that of the prior (1: no information from the data)",
            &["group", "value", "unit", "ratio to prior"],
            &rows,
            true,
        );
        self.raw("</details>");
        self.correlations(fit);
        if advice.is_empty() {
            self.text("Every joint moved enough: no further motion makes more directions identifiable.");
        } else {
            self.title("Motions that would make more identifiable");
            let chain = fit.fitted.chain();
            self.list(&advice.iter().take(6).map(|a| advice_text(chain, a)).collect::<Vec<_>>());
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
        let caption = if shown.len() < kept.len() {
            format!("The {} of {} coefficients with the largest correlations.", shown.len(), kept.len())
        } else {
            "Correlations of all coefficients.".into()
        };
        let svg =
            heat_map("Correlations between coefficients", &names, |a, b| correlation(shown[a], shown[b]));
        self.figure("correlations", &svg, &caption);
    }

    fn indices(&mut self, o: &Observability, fit: &Fit) {
        let row = |name: &str, value: f64, meaning: &str| {
            vec![name.to_owned(), significant(value, 3), meaning.to_owned()]
        };
        let rows = [
            row(
                "O1",
                o.o1,
                "geometric mean of the singular values, per root of the number of pose measurements",
            ),
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
            .filter_map(|(c, fraction)| Some(format!("{} ({fraction:.2})", columns.get(*c)?.name)))
            .collect();
        if !weakest.is_empty() {
            self.note(&format!("The weakest direction is mostly: {}.", weakest.join(", ")));
        }
    }
}
