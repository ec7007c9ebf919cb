//! Headers of several rows: names of groups above names of components.

use super::super::spelled_units::is_unit_word;
use std::collections::HashMap;

/// A header whose empty names are completed from the rows above, and whose equal names are told apart by them; the nearest row comes first.
pub(super) fn composed(header: &[String], above: &[Vec<String>]) -> Vec<String> {
    let mut names = header.to_vec();
    for (k, name) in names.iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
        if let Some(title) = above.iter().filter_map(|row| row.get(k)).find(|cell| !cell.is_empty()) {
            name.clone_from(title);
        }
    }
    units_below(&mut names, above);
    for row in above {
        let twice = repeated(&names);
        if twice.is_empty() {
            break;
        }
        let titles = spread(row, names.len());
        let groups: Vec<&String> = titles
            .iter()
            .zip(&names)
            .filter(|(title, name)| twice.contains(name) && !title.is_empty())
            .map(|(title, _)| title)
            .collect();
        // What stands under the same titles belongs to the same group, whether or not its name is unique.
        let prefixed: Vec<String> = names
            .iter()
            .zip(header.iter().zip(&titles))
            .map(|(name, (own, title))| match groups.contains(&title) && !own.is_empty() {
                true => format!("{title} {name}"),
                false => name.clone(),
            })
            .collect();
        names = prefixed;
    }
    names
}

/// A row that holds names of some columns and, under the names of the row above, units of others.
fn units_below(names: &mut [String], above: &[Vec<String>]) {
    let Some(titles) = above.first() else { return };
    if !repeated(names).iter().any(|name| is_unit_word(name)) {
        return;
    }
    for (name, title) in names.iter_mut().zip(titles) {
        if is_unit_word(name) && !title.is_empty() {
            let unit = name.trim_matches(['[', ']', '(', ')', ' ', '-', '–']);
            *name = if unit.is_empty() { title.clone() } else { format!("{title}[{unit}]") };
        }
    }
}

/// Whether the rows above can improve a header.
pub(super) fn incomplete(header: &[String]) -> bool {
    header.iter().any(String::is_empty) || !repeated(header).is_empty()
}

fn repeated(names: &[String]) -> Vec<String> {
    let mut counts: HashMap<&String, usize> = HashMap::new();
    names.iter().filter(|name| !name.is_empty()).for_each(|name| *counts.entry(name).or_default() += 1);
    counts.into_iter().filter(|(_, count)| *count > 1).map(|(name, _)| name.clone()).collect()
}

/// The titles of a row; a merged cell stands over the empty ones behind it, where no title is written out twice.
fn spread(row: &[String], count: usize) -> Vec<String> {
    let mut titles: Vec<String> = (0..count).map(|k| row.get(k).cloned().unwrap_or_default()).collect();
    let written_out = titles.windows(2).any(|pair| !pair[0].is_empty() && pair[0] == pair[1]);
    if !written_out {
        for k in 1..titles.len() {
            if titles[k].is_empty() {
                titles[k] = titles[k - 1].clone();
            }
        }
    }
    titles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(text: &str) -> Vec<String> {
        text.split(',').map(str::to_owned).collect()
    }

    #[test]
    fn names_of_groups() {
        let above = [row(",,Rotation,Rotation,Position,Position,Error,"), row(",,Body,Body,Body,Body,Body,")];
        assert_eq!(
            composed(&row("Frame,t,X,W,X,Y,,q1"), &above),
            row("Frame,t,Rotation X,Rotation W,Position X,Position Y,Error,q1")
        );
        let merged = [row("No,Joints,,Tracker,,Remark")];
        assert_eq!(composed(&row(",S,L,X,Y,"), &merged), row("No,S,L,X,Y,Remark"));
        let twice = [row(",Joints,,Tracker,,Remark")];
        assert_eq!(
            composed(&row("No,A,B,A,B,"), &twice),
            row("No,Joints A,Joints B,Tracker A,Tracker B,Remark")
        );
        assert_eq!(composed(&row("a,b"), &[row("t,t")]), row("a,b"));
        let units = [row("No,Base,Elbow,TCP,,Oil")];
        assert_eq!(
            composed(&row(",deg,deg,x [mm],y [mm],-"), &units),
            row("No,Base[deg],Elbow[deg],x [mm],y [mm],Oil")
        );
    }
}
