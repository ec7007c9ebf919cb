//! A struct of documented constants that knows its fields by name: for tables, and for studies that scale one of them.

/// A constant that a study can multiply, and a table can show.
pub(crate) trait Constant {
    /// Times a factor; counts are rounded, and stay one at least.
    fn times(&self, factor: f64) -> Self;
    /// As a table shows it.
    fn text(&self) -> String;
}

impl Constant for f64 {
    fn times(&self, factor: f64) -> Self {
        self * factor
    }
    fn text(&self) -> String {
        self.to_string()
    }
}

impl Constant for usize {
    fn times(&self, factor: f64) -> Self {
        ((*self as f64 * factor).round() as usize).max(1)
    }
    fn text(&self) -> String {
        self.to_string()
    }
}

impl<C: Constant> Constant for Vec<C> {
    fn times(&self, factor: f64) -> Self {
        self.iter().map(|value| value.times(factor)).collect()
    }
    fn text(&self) -> String {
        self.iter().map(Constant::text).collect::<Vec<_>>().join(", ")
    }
}

/// Declares such a struct: each constant with its documentation, type and default.
macro_rules! constants {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $type:ty = $value:expr;)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub struct $name {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                $name { $($field: $value,)* }
            }
        }

        impl $name {
            /// Every constant by name, with its value as text.
            pub fn table(&self) -> Vec<(&'static str, String)> {
                use $crate::constants::Constant;
                vec![$((stringify!($field), self.$field.text()),)*]
            }

            /// The same with one constant multiplied by a factor (counts are rounded, and stay one at least); none when there is no constant
            /// of that name.
            pub fn scaled(&self, constant: &str, factor: f64) -> Option<Self> {
                use $crate::constants::Constant;
                let mut scaled = self.clone();
                match constant {
                    $(stringify!($field) => scaled.$field = self.$field.times(factor),)*
                    _ => return None,
                }
                Some(scaled)
            }
        }
    };
}

pub(crate) use constants;
