//! `truepose effects`: what can be declared.

use super::print_json;
use crate::args::Effects;
use crate::extensions::{effects, own_solvers};
use crate::failure::Failure;
use crate::terminal;
use truepose_report::Alignment::Left;
use truepose_report::table;
use truepose_solvers::SolverSpec;

/// Runs the verb.
pub fn run(args: &Effects) -> Result<(), Failure> {
    let registry = effects();
    let mut solvers = SolverSpec::known();
    solvers.extend(own_solvers().map(|name| (name, "a solver of this program's own")));
    if args.json {
        let effects: Vec<_> =
            registry.kinds().map(|(k, about)| serde_json::json!({"family": k, "about": about})).collect();
        let solvers: Vec<_> =
            solvers.iter().map(|(n, about)| serde_json::json!({"name": n, "about": about})).collect();
        return print_json(&serde_json::json!({"effects": effects, "solvers": solvers}));
    }
    let rows = |pairs: Vec<(&str, &str)>| -> Vec<Vec<String>> {
        pairs.into_iter().map(|(name, about)| vec![name.to_string(), about.to_string()]).collect()
    };
    terminal::print("effects, for `family` in a model file\n");
    terminal::print(&table(&["family", "what it is"], &[Left, Left], &rows(registry.kinds().collect())));
    terminal::print("\nsolvers, for --solver\n");
    terminal::print(&table(&["name", "what it does"], &[Left, Left], &rows(solvers)));
    Ok(())
}
