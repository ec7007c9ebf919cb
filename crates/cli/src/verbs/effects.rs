//! `truepose effects`: what can be declared.

use super::print_json;
use crate::args::Effects;
use crate::extensions::{effects, own_solvers};
use crate::failure::Failure;
use crate::terminal;
use truepose_errormodel::EffectRegistry;
use truepose_report::Alignment::Left;
use truepose_report::{explanation, table};
use truepose_solvers::SolverSpec;

/// Runs the verb.
pub fn run(args: &Effects) -> Result<(), Failure> {
    let registry = effects();
    if let Some(family) = &args.family {
        return one(args, registry, family);
    }
    let mut solvers = SolverSpec::known();
    solvers.extend(own_solvers().map(|name| (name, "a solver of this program's own")));
    if args.json {
        let effects: Vec<_> = registry.kinds().map(|(kind, about)| summary(kind, about)).collect();
        let solvers: Vec<_> =
            solvers.iter().map(|(n, about)| serde_json::json!({"name": n, "about": about})).collect();
        return print_json(&serde_json::json!({"effects": effects, "solvers": solvers}));
    }
    let rows = |pairs: Vec<(&str, &str)>| -> Vec<Vec<String>> {
        pairs.into_iter().map(|(name, about)| vec![name.to_string(), about.to_string()]).collect()
    };
    terminal::print("effects, for `family` in a model file\n");
    terminal::print(&table(&["family", "what it is"], &[Left, Left], &rows(registry.kinds().collect())));
    terminal::print("\nan example of each; `truepose effects FAMILY` explains one in depth\n");
    let examples = registry.kinds().filter_map(|(kind, _)| Some((kind, explanation(kind)?.example)));
    terminal::print(&table(&["family", "example"], &[Left, Left], &rows(examples.collect())));
    terminal::print("\nsolvers, for --solver\n");
    terminal::print(&table(&["name", "what it does"], &[Left, Left], &rows(solvers)));
    Ok(())
}

fn summary(kind: &str, about: &str) -> serde_json::Value {
    let example = explanation(kind).map(|known| known.example);
    serde_json::json!({"family": kind, "about": about, "example": example})
}

/// One family in depth.
fn one(args: &Effects, registry: &EffectRegistry, family: &str) -> Result<(), Failure> {
    let Some((kind, about)) = registry.kinds().find(|(kind, _)| *kind == family) else {
        let known: Vec<&str> = registry.kinds().map(|(kind, _)| kind).collect();
        return Err(Failure::Input(format!("no family `{family}`; there are: {}", known.join(", "))));
    };
    let text = explanation(kind).map(|known| known.text);
    if args.json {
        let mut json = summary(kind, about);
        json["explanation"] = text.into();
        return print_json(&json);
    }
    terminal::print(&format!("{kind}: {about}\n"));
    if let Some(text) = text {
        terminal::print(&format!("\n{text}"));
    }
    Ok(())
}
