//! Where base and tool are: printed with their intervals, and no reason to write nothing.

use crate::folder::Folder;

/// Poses alone, as of hand and eye: three slides and three turns that are exact.
const POSES: &str = "name = \"poses\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n\
    [[joints]]\nname = \"ax\"\ntype = \"prismatic\"\nlimits = [-250, 250]\norigin = { axis = [1, 0, 0] }\n\
    [[joints]]\nname = \"ay\"\ntype = \"prismatic\"\nlimits = [-250, 250]\norigin = { axis = [0, 1, 0] }\n\
    [[joints]]\nname = \"az\"\ntype = \"prismatic\"\nlimits = [-250, 250]\norigin = { axis = [0, 0, 1] }\n\
    [[joints]]\nname = \"cz_turn\"\nlimits = [-45, 45]\norigin = { axis = [0, 0, 1] }\n\
    [[joints]]\nname = \"cy_turn\"\nlimits = [-45, 45]\norigin = { axis = [0, 1, 0] }\n\
    [[joints]]\nname = \"cx_turn\"\nlimits = [-45, 45]\norigin = { axis = [1, 0, 0] }\n";

#[test]
fn hand_and_eye_have_their_places_with_intervals() {
    let folder = Folder::empty();
    let truth = [[140.0, 260.0, -830.0], [-35.0, 15.0, 90.0]];
    folder.write(
        "true.toml",
        &format!(
            "{POSES}[base]\nxyz = {:?}\nrpy = [10, -5, 60]\n[tool]\nxyz = {:?}\nrpy = [4, 80, -20]\n",
            truth[0], truth[1]
        ),
    );
    folder.write("robot.toml", &format!("{POSES}[base]\nknown = false\n[tool]\nknown = false\n"));
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\nframes = [\"base\", \"tool\"]\n");
    for seed in 1..5 {
        folder.write(
            "plant.toml",
            &format!(
                "robot = \"true.toml\"\nseed = {seed}\n[instrument]\nsd_um = 1800\norientation_urad = 900\n\
                 [campaign]\npostures = \"random\"\nvisits = 30\n"
            ),
        );
        folder.run("simulate --plant plant.toml --out data.csv").ended(0);
        let identify = ["identify", "--robot", "robot.toml", "--data", "data.csv", "--model", "model.toml"];
        let out = folder.run(&identify).ended(0).out;
        let all = [&identify[..], &["--out", "fit.json", "--parameters", "p.csv"]].concat();
        folder.run(&all).ended(0);
        for (part, truth) in ["base", "tool"].into_iter().zip(truth) {
            let line = out.lines().find(|line| line.trim_start().starts_with(&format!("{part} ")));
            let words: Vec<&str> = line.unwrap_or_else(|| panic!("{out}")).split_whitespace().collect();
            assert_eq!(words.len(), 1 + 6 * 3, "{words:?}");
            for (k, truth) in truth.iter().enumerate() {
                let [value, sign, half] = words[1 + 3 * k..4 + 3 * k] else { panic!("{words:?}") };
                let (value, half): (f64, f64) = (value.parse().unwrap(), half.parse().unwrap());
                // Two of these intervals: one in 10 000 is beyond it.
                assert!(sign == "±" && (value - truth).abs() < 2.0 * half && half < 3.0, "{part}: {words:?}");
            }
        }
        let table = folder.read("p.csv");
        assert!(table.lines().any(|line| line.starts_with("base,x,mm,")), "{table}");
        for format in ["urdf", "ros", "parameters"] {
            folder.run(&["export", "--fit", "fit.json", "--format", format, "--out", "o"]).ended(0);
        }
    }
}
