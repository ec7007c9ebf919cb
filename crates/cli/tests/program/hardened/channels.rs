//! A controller may log one temperature under two hundred names.

use crate::folder::Folder;

#[test]
fn equal_and_constant_channels_are_one_channel() {
    let folder = Folder::with_data();
    let data = folder.read("data.csv");
    let with = |count: usize| {
        let row = |(k, line): (usize, &str)| {
            let cell = |c: usize| match (k, c) {
                (0, _) => format!(",c{c}[degC]"),
                // The last ones never change.
                (_, c) if c > 0 && 2 * c >= count => ",21.5".to_owned(),
                (k, _) => format!(",{}", 20.0 + 0.1 * ((k * 37) % 11) as f64),
            };
            format!("{line}{}\n", (0..count).map(cell).collect::<String>())
        };
        data.lines().enumerate().map(row).collect::<String>()
    };
    let discover = |name: &str| {
        let run = "discover --robot robot.toml --flips 599 --json --data";
        let words: Vec<&str> = run.split(' ').chain([name]).collect();
        folder.run(&words).ended(0)
    };
    folder.write("one.csv", &with(1));
    folder.write("many.csv", &with(200));
    let one = discover("one.csv");
    let many = discover("many.csv");
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    // The same candidates, and so the same findings, competing hypotheses and probabilities.
    assert_eq!(json(&one.out), json(&many.out));
    let words =
        "many.csv: channel `c1` has the values of `c0`, and 197 more: equal channels are tested as one";
    assert!(many.log.contains(words), "{}", many.log);
}
