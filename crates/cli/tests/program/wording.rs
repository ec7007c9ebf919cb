//! Words that the program, its report and its README do not use, because the field has standard terms for them.

use crate::folder::Folder;
use crate::output::example;
use std::path::Path;

/// Words that are not used, and the term that replaces each.
const REPLACED: [(&str, &str); 62] = [
    ("normal law", "normal distribution"),
    ("surprise", "surprisal, −log p"),
    ("surprising", "surprisal, −log p"),
    ("share", "fraction"),
    ("shares", "fractions"),
    ("odds", "log prior odds, in the documentation of the method only"),
    ("worth", "accuracy, expected information"),
    ("measured number", "scalar observation"),
    ("measured numbers", "scalar observations"),
    ("visit", "pose measurement"),
    ("visits", "pose measurements"),
    ("visited", "measured"),
    ("standstill", "dwell"),
    ("standstills", "dwells"),
    ("play", "backlash"),
    ("gears", "transmission"),
    ("rail", "linear guideway"),
    ("rails", "linear guideways"),
    ("spring", "compliance"),
    ("springs", "compliance"),
    ("yields", "deflects; compliance"),
    ("settle", "decide; converge"),
    ("settles", "decides; converges"),
    ("at rest", "in static equilibrium"),
    ("expected size", "prior standard deviation"),
    ("expected sizes", "prior standard deviations"),
    ("held to", "shrunk towards"),
    ("held against", "compared with"),
    ("hold against", "compare with"),
    ("rounds", "iterations"),
    ("looked at", "checked"),
    ("says", "states, reports"),
    ("said", "reported"),
    ("say", "state, report"),
    ("tells", "determines"),
    ("told", "determined"),
    ("heard", "accumulated"),
    ("asks", "requires"),
    ("speaks", "supports"),
    ("ledger", "report"),
    ("a find", "finding"),
    ("finds out", "identifies, determines"),
    ("nameless", "unnamed"),
    ("has no name", "unnamed: no named family describes it"),
    ("followed late", "first-order lag"),
    ("floor", "repeatability limit, noise standard deviation"),
    ("rival", "competing hypothesis"),
    ("rivals", "competing hypotheses"),
    ("told apart", "distinguished"),
    ("tell apart", "distinguish"),
    ("told from", "distinguished from"),
    ("set-up", "installation: base, tool and target frames"),
    ("drives", "executes commands"),
    ("driven", "executing commands"),
    ("took part in nothing", "held-out test set"),
    ("takes part in nothing", "held-out test set"),
    ("locked away", "held-out test set"),
    ("chance", "significance"),
    ("is left", "residual; remaining error"),
    ("was believed", "was added"),
    ("what it has seen", "training data"),
    ("turning joint", "revolute joint"),
];

/// Where a word is part of a published name, or used in its ordinary sense.
const EXCEPTIONS: [(&str, &str); 7] = [
    ("column `visit`", "the published name of a column of measurements"),
    ("target,visit,payload", "the header of a table of measurements"),
    ("--rivals", "the published name of an option"),
    ("--rival", "the published name of an option"),
    ("--rounds", "the published name of an option"),
    ("<ROUNDS>", "the value of that option"),
    ("wrist gears", "a machine element, not the name of a model"),
];

/// Lines that use a replaced word, with the word and its replacement.
fn faults(text: &str) -> Vec<String> {
    let mut clean = text.to_owned();
    for (exception, _) in EXCEPTIONS {
        clean = clean.replace(exception, "");
    }
    let mut found = Vec::new();
    for line in clean.lines() {
        let words: String = line
            .to_lowercase()
            .chars()
            .map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { ' ' })
            .collect();
        let words = format!(" {} ", words.split_whitespace().collect::<Vec<_>>().join(" "));
        for (word, term) in REPLACED {
            if words.contains(&format!(" {word} ")) {
                found.push(format!("`{word}` (use: {term}) in: {}", line.trim()));
            }
        }
    }
    found
}

/// The text of a page: without style, script, attributes and tags.
fn text_of(html: &str) -> String {
    let mut text = html.to_owned();
    for element in ["style", "script", "svg"] {
        while let Some(begin) = text.find(&format!("<{element}")) {
            let closing = format!("</{element}>");
            let end = text[begin..].find(&closing).map_or(text.len(), |end| begin + end + closing.len());
            text.replace_range(begin..end, "\n");
        }
    }
    let mut plain = String::new();
    let mut in_tag = false;
    for c in text.chars() {
        match c {
            '<' => in_tag = true,
            '>' => {
                in_tag = false;
                plain.push('\n');
            }
            _ if !in_tag => plain.push(c),
            _ => {}
        }
    }
    plain
}

#[test]
fn a_replaced_word_is_found_and_an_exception_is_not() {
    assert_eq!(faults("Two visits.\nThe column `visit`; shared; a floor-plan.").len(), 1);
    assert_eq!(text_of("<p class=\"share\">a<b>b</b></p><script>share</script>").trim(), "a\nb");
}

#[test]
fn help_uses_the_terms_of_the_field() {
    let folder = Folder::empty();
    let mut text = folder.run("--help").ended(0).out;
    for verb in [
        "identify",
        "discover",
        "plan",
        "predict",
        "compensate",
        "export",
        "map",
        "compare",
        "check",
        "effects",
        "simulate",
        "verify",
    ] {
        text += &folder.run(&[verb, "--help"]).ended(0).out;
    }
    let faults = faults(&text);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn identify_and_discover_use_the_terms_of_the_field() {
    let folder = Folder::empty();
    let (robot, data, model) = (example("robot.toml"), example("measurements.csv"), example("model.toml"));
    for verb in ["identify", "discover"] {
        let files = [verb, "--robot", &robot, "--data", &data, "--model", &model, "--out", "fit.json"];
        let short = ["--most", "1", "--rotations", "99"];
        let short = if verb == "discover" && !cfg!(feature = "slow") { &short[..] } else { &[] };
        let run = folder
            .run(
                &[&files[..], &["--report", verb, "--spec", "0.4mm", "--correction", "commands"], short]
                    .concat(),
            )
            .ended(0);
        let page = text_of(&folder.read(&format!("{verb}/index.html")));
        let faults = faults(&format!("{}\n{}\n{page}", run.out, run.log));
        assert!(faults.is_empty(), "{verb}:\n{}", faults.join("\n"));
    }
    let plan = folder.run("plan --fit fit.json --out plan.csv --count 5").ended(0);
    let predict = folder.run(&["predict", "--fit", "fit.json", "--data", &data, "--out", "p.csv"]).ended(0);
    let faults = faults(&format!("{}\n{}\n{}\n{}", plan.out, plan.log, predict.out, predict.log));
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_readme_uses_the_terms_of_the_field() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let faults = faults(&std::fs::read_to_string(file).unwrap());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
