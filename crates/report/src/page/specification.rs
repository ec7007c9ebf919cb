//! The specification on a page: one verdict, and every case.

use super::Page;
use crate::figure::escape;
use crate::{Correction, SpecificationCase, SpecificationLines, significant};

/// Conformity with the specification.
pub(super) fn specification(page: &mut Page, of: Option<&SpecificationLines>) {
    let Some(of) = of else {
        page.note("No specification was given. With --spec 0.5mm, the held-out poses are compared with one.");
        return;
    };
    let name = of.judged.verdict.name();
    page.raw(&format!(
        "<p><span class=\"badge {}\">{name}</span> {}</p>",
        name.replace(' ', "_"),
        escape(&of.judged.sentence())
    ));
    let judged = |correction: Correction| match correction == of.judged.correction {
        true => name.to_owned(),
        false => "–".into(),
    };
    let row = |case: &SpecificationCase| {
        let within = case.tolerance_mm.map_or_else(|| "–".into(), |mm| significant(mm, 3));
        let inside = format!("{} of {}", case.inside, case.poses);
        let name = case.correction.name().to_owned();
        vec![name, inside, significant(case.rms_mm, 3), within, judged(case.correction)]
    };
    let rows: Vec<Vec<String>> = of.cases.iter().map(row).collect();
    page.table(
        "The specification, case by case",
        &["robot", "inside", "RMS, mm", "95 % within, mm", "verdict"],
        &rows,
        true,
    );
    page.note(&of.meaning());
}
