//! Columns whose headers differ in one word: a coordinate or a number.

use super::seen::Seen;
use std::collections::HashMap;

/// Words of columns that hold no measured place.
const NO_PLACE: [&str; 29] = [
    "std",
    "sd",
    "stdev",
    "sigma",
    "dev",
    "deviation",
    "abw",
    "err",
    "error",
    "res",
    "residual",
    "rms",
    "u",
    "unc",
    "vel",
    "velocity",
    "speed",
    "acc",
    "force",
    "torque",
    "effort",
    "current",
    "temp",
    "rot",
    "rotation",
    "orientation",
    "ori",
    "euler",
    "quat",
];

/// Words of standard deviations.
pub(super) const SPREAD: [&str; 6] = ["std", "sd", "stdev", "sigma", "unc", "uncertainty"];

/// Words of what was wanted, and not measured.
const WANTED: [&str; 12] = [
    "nom",
    "nominal",
    "soll",
    "cmd",
    "command",
    "commanded",
    "target",
    "ref",
    "des",
    "desired",
    "theo",
    "prog",
];

/// Words of what was computed from the measurement.
const COMPUTED: [&str; 8] = ["dev", "deviation", "abw", "abweichung", "err", "error", "res", "residual"];

/// Words of what was measured.
pub(super) const MEASURED: [&str; 10] =
    ["mess", "meas", "measured", "ist", "act", "actual", "gemessen", "mes", "mocap", "tracker"];

/// Columns of one name with all coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    /// Where x, y, z (and w) stand.
    pub columns: Vec<usize>,
    /// The words that they have in common.
    pub common: Vec<String>,
    /// The letter that stands directly before the coordinate, as in `px` or `qw`.
    pub letter: Option<char>,
}

impl Group {
    pub fn has(&self, words: &[&str]) -> bool {
        self.common.iter().any(|word| words.contains(&word.as_str()))
    }

    pub fn is_spread(&self) -> bool {
        self.has(&SPREAD) || self.letter == Some('s')
    }

    pub fn is_turn(&self) -> bool {
        let turned =
            ["rot", "rotation", "orientation", "ori", "euler", "quat", "quaternion", "rotvec", "angle"];
        self.has(&turned) || matches!(self.letter, Some('q' | 'r'))
    }

    /// Whether it may hold positions, measured or wanted.
    pub fn is_place(&self) -> bool {
        !self.has(&NO_PLACE)
            && !self.is_turn()
            && !self.is_spread()
            && matches!(self.letter, None | Some('p'))
    }

    pub fn is_wanted(&self) -> bool {
        self.has(&WANTED)
    }

    /// Whether it holds errors of the measurement, or what they were computed from: no quantity on which the robot's errors depend.
    pub fn is_no_cause(&self) -> bool {
        self.is_wanted() || self.has(&COMPUTED)
    }
}

/// A word as a coordinate: `x`, `px`, `qx`, `rx`, `sx`.
fn coordinate(word: &str) -> Option<(Option<char>, char)> {
    let mut chars = word.chars();
    match (chars.next(), chars.next(), chars.next()) {
        (Some(c @ ('x' | 'y' | 'z' | 'w')), None, _) => Some((None, c)),
        (Some(letter @ ('p' | 'q' | 'r' | 's')), Some(c @ ('x' | 'y' | 'z' | 'w')), None) => {
            Some((Some(letter), c))
        }
        _ => None,
    }
}

/// Words that columns share, what they are letters of, and the columns by axis.
type Axes = (Vec<String>, Option<char>, Vec<(char, usize)>);

/// Columns that share all other words, by number.
type Numbered = Vec<(usize, usize)>;

/// Groups of free columns, x y z each, with w at their end where there is one.
pub(super) fn coordinates(seen: &[Seen<'_>]) -> Vec<Group> {
    let mut found: Vec<Axes> = Vec::new();
    for (k, column) in seen.iter().enumerate().filter(|(_, column)| column.free && column.may_be_numbers()) {
        // The last word that is a coordinate: `/tool/x/position/x` is none of ours.
        let Some((at, (letter, axis))) =
            column.words.iter().enumerate().rev().find_map(|(at, word)| Some((at, coordinate(word)?)))
        else {
            continue;
        };
        let mut common = column.words.clone();
        common.remove(at);
        match found.iter_mut().find(|(words, other, _)| *words == common && *other == letter) {
            Some((_, _, axes)) => axes.push((axis, k)),
            None => found.push((common, letter, vec![(axis, k)])),
        }
    }
    let whole = |(common, letter, axes): Axes| {
        let one = |axis: char| {
            let mut these = axes.iter().filter(|(other, _)| *other == axis);
            these.next().filter(|_| these.next().is_none()).map(|(_, k)| *k)
        };
        let mut columns = vec![one('x')?, one('y')?, one('z')?];
        // A `w` of angles is the first of FANUC's W P R.
        let quadruple = |w: &usize| {
            let all = [columns[0], columns[1], columns[2], *w];
            seen[*w].unit == seen[columns[0]].unit && (seen[*w].cells.is_empty() || unit_length(seen, &all))
        };
        columns.extend(one('w').filter(quadruple));
        Some(Group { columns, common, letter })
    };
    found.into_iter().filter_map(whole).collect()
}

/// Columns that differ in a number: in the order of the numbers, whole from 0 or from 1, and so many. All of them have to pass `usable`.
pub(super) fn runs(seen: &[Seen<'_>], count: usize, usable: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let mut found: Vec<Numbered> = Vec::new();
    let mut places: HashMap<Vec<String>, usize> = HashMap::new();
    for (k, column) in seen.iter().enumerate() {
        for (at, number) in
            column.words.iter().enumerate().filter_map(|(at, word)| Some((at, word.parse().ok()?)))
        {
            let mut common = column.words.clone();
            common[at] = "#".into();
            let place = *places.entry(common).or_insert(found.len());
            match found.get_mut(place) {
                Some(members) => members.push((number, k)),
                None => found.push(vec![(number, k)]),
            }
        }
    }
    let whole = |mut members: Numbered| {
        members.sort_unstable();
        let first = members.first()?.0;
        let consecutive = members.iter().enumerate().all(|(k, (number, _))| *number == first + k);
        let fits =
            members.len() == count && first <= 1 && consecutive && members.iter().all(|(_, k)| usable(*k));
        fits.then(|| members.into_iter().map(|(_, k)| k).collect())
    };
    found.into_iter().filter_map(whole).collect()
}

/// Whether numbers of four columns are quaternions.
pub(super) fn unit_length(seen: &[Seen<'_>], columns: &[usize]) -> bool {
    let numbers: Option<Vec<Vec<f64>>> = columns.iter().map(|&k| seen[k].numbers()).collect();
    let Some(numbers) = numbers.filter(|numbers| numbers.len() == 4) else { return false };
    let rows = numbers.iter().map(Vec::len).min().unwrap_or(0);
    let length = |row: usize| numbers.iter().map(|column| column[row]).fold(0.0, f64::hypot);
    let mut lengths = (0..rows).map(length).filter(|length| length.is_finite()).peekable();
    lengths.peek().is_some() && lengths.all(|length| (length - 1.0).abs() < 2e-3)
}
