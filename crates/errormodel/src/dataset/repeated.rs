//! Channels that carry the same values: a controller that logs a temperature under ten names has one temperature.

use super::Dataset;
use super::derived::is_derived;
use std::collections::HashMap;

impl Dataset {
    /// For each channel the first one with the same values, to the last bit, of the same kind; none for a channel that is the first
    /// with its values, and for channels that no file has ([`is_derived`]).
    pub fn repeated_channels(&self) -> Vec<Option<usize>> {
        let mut first = HashMap::new();
        let columns = self.schema.channels.iter().zip(&self.channels).enumerate();
        columns
            .map(|(k, (channel, column))| {
                if is_derived(&channel.name) {
                    return None;
                }
                let bits: Vec<u64> = column.iter().map(|value| value.to_bits()).collect();
                let at = *first.entry((channel.temperature, channel.unit.as_str(), bits)).or_insert(k);
                (at != k).then_some(at)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Schema};

    #[test]
    fn equal_channels_are_one() {
        let channel = |name: &str, unit: &str| Channel {
            name: name.into(),
            unit: unit.into(),
            temperature: unit == "degC",
        };
        let channels = vec![
            channel("a", "1"),
            channel("b", "1"),
            channel("c", "degC"),
            channel("d", "1"),
            channel("kind~", "1"),
        ];
        let data = Dataset {
            schema: Schema { channels, ..Schema::default() },
            channels: vec![vec![1.0, 2.0], vec![1.0, 2.0], vec![1.0, 2.0], vec![1.0, 2.5], vec![1.0, 2.0]],
            ..Dataset::default()
        };
        assert_eq!(data.repeated_channels(), [None, Some(0), None, None, None]);
    }
}
