//! A campaign in which a suspicion is allowed for: what moved is another thing from there on, what was taken as given is found, a row that is
//! elsewhere is left out.

use super::{MOVED, ROW, Suspect};
use crate::Touched;
use truepose_errormodel::observation::Observation;
use truepose_errormodel::{Dataset, Landmark, Surroundings};

/// The rows as they were read, and their surroundings, with a suspicion of `touched` allowed for; none where these cannot say it: of a table that
/// is not flat, a tool or a base that was mounted again.
pub fn allowed_for(
    suspect: &Suspect,
    touched: &Touched,
    data: &Dataset,
    surroundings: &Surroundings,
) -> Option<(Dataset, Surroundings)> {
    let number = surroundings.landmarks.iter().position(|landmark| landmark.name == suspect.name)?;
    let from = match suspect.from {
        // A row with several numbers is several rows there.
        Some(row) => Some(data.line.iter().position(|line| touched.data.line.get(row) == Some(line))?),
        None => None,
    };
    match (suspect.what, from) {
        (ROW, Some(row)) => {
            let rest: Vec<usize> = (0..data.len()).filter(|&other| other != row).collect();
            Some((data.select(&rest), surroundings.clone()))
        }
        (MOVED, Some(from)) => {
            let own = |row: usize| data.landmark(row) == Some(number);
            let mut surroundings = surroundings.clone();
            surroundings.landmarks.push(elsewhere(&surroundings.landmarks[number], data.line[from])?);
            let next = surroundings.landmarks.len() - 1;
            let landmarks: Vec<Option<usize>> = (0..data.len())
                .map(|row| if own(row) && row >= from { Some(next) } else { data.landmark(row) })
                .collect();
            let mut data = data.clone();
            data.set_landmarks(Some(&landmarks));
            Some((data, surroundings))
        }
        (what, None) => {
            let observed = freed(surroundings.landmarks[number].observed.as_deref()?, &[what])?;
            let mut surroundings = surroundings.clone();
            surroundings.landmarks[number].observed = Some(observed);
            // Its rows are none of a place that is known.
            surroundings.landmarks[number].known &= what != "place";
            Some((data.clone(), surroundings))
        }
        _ => None,
    }
}

/// The same thing from a line on, at a place that is to be found.
fn elsewhere(before: &Landmark, line: u64) -> Option<Landmark> {
    let mut after = before.clone();
    after.name = format!("{} from line {line}", before.name);
    after.known = false;
    if let Some(observed) = before.observed.as_deref().filter(|_| before.known) {
        after.observed = Some(freed(observed, &["place", "direction"])?);
    }
    Some(after)
}

/// An observation with what has one of these words as unknowns; a table that bends has no place in a robot file.
fn freed(observed: &dyn Observation, words: &[&str]) -> Option<Box<dyn Observation>> {
    let of = |(what, free): (&'static str, Box<dyn Observation>)| {
        (words.contains(&what) && what != "flatness").then_some(free)
    };
    observed.freed().into_iter().find_map(of)
}
