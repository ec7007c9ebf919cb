//! The campaign's half of a description.

use crate::{Campaign, ChannelPlan, SimulateError, Visit};
use serde::{Deserialize, Serialize};
use truepose_kinematics::Chain;

/// How postures are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Postures {
    /// A Latin hypercube of `visits` postures within the limits.
    #[default]
    Random,
    /// Halton's sequence, `visits` postures.
    Halton,
    /// `points` values of each joint in all combinations.
    Grid,
    /// `visits` returns to the middle of the limits.
    Returns,
    /// The paper's set a), loads included.
    PaperA,
    /// The paper's set b), loads included.
    PaperB,
    /// The paper's payload steps at home.
    PaperLinearity,
}

/// Visits at most: each is held in memory, with its rows.
const MOST_VISITS: f64 = 1e7;

/// What is measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CampaignDescription {
    /// How postures are chosen.
    pub postures: Postures,
    /// How many postures in which positions are measured.
    pub visits: usize,
    /// Values of each joint on a grid.
    pub points: usize,
    /// Payloads, kg; empty: none, and none declared.
    pub payloads_kg: Vec<f64>,
    /// Whether each posture is visited with each payload (else they are taken in turn).
    pub each_payload: bool,
    /// Centre of gravity of the payload in the tool frame, mm.
    pub com_mm: [f64; 3],
    /// Half-width by which the centre varies from visit to visit, mm; where payloads are taken in turn.
    pub com_spread_mm: f64,
    /// How often everything is done.
    pub repeats: usize,
    /// Whether the order is drawn.
    pub shuffled: bool,
    /// From one visit to the next, s.
    pub visit_s: f64,
    /// From one target to the next, s.
    pub row_s: f64,
    /// Further columns.
    pub channels: Vec<ChannelDescription>,
}

/// What a further column shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ChannelKind {
    /// A thermometer in the air.
    #[default]
    Air,
    /// A thermometer on a body that follows the air late.
    Body,
    /// Something that wanders and touches nothing.
    Distractor,
}

/// A further column.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelDescription {
    /// Name of the column.
    pub name: String,
    /// What it shows.
    pub shows: ChannelKind,
    /// Unit of a distractor.
    pub unit: String,
    /// About which value a distractor wanders.
    pub mean: f64,
    /// Noise of a thermometer, K; size of a distractor's wandering.
    pub sd: f64,
    /// Time constant of a body, s.
    pub lag_s: f64,
}

impl Default for CampaignDescription {
    fn default() -> Self {
        CampaignDescription {
            postures: Postures::Random,
            visits: 100,
            points: 3,
            payloads_kg: Vec::new(),
            each_payload: false,
            com_mm: [0.0; 3],
            com_spread_mm: 0.0,
            repeats: 1,
            shuffled: false,
            visit_s: 30.0,
            row_s: 2.0,
            channels: Vec::new(),
        }
    }
}

impl CampaignDescription {
    /// The campaign, on this robot.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits, [`SimulateError::Size`] for more visits than fit into memory, and those
    /// of the paper's sets.
    pub fn on(&self, chain: &Chain, seed: u64) -> Result<Campaign, SimulateError> {
        self.with(chain, Vec::new(), seed)
    }

    /// The campaign, with further visits behind its own: they have the same loads, repeats and order.
    ///
    /// # Errors
    /// Those of [`CampaignDescription::on`].
    pub(super) fn with(
        &self,
        chain: &Chain,
        further: Vec<Visit>,
        seed: u64,
    ) -> Result<Campaign, SimulateError> {
        let value = self.size(chain, further.len());
        if value > MOST_VISITS {
            return Err(SimulateError::Size {
                what: "the number of visits",
                value,
                need: "at most 10 000 000",
            });
        }
        let mut campaign = match self.postures {
            Postures::Random => Campaign::random(chain, self.visits, seed)?,
            Postures::Halton => Campaign::halton(chain, self.visits)?,
            Postures::Grid => Campaign::grid(chain, self.points)?,
            Postures::Returns => Campaign::returns(&Campaign::middle(chain)?, self.visits, seed),
            Postures::PaperA => Campaign::paper_set_a(chain)?,
            Postures::PaperB => Campaign::paper_set_b(chain)?,
            Postures::PaperLinearity => Campaign::paper_linearity(),
        };
        campaign.visits.extend(further);
        let com = self.com_mm.map(|v| 1e-3 * v);
        if self.each_payload {
            campaign = campaign.with_each_payload(&self.payloads_kg, com);
        } else if !self.payloads_kg.is_empty() {
            campaign = campaign.with_some_payload(&self.payloads_kg, com, 1e-3 * self.com_spread_mm, seed);
        }
        campaign = campaign.repeated(self.repeats);
        if self.shuffled {
            campaign = campaign.shuffled(seed);
        }
        campaign.visit_s = self.visit_s;
        campaign.row_s = self.row_s;
        campaign.channels = self.channels.iter().map(ChannelDescription::plan).collect();
        Ok(campaign)
    }

    /// Visits in all; of the paper's sets, which are small, those of one set.
    fn size(&self, chain: &Chain, further: usize) -> f64 {
        let postures = match self.postures {
            Postures::Random | Postures::Halton | Postures::Returns => self.visits as f64,
            Postures::Grid => (self.points as f64).powf(chain.movable().len() as f64),
            Postures::PaperA | Postures::PaperB | Postures::PaperLinearity => 1.0,
        };
        let loads = if self.each_payload { self.payloads_kg.len().max(1) } else { 1 };
        (postures + further as f64) * loads as f64 * self.repeats as f64
    }
}

impl ChannelDescription {
    fn plan(&self) -> ChannelPlan {
        let name = self.name.clone();
        match self.shows {
            ChannelKind::Air => ChannelPlan::Air { name, sd: self.sd },
            ChannelKind::Body => ChannelPlan::Body { name, lag_s: self.lag_s, sd: self.sd },
            ChannelKind::Distractor => {
                ChannelPlan::Distractor { name, unit: self.unit.clone(), mean: self.mean, sd: self.sd }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[track_caller]
    fn check(postures: Postures, expected: usize) {
        let description = CampaignDescription { postures, visits: 9, ..CampaignDescription::default() };
        let campaign = description.on(&samples::pps(), 1).expect("a campaign");
        assert_eq!(campaign.visits.len(), expected);
    }

    #[test]
    fn every_kind_of_postures_is_made() {
        check(Postures::Random, 9);
        check(Postures::Halton, 9);
        check(Postures::Grid, 729);
        check(Postures::Returns, 9);
        check(Postures::PaperA, 112);
        check(Postures::PaperB, 338);
        check(Postures::PaperLinearity, 13);
    }

    #[test]
    fn loads_repeats_and_the_clock_arrive() {
        let description = CampaignDescription {
            visits: 5,
            payloads_kg: vec![0.0, 10.0],
            each_payload: true,
            repeats: 3,
            shuffled: true,
            visit_s: 7.0,
            ..CampaignDescription::default()
        };
        let campaign = description.on(&samples::heavy(), 1).expect("a campaign");
        assert_eq!(campaign.visits.len(), 30);
        assert!((campaign.duration_s() - 203.0).abs() < 1e-12);
    }
}
