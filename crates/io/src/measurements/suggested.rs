//! Columns of a file that are probably those that are missing.

use super::columns::Role;
use super::header::Header;
use super::names::split_unit;
use crate::nearest::nearest;
use crate::{Quantity, Unit};

impl Header {
    /// `; if so: --map "a1=Joint 1[deg]" …` for the missing names that some unused column may hold; a joint has its number, from 0.
    pub(super) fn suggested<'n>(&self, wanted: impl IntoIterator<Item = (&'n str, Option<usize>)>) -> String {
        let unused: Vec<(&str, &str)> = self
            .columns
            .iter()
            .filter(|column| matches!(column.role, Role::Channel(_)))
            .map(|column| (column.header.as_str(), split_unit(&column.header).0))
            .collect();
        let mut taken = vec![false; unused.len()];
        let mut pairs = Vec::new();
        let mut without_unit = false;
        for (name, joint) in wanted {
            let free = || (0..unused.len()).filter(|&k| !taken[k]);
            let found = free()
                .find(|&k| plain(unused[k].1) == plain(name))
                .or_else(|| free().find(|&k| matches(unused[k].1, name, joint)))
                .or_else(|| {
                    let near = nearest(
                        name,
                        free().filter(|_| joint.is_some() && name.len() > 2).map(|k| unused[k].1),
                    )?;
                    free().find(|&k| unused[k].1 == near)
                });
            if let Some(k) = found {
                taken[k] = true;
                without_unit |= split_unit(unused[k].0).1.is_none();
                pairs.push(format!("--map \"{name}={}\"", unused[k].0));
            }
        }
        if pairs.is_empty() {
            return String::new();
        }
        let unit = if without_unit { ", with the unit behind the name, as in `Axis 1[deg]`" } else { "" };
        format!("; perhaps they are meant by: {}{unit}", pairs.join(" "))
    }
}

/// Letters and digits alone.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Words that stand for a joint before its number.
const JOINT_WORDS: [&str; 14] =
    ["", "j", "a", "q", "s", "axis", "axe", "ax", "achse", "joint", "gelenk", "theta", "jt", "rob"];

/// Whether a column's name stands for this joint (by its number, from 0) or for this coordinate.
fn matches(column: &str, name: &str, joint: Option<usize>) -> bool {
    match joint {
        Some(joint) => {
            let column = plain(column);
            let word = column.trim_end_matches(|c: char| c.is_ascii_digit());
            column[word.len()..].parse() == Ok(joint + 1) && JOINT_WORDS.contains(&word)
        }
        None => {
            let is_unit = |word: &&str| Unit::named(word).is_none_or(|unit| unit.quantity == Quantity::Ratio);
            let mut words = column.split(|c: char| !c.is_alphanumeric()).filter(is_unit);
            words.any(|word| word.eq_ignore_ascii_case(name))
        }
    }
}
