//! Units: where numbers enter or leave, and nowhere else.
//!
//! `SI = value · multiply / divide + offset`. A division by 1000 is exact to the last bit where a
//! multiplication by 0.001 is not, so that `9 mm` is `0.009 m`.

use std::f64::consts::PI;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// m, mm, um, in.
    Length,
    /// rad, deg, mrad.
    Angle,
    /// N, kN, lbf.
    Force,
    /// N*m.
    Moment,
    /// kg, lb.
    Mass,
    /// s, min, h.
    Time,
    /// degC, K; in memory degC.
    Temperature,
    /// 1, %.
    Ratio,
    /// px.
    Pixels,
}

impl Quantity {
    /// The word for it in messages.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::Length => "a length",
            Quantity::Angle => "an angle",
            Quantity::Force => "a force",
            Quantity::Moment => "a moment",
            Quantity::Mass => "a mass",
            Quantity::Time => "a time",
            Quantity::Temperature => "a temperature",
            Quantity::Ratio => "a plain number",
            Quantity::Pixels => "a place in an image",
        }
    }

    /// The unit in memory.
    pub fn si(self) -> &'static Unit {
        // The first of each quantity in the table is the one in memory.
        UNITS.iter().find(|unit| unit.quantity == self).unwrap_or(&UNITS[0])
    }

    /// The words of all its units.
    pub fn units(self) -> impl Iterator<Item = &'static str> {
        UNITS.iter().filter(move |unit| unit.quantity == self).map(|unit| unit.word)
    }
}

/// A unit that files may use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its word in files.
    pub word: &'static str,
    /// What it measures.
    pub quantity: Quantity,
    multiply: f64,
    divide: f64,
    offset: f64,
}

const fn unit(word: &'static str, quantity: Quantity, multiply: f64, divide: f64, offset: f64) -> Unit {
    Unit { word, quantity, multiply, divide, offset }
}

static UNITS: [Unit; 24] = [
    unit("m", Quantity::Length, 1.0, 1.0, 0.0),
    unit("mm", Quantity::Length, 1.0, 1e3, 0.0),
    unit("um", Quantity::Length, 1.0, 1e6, 0.0),
    unit("in", Quantity::Length, 0.0254, 1.0, 0.0),
    unit("rad", Quantity::Angle, 1.0, 1.0, 0.0),
    unit("deg", Quantity::Angle, PI / 180.0, 1.0, 0.0),
    unit("mrad", Quantity::Angle, 1.0, 1e3, 0.0),
    unit("N", Quantity::Force, 1.0, 1.0, 0.0),
    unit("kN", Quantity::Force, 1e3, 1.0, 0.0),
    unit("lbf", Quantity::Force, 4.448_221_615_260_5, 1.0, 0.0),
    unit("N*m", Quantity::Moment, 1.0, 1.0, 0.0),
    unit("kg", Quantity::Mass, 1.0, 1.0, 0.0),
    unit("lb", Quantity::Mass, 0.453_592_37, 1.0, 0.0),
    unit("s", Quantity::Time, 1.0, 1.0, 0.0),
    unit("ms", Quantity::Time, 1.0, 1e3, 0.0),
    unit("us", Quantity::Time, 1.0, 1e6, 0.0),
    unit("ns", Quantity::Time, 1.0, 1e9, 0.0),
    unit("min", Quantity::Time, 60.0, 1.0, 0.0),
    unit("h", Quantity::Time, 3600.0, 1.0, 0.0),
    unit("degC", Quantity::Temperature, 1.0, 1.0, 0.0),
    unit("K", Quantity::Temperature, 1.0, 1.0, -273.15),
    unit("1", Quantity::Ratio, 1.0, 1.0, 0.0),
    unit("%", Quantity::Ratio, 1.0, 100.0, 0.0),
    unit("px", Quantity::Pixels, 1.0, 1.0, 0.0),
];

impl Unit {
    /// The unit that files call by this word.
    pub fn named(word: &str) -> Option<&'static Unit> {
        let word = match word {
            "µm" | "μm" | "micron" | "microns" => "um",
            "MM" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
            "meter" | "meters" | "metre" | "metres" => "m",
            "inch" | "inches" => "in",
            "°" | "º" | "Deg" | "DEG" | "degree" | "degrees" | "Degrees" => "deg",
            // In other languages; `grad` in small letters may be a four-hundredth of a turn.
            "Grad" | "degré" | "degrés" | "gradi" | "grados" | "graus" => "deg",
            "Rad" | "RAD" | "radian" | "radians" | "Radians" => "rad",
            "sec" | "second" | "seconds" | "Seconds" => "s",
            "°C" => "degC",
            "Nm" | "N·m" | "N.m" => "N*m",
            other => other,
        };
        UNITS.iter().find(|unit| unit.word == word)
    }

    /// All units that files may use.
    pub fn words() -> impl Iterator<Item = &'static str> {
        UNITS.iter().map(|unit| unit.word)
    }

    /// Whether it is the unit of memory itself.
    pub(crate) fn is_si(&self) -> bool {
        [self.multiply, self.divide, self.offset].map(f64::to_bits) == [1.0_f64, 1.0, 0.0].map(f64::to_bits)
    }

    /// A value in this unit, in the unit of memory.
    #[inline]
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.multiply / self.divide + self.offset
    }

    /// A value of memory, in this unit.
    #[inline]
    pub fn from_si(&self, value: f64) -> f64 {
        (value - self.offset) * self.divide / self.multiply
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact conversions are what is tested
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn exact_where_it_can_be() {
        let si = |word: &str, value: f64| Unit::named(word).unwrap().to_si(value);
        assert_eq!(si("mm", 9.0), 0.009);
        assert_eq!(si("um", 3.0), 3e-6);
        assert_eq!(si("in", 10.0), 0.254);
        assert_eq!(si("deg", 180.0), PI);
        assert_eq!(si("mrad", 2.0), 0.002);
        assert_eq!(si("kN", 2.5), 2500.0);
        assert_eq!(si("lbf", 1.0), 4.4482216152605);
        assert_eq!(si("lb", 2.0), 0.90718474);
        assert_eq!(si("min", 1.5), 90.0);
        assert_eq!(si("h", 0.5), 1800.0);
        assert_eq!(si("K", 273.15), 0.0);
        assert_eq!(si("%", 50.0), 0.5);
        assert!(Unit::named("furlong").is_none());
        assert_eq!(Quantity::Angle.si().word, "rad");
        assert_eq!(Quantity::Length.units().collect::<Vec<_>>(), ["m", "mm", "um", "in"]);
    }

    proptest! {
        #[test]
        fn there_and_back(value in -1e6..1e6f64, k in 0..UNITS.len()) {
            let unit = &UNITS[k];
            let again = unit.from_si(unit.to_si(value));
            prop_assert!((again - value).abs() <= 1e-12 * value.abs().max(1.0), "{} {value} {again}", unit.word);
        }
    }
}
