//! Statistics of errors in the units that people read.

use serde::{Deserialize, Serialize};
use truepose_identify::Spread;

/// Statistics of 3-D position errors, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PositionStatistics {
    /// How many rows.
    pub count: usize,
    /// Mean distance.
    pub mean_mm: f64,
    /// Root mean square distance.
    pub rms_mm: f64,
    /// Its 95 % interval: bootstrap over configurations, of held-out rows only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ci95_mm: Option<[f64; 2]>,
    /// 95 % of the distances are below.
    pub p95_mm: f64,
    /// Largest distance.
    pub max_mm: f64,
}

/// Statistics of orientation errors, mrad.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct OrientationStatistics {
    /// How many rows.
    pub count: usize,
    /// Mean angle.
    pub mean_mrad: f64,
    /// Root mean square angle.
    pub rms_mrad: f64,
    /// 95 % of the angles are below.
    pub p95_mrad: f64,
    /// Largest angle.
    pub max_mrad: f64,
}

impl From<Spread> for PositionStatistics {
    fn from(s: Spread) -> Self {
        PositionStatistics {
            count: s.count,
            mean_mm: s.mean * 1e3,
            rms_mm: s.rms * 1e3,
            ci95_mm: None,
            p95_mm: s.p95 * 1e3,
            max_mm: s.max * 1e3,
        }
    }
}

impl From<Spread> for OrientationStatistics {
    fn from(s: Spread) -> Self {
        OrientationStatistics {
            count: s.count,
            mean_mrad: s.mean * 1e3,
            rms_mrad: s.rms * 1e3,
            p95_mrad: s.p95 * 1e3,
            max_mrad: s.max * 1e3,
        }
    }
}

impl PositionStatistics {
    /// With the 95 % interval of the RMS, m.
    pub(crate) fn with_interval(self, ci95: Option<[f64; 2]>) -> Self {
        PositionStatistics { ci95_mm: ci95.map(|ends| ends.map(|end| 1e3 * end)), ..self }
    }

    /// RMS with its interval, e.g. `0.126 mm (0.095 to 0.18)`.
    pub(crate) fn rms_text(&self) -> String {
        format!("{} mm{}", crate::significant(self.rms_mm, 3), interval_text(self.ci95_mm))
    }

    /// Mean, RMS, 95 % and maximum, as cells of a table.
    pub fn cells(&self) -> Vec<String> {
        cells(self.rms_mm, [self.mean_mm, self.rms_mm, self.p95_mm, self.max_mm])
    }
}

impl OrientationStatistics {
    /// Mean, RMS, 95 % and maximum, as cells of a table.
    pub fn cells(&self) -> Vec<String> {
        cells(self.rms_mrad, [self.mean_mrad, self.rms_mrad, self.p95_mrad, self.max_mrad])
    }
}

/// All values with as many decimals as give the RMS four significant digits.
fn cells(rms: f64, values: [f64; 4]) -> Vec<String> {
    let magnitude = if rms > 0.0 { rms.log10().floor() } else { 0.0 };
    if !(-5.0..6.0).contains(&magnitude) {
        return values.iter().map(|v| crate::significant(*v, 4)).collect();
    }
    let decimals = (3.0 - magnitude).max(0.0) as usize;
    let zero = 0.5 * 10f64.powi(-(decimals as i32));
    values.iter().map(|v| format!("{:.decimals$}", if v.abs() < zero { 0.0 } else { *v })).collect()
}

/// An interval behind a figure, e.g. ` (0.095 to 0.18)`; nothing without one.
pub(crate) fn interval_text(ends: Option<[f64; 2]>) -> String {
    ends.map_or_else(String::new, |[lower, upper]| {
        format!(" ({} to {})", crate::significant(lower, 2), crate::significant(upper, 2))
    })
}
