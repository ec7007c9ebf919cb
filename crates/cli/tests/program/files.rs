//! No run writes over what it reads, whichever argument names it.

use crate::folder::{Folder, ROBOT};

#[test]
fn a_plan_is_not_written_over_what_it_is_made_from() {
    let folder = Folder::with_data();
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n");
    let plan = ["plan", "--observe", "robot.toml", "--model", "model.toml", "--among", "data.csv", "--out"];
    for (out, option) in [
        ("robot.toml", "--observe"),
        ("model.toml", "--model"),
        ("data.csv", "--among"),
        ("./../{}/data.csv", "--among"),
    ] {
        let name = folder.path().file_name().unwrap().to_string_lossy().into_owned();
        let out = out.replace("{}", &name);
        let before: Vec<String> =
            ["robot.toml", "model.toml", "data.csv"].iter().map(|file| folder.read(file)).collect();
        let log = folder.run(&[&plan[..], &[&out]].concat()).ended(2).log;
        assert!(log.contains(&format!("is what {option} reads, and would be overwritten")), "{log}");
        let after: Vec<String> =
            ["robot.toml", "model.toml", "data.csv"].iter().map(|file| folder.read(file)).collect();
        assert_eq!(before, after);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("data.csv", folder.file("link.csv")).unwrap();
        let log = folder.run(&[&plan[..], &["link.csv"]].concat()).ended(2).log;
        assert!(log.contains("is what --among reads"), "{log}");
    }
}

#[test]
fn the_urdf_of_an_observed_robot_is_not_written_over() {
    let folder = Folder::with_data();
    folder.write("arm.urdf", "<robot name=\"r\"/>");
    folder.write("cell.toml", &format!("urdf = \"arm.urdf\"\n{ROBOT}"));
    folder.write("model.toml", "[[effects]]\nfamily = \"geometric\"\n");
    let plan = "plan --observe cell.toml --model model.toml --out arm.urdf";
    let log = folder.run(plan).ended(2).log;
    assert!(log.contains("`arm.urdf` is what the robot's `urdf` reads"), "{log}");
}
