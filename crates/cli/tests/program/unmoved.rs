//! A model that nothing moves: no coefficient has a scatter, and every verb ends with a result or an error.

use crate::folder::Folder;

#[test]
fn a_fit_of_a_compliance_without_a_load_is_carried_on_and_watched() {
    let folder = Folder::with_data();
    folder.write("m.toml", "[[effects]]\nfamily = \"joint_compliance\"\njoints = [\"j1\"]\n");
    let identify = "identify --robot robot.toml --data data.csv --model m.toml";
    folder.run(&format!("{identify} --out fit.json")).ended(0);
    let used = ["--fit", "fit.json", "--data", "data.csv"];
    folder.run(&[&["monitor"], &used[..]].concat()).ended(0);
    folder.run(&[&["transfer", "--out", "moved.json"], &used[..]].concat()).ended(0);
    folder.run("plan --for monitor --fit fit.json --out plan.csv").ended(0);
    folder.run("plan --for transfer --fit fit.json --out plan.csv").ended(0);
}
