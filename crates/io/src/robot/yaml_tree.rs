//! Mappings and scalars of a YAML file, with their lines: all that a kinematics file has.

use crate::IoError;
use crate::text::Text;
use saphyr_parser::{Event, Parser};

/// Mappings in mappings of a kinematics file are three.
const DEEPEST: usize = 16;

/// A value, and its line from 1.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub(super) line: u64,
    pub(super) value: Value,
}

#[derive(Debug, Clone)]
pub(super) enum Value {
    Scalar(String),
    Mapping(Vec<(String, Node)>),
    /// None of a kinematics file has one.
    List,
}

/// What is being filled.
enum Open {
    Mapping(Vec<(String, Node)>, Option<String>),
    List,
}

impl Node {
    /// The one document of a file.
    ///
    /// # Errors
    /// When it is no YAML, has several documents, or refers to other places of itself.
    pub(super) fn parse(text: &Text) -> Result<Node, IoError> {
        let at = |line: u64, message: &str| IoError::line(&text.file, line, message.to_owned());
        let mut open: Vec<(u64, Open)> = Vec::new();
        let mut whole: Option<Node> = None;
        for event in Parser::new_from_str(&text.text) {
            let (event, span) = event.map_err(|error| at(error.marker().line() as u64, error.info()))?;
            let line = span.start.line() as u64;
            let done = match event {
                Event::MappingStart(..) => {
                    open.push((line, Open::Mapping(Vec::new(), None)));
                    None
                }
                Event::SequenceStart(..) => {
                    open.push((line, Open::List));
                    None
                }
                Event::Scalar(value, ..) => Some(Node { line, value: Value::Scalar(value.into_owned()) }),
                Event::MappingEnd | Event::SequenceEnd => open.pop().map(|(line, open)| Node {
                    line,
                    value: match open {
                        Open::Mapping(entries, _) => Value::Mapping(entries),
                        Open::List => Value::List,
                    },
                }),
                Event::Alias(_) => {
                    return Err(at(line, "refers to another place of the file (`*`); write the value out"));
                }
                Event::DocumentStart(_) if whole.is_some() => {
                    return Err(at(line, "a second document begins here; a kinematics file has one"));
                }
                _ => None,
            };
            if open.len() > DEEPEST {
                return Err(at(line, "is nested deeper than a kinematics file"));
            }
            let Some(node) = done else { continue };
            match open.last_mut() {
                None => whole = Some(node),
                Some((_, Open::List)) => {}
                Some((_, Open::Mapping(entries, key))) => match (key.take(), node.value) {
                    (None, Value::Scalar(name)) => {
                        if entries.iter().any(|(other, _)| *other == name) {
                            return Err(at(line, &format!("`{name}` is there twice")));
                        }
                        *key = Some(name);
                    }
                    (None, _) => return Err(at(line, "a key is a word")),
                    (Some(name), value) => entries.push((name, Node { line: node.line, value })),
                },
            }
        }
        whole.ok_or_else(|| IoError::file(&text.file, "is empty"))
    }

    pub(super) fn get(&self, key: &str) -> Option<&Node> {
        match &self.value {
            Value::Mapping(entries) => entries.iter().find(|(name, _)| name == key).map(|(_, node)| node),
            _ => None,
        }
    }

    pub(super) fn word(&self) -> Option<&str> {
        match &self.value {
            Value::Scalar(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        self.word()?.parse::<f64>().ok().filter(|value| value.is_finite())
    }
}
