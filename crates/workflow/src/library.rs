//! Robots that the program brings along: nominal dimensions as their makers publish them, one description a robot.
//!
//! A file names its robot in its first line and the source in the second.

/// A robot of the library.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// Its word on the command line.
    pub name: &'static str,
    /// The description, as a robot file.
    pub text: &'static str,
}

macro_rules! robot {
    ($name:literal) => {
        Known {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/", $name, ".toml")),
        }
    };
}

/// All of them, by maker.
pub const ROBOTS: [Known; 31] = [
    robot!("ur3"),
    robot!("ur5"),
    robot!("ur10"),
    robot!("ur3e"),
    robot!("ur5e"),
    robot!("ur10e"),
    robot!("ur16e"),
    robot!("ur20"),
    robot!("ur30"),
    robot!("panda"),
    robot!("fr3"),
    robot!("iiwa7"),
    robot!("iiwa14"),
    robot!("kr6-r900-2"),
    robot!("kr10-r1100-sixx"),
    robot!("kr16-r2010-2"),
    robot!("irb120"),
    robot!("irb1200-5-0.9"),
    robot!("irb2600-12-1.65"),
    robot!("irb4600-60-2.05"),
    robot!("lrmate200id"),
    robot!("m20ia"),
    robot!("gp7"),
    robot!("gp12"),
    robot!("gp25"),
    robot!("tx2-60"),
    robot!("tx2-60l"),
    robot!("tx2-90"),
    robot!("xarm6"),
    robot!("xarm7"),
    robot!("meca500"),
];

impl Known {
    /// Maker and model.
    pub fn title(&self) -> &'static str {
        self.text.lines().next().map_or("", |line| line.trim_start_matches('#').trim())
    }

    /// The robot of this word, whatever its case.
    pub fn named(word: &str) -> Option<Known> {
        ROBOTS.into_iter().find(|robot| robot.name.eq_ignore_ascii_case(word))
    }

    /// Words that contain this one, or begin as it does.
    pub fn near(word: &str) -> Vec<&'static str> {
        let word = word.to_lowercase();
        let all = || ROBOTS.iter().map(|robot| robot.name);
        let inside = |part: &str| -> Vec<&'static str> { all().filter(|name| name.contains(part)).collect() };
        // The longest beginning that some name contains.
        let ends = (2..=word.len()).rev().filter(|&end| word.is_char_boundary(end));
        ends.map(|end| inside(&word[..end])).find(|found| !found.is_empty()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
