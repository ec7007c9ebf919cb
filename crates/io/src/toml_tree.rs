//! A TOML document with the place of each value.

use crate::IoError;
use crate::nearest::{listed, meant};
use crate::text::Text;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// No number of a description is larger: squares and sums of such numbers are still numbers.
const LARGEST: f64 = 1e30;

/// A parsed document.
pub(crate) struct Document<'a> {
    text: &'a Text,
    root: Spanned<DeTable<'a>>,
}

/// A table of the document.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    text: &'a Text,
    at: usize,
    /// As messages call it: `[units]`, `[[joints]] 2`, `the robot`.
    name: String,
    table: &'a DeTable<'a>,
}

/// A value of a table.
#[derive(Clone)]
pub(crate) struct Value<'a> {
    text: &'a Text,
    at: usize,
    /// As messages call it: `` `limits` of [[joints]] 2 ``.
    name: String,
    value: &'a DeValue<'a>,
}

impl<'a> Document<'a> {
    pub fn parse(text: &'a Text) -> Result<Self, IoError> {
        match DeTable::parse(&text.text) {
            Ok(root) => Ok(Document { text, root }),
            Err(error) => {
                let at = error.span().map_or(0, |span| span.start);
                Err(text.error(at, format!("is not TOML: {}", error.message().replace('\n', "; "))))
            }
        }
    }

    /// The outermost table; `name` is what messages call it.
    pub fn root(&'a self, name: &str) -> Table<'a> {
        Table { text: self.text, at: 0, name: name.into(), table: self.root.get_ref() }
    }
}

impl<'a> Table<'a> {
    /// Refuses keys that are not among the known ones, naming the nearest.
    pub fn only(&self, known: &[&str]) -> Result<(), IoError> {
        for key in self.table.keys() {
            let word: &str = key.get_ref();
            if !known.contains(&word) {
                let hint = meant(word, known.iter().copied());
                let message =
                    format!("unknown key `{word}` in {}{hint} (known: {})", self.name, known.join(", "));
                return Err(self.text.error(key.span().start, message));
            }
        }
        Ok(())
    }

    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        let value = self.table.get(key)?;
        Some(Value {
            text: self.text,
            at: value.span().start,
            name: format!("`{key}` of {}", self.name),
            value: value.get_ref(),
        })
    }

    pub fn require(&self, key: &str) -> Result<Value<'a>, IoError> {
        self.get(key).ok_or_else(|| self.error(format!("{} lacks `{key}`; add it", self.name)))
    }

    /// The keys, as they stand in the file.
    pub fn keys(&self) -> impl Iterator<Item = &'a str> {
        self.table.keys().map(|key| &**key.get_ref())
    }

    /// An error at a key.
    pub fn error_at_key(&self, key: &str, message: impl Into<String>) -> IoError {
        let at = self.table.get_key_value(key).map_or(self.at, |(key, _)| key.span().start);
        self.text.error(at, message)
    }

    pub fn error(&self, message: impl Into<String>) -> IoError {
        self.text.error(self.at, message)
    }

    pub fn name(&self) -> &str {
        &self.name
    }
}

impl<'a> Value<'a> {
    pub fn error(&self, message: impl Into<String>) -> IoError {
        self.text.error(self.at, message)
    }

    fn not(&self, wanted: &str) -> IoError {
        self.error(format!("{} has to be {wanted}, not {}", self.name, article(self.value.type_str())))
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64, IoError> {
        match self.any_number()? {
            Some(number) if number.abs() > LARGEST && number.is_finite() => {
                Err(self.error(format!("{} is not plausible: {number:e}", self.name)))
            }
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(format!("{} has to be a finite number", self.name))),
        }
    }

    /// A number that may be `inf` or `-inf`.
    pub fn bound(&self) -> Result<f64, IoError> {
        match self.any_number()? {
            Some(number) if !number.is_nan() => Ok(number),
            _ => Err(self.error(format!("{} has to be a number, inf or -inf", self.name))),
        }
    }

