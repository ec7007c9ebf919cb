//! Derived channels of all rows, made once for a pass over the blocks.
//!
//! What follows the order of poses is the same at all rows of a pose and is kept by pose; what follows a channel is kept by row.

use rayon::prelude::*;
use std::collections::BTreeSet;
use truepose_errormodel::{AnyEffect, Channel, Dataset, Signal, Visits};
use truepose_kinematics::Chain;

/// Channels that some effects read and the data lacks.
pub(crate) struct Derived {
    channels: Vec<(Channel, Column)>,
}

enum Column {
    ByVisit(Vec<f64>),
    ByRow(Vec<f64>),
}

/// The channels that these effects read and the data lacks.
pub(crate) fn missing<'e>(
    data: &Dataset,
    effects: impl Iterator<Item = &'e Box<dyn AnyEffect>>,
) -> BTreeSet<String> {
    let needs = effects.flat_map(|effect| effect.needs());
    needs
        .filter_map(|need| match need {
            Signal::Channel(name) if data.schema.channel(&name).is_none() => Some(name),
            _ => None,
        })
        .collect()
}

impl Derived {
    /// Of these effects; what cannot be made is missing, and such an effect has no columns.
    pub fn new<'e>(
        data: &Dataset,
        chain: &Chain,
        effects: impl Iterator<Item = &'e Box<dyn AnyEffect>>,
    ) -> Self {
        let names = missing(data, effects);
        let visits = if names.is_empty() { Visits { rows: Vec::new() } } else { Visits::of(data) };
        let names: Vec<String> = names.into_iter().collect();
        let made = |name: &String| {
            let (channel, column) = data.derived_channel(name, chain)?;
            let alike = visits.rows.iter().all(|rows| {
                rows.first().is_none_or(|&first| {
                    rows.iter().all(|&row| column[row].to_bits() == column[first].to_bits())
                })
            });
            let column = match alike {
                true => {
                    let first = |rows: &Vec<usize>| rows.first().map_or(f64::NAN, |&row| column[row]);
                    Column::ByVisit(visits.rows.iter().map(first).collect())
                }
                false => Column::ByRow(column),
            };
            Some((channel, column))
        };
        Derived { channels: names.par_iter().filter_map(made).collect() }
    }

    /// These rows of the data, with the channels.
    pub fn select(&self, data: &Dataset, rows: &[usize]) -> Dataset {
        let mut part = data.select(rows);
        for (channel, column) in &self.channels {
            part.schema.channels.push(channel.clone());
            part.channels.push(match column {
                Column::ByVisit(values) => rows.iter().map(|&row| values[data.visit[row]]).collect(),
                Column::ByRow(values) => rows.iter().map(|&row| values[row]).collect(),
            });
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::data;
    use truepose_errormodel::effects::{Grows, Spot, Thermal};
    use truepose_errormodel::{ErrorModel, History};
    use truepose_kinematics::JointId;

    #[test]
    fn a_part_of_the_rows_has_the_channels_of_all() {
        let (chain, mut data) = data(40, 3, &|_, _, _| [0.0; 3]);
        data.schema.time = true;
        data.time = (0..data.len()).map(|row| 60.0 * data.visit[row] as f64 + (row % 3) as f64).collect();
        data.schema.channels.push(Channel { name: "motor".into(), unit: "K".into(), temperature: true });
        data.channels.push((0..data.len()).map(|row| (0.3 * row as f64).sin()).collect());
        let joint = JointId(2);
        let history = Thermal {
            grows: Some(Grows::Motion),
            ..Thermal::by(Spot::Joint(joint), History::Travel(joint), 300.0)
        };
        let late = Thermal { channel: "motor".into(), lag: Some(500.0), ..history.clone() };
        let effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(history), Box::new(late)];
        let derived = Derived::new(&data, &chain, effects.iter());
        assert_eq!(derived.channels.iter().filter(|c| matches!(c.1, Column::ByVisit(_))).count(), 1);

        let model = ErrorModel::new(chain, effects).unwrap();
        let whole = data.derived_for(&model).unwrap();
        let rows: Vec<usize> = (data.len() / 2..data.len()).collect();
        let part = derived.select(&data, &rows);
        assert!(model.bind(&part.schema).is_ok());
        for (channel, column) in part.schema.channels.iter().zip(&part.channels) {
            let expected = &whole.channels[whole.schema.channel(&channel.name).unwrap()];
            assert!(
                rows.iter().zip(column).all(|(&row, value)| expected[row].to_bits() == value.to_bits()),
                "{}",
                channel.name
            );
        }
    }
}