    fn any_number(&self) -> Result<Option<f64>, IoError> {
        match self.value {
            DeValue::Integer(integer) => {
                Ok(i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|v| v as f64))
            }
            DeValue::Float(float) => Ok(float.as_str().parse::<f64>().ok()),
            _ => Err(self.not("a number")),
        }
    }

    pub fn string(&self) -> Result<&'a str, IoError> {
        self.value.as_str().ok_or_else(|| self.not("a text in quotes"))
    }

    pub fn boolean(&self) -> Result<bool, IoError> {
        self.value.as_bool().ok_or_else(|| self.not("true or false"))
    }

    /// One word of several.
    pub fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, IoError> {
        let word = self.string()?;
        words.iter().find(|(known, _)| *known == word).map(|(_, value)| *value).ok_or_else(|| {
            let known = words.iter().map(|(known, _)| *known);
            let hint = meant(word, known.clone());
            self.error(format!("{} cannot be `{word}`{hint} (known: {})", self.name, listed(known)))
        })
    }

    /// An array of `N` finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N], IoError> {
        let wanted = format!("an array of {N} numbers");
        let array = self.elements(&wanted)?;
        if array.len() != N {
            return Err(self.error(format!("{} has to be {wanted}, not {}", self.name, array.len())));
        }
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(array) {
            *number = value.number()?;
        }
        Ok(numbers)
    }

    /// The elements of an array.
    pub fn elements(&self, wanted: &str) -> Result<Vec<Value<'a>>, IoError> {
        let array = self.value.as_array().ok_or_else(|| self.not(wanted))?;
        let element = |(k, value): (usize, &'a Spanned<DeValue<'a>>)| Value {
            text: self.text,
            at: value.span().start,
            name: format!("element {} of {}", k + 1, self.name),
            value: value.get_ref(),
        };
        Ok(array.iter().enumerate().map(element).collect())
    }

    pub fn is_string(&self) -> bool {
        self.value.is_str()
    }

    /// A table; `name` is what messages call it.
    pub fn table(&self, name: &str) -> Result<Table<'a>, IoError> {
        let table = self.value.as_table().ok_or_else(|| self.not("a table"))?;
        Ok(Table { text: self.text, at: self.at, name: name.into(), table })
    }

    /// An array of tables: `[[name]]`.
    pub fn tables(&self, name: &str) -> Result<Vec<Table<'a>>, IoError> {
        let wanted = format!("an array of tables, each headed by [[{name}]]");
        let elements = self.elements(&wanted)?;
        elements
            .into_iter()
            .enumerate()
            .map(|(k, element)| match element.value.as_table() {
                Some(_) => element.table(&format!("[[{name}]] {}", k + 1)),
                None => Err(element.not("a table")),
            })
            .collect()
    }

    pub fn is_array(&self) -> bool {
        self.value.is_array()
    }

    pub fn is_table(&self) -> bool {
        self.value.is_table()
    }

    /// A text, number or truth value as JSON.
    pub fn scalar(&self) -> Result<serde_json::Value, IoError> {
        Ok(match self.value {
            DeValue::String(text) => text.to_string().into(),
            DeValue::Boolean(value) => (*value).into(),
            DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
                Ok(value) => value.into(),
                Err(_) => self.number()?.into(),
            },
            DeValue::Float(_) => self.number()?.into(),
            _ => return Err(self.not("a number or a text")),
        })
    }

    /// As messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }
}

fn article(kind: &str) -> String {
    let article = if kind.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {kind}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(content: &str) -> Text {
        Text { file: "r.toml".into(), text: content.into() }
    }

    #[test]
    fn every_complaint_has_a_place() {
        let source = text("name = \"a\"\n[units]\nlenght = \"mm\"\nn = [1, 2, nan]\nk = \"s\"\n");
        let document = Document::parse(&source).unwrap();
        let root = document.root("the robot");
        let units = root.get("units").unwrap().table("[units]").unwrap();
        let say = |error: IoError| error.to_string();
        assert_eq!(
            say(units.only(&["length", "angle", "n", "k"]).unwrap_err()),
            "r.toml:3:1: unknown key `lenght` in [units]; did you mean `length`? (known: length, angle, n, k)"
        );
        let n = units.get("n").unwrap();
        assert_eq!(
            say(n.numbers::<3>().unwrap_err()),
            "r.toml:4:12: element 3 of `n` of [units] has to be a finite number"
        );
        assert_eq!(
            say(n.numbers::<2>().unwrap_err()),
            "r.toml:4:5: `n` of [units] has to be an array of 2 numbers, not 3"
        );
        assert_eq!(
            say(units.get("k").unwrap().number().unwrap_err()),
            "r.toml:5:5: `k` of [units] has to be a number, not a string"
        );
        assert_eq!(
            say(units.get("k").unwrap().word(&[("m", 1), ("mm", 2)]).unwrap_err()),
            "r.toml:5:5: `k` of [units] cannot be `s` (known: m, mm)"
        );
        assert!(say(root.require("joints").err().unwrap()).ends_with("the robot lacks `joints`; add it"));
    }

    #[test]
    fn broken_documents_are_reported() {
        for broken in ["a = \n", "a = 1\na = 2\n", "[x\n", &"[".repeat(100_000), "a = 'x"] {
            let message = Document::parse(&text(broken)).err().unwrap().to_string();
            assert!(message.starts_with("r.toml:") && message.contains(": is not TOML: "), "{message}");
        }
    }
}
