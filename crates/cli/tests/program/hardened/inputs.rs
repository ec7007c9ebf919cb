//! No file that is read is written over, whether an option names it or another file does.

use crate::folder::Folder;

/// A robot whose joints stand in a URDF.
const BY_URDF: &str = "urdf = \"arm.urdf\"\n[units]\nlength = \"mm\"\nangle = \"deg\"\n\
    [[targets]]\nname = \"T1\"\nxyz = [50, 0, 30]\n[[targets]]\nname = \"T2\"\nxyz = [-20, 60, 0]\n";

fn with_urdf() -> Folder {
    let folder = Folder::with_data();
    let run = |words: &str| folder.run(&words.split(' ').collect::<Vec<_>>()).ended(0);
    run("identify --robot robot.toml --data data.csv --folds 0 --out fit.json");
    run("export --fit fit.json --format urdf --out arm.urdf");
    folder.write("by_urdf.toml", BY_URDF);
    folder.write("plant2.toml", &folder.read("plant.toml").replace("robot.toml", "by_urdf.toml"));
    std::os::unix::fs::symlink("arm.urdf", folder.file("link.urdf")).unwrap();
    folder
}

#[test]
fn the_urdf_that_a_robot_names_is_not_written_over() {
    let folder = with_urdf();
    std::fs::create_dir(folder.file("page")).unwrap();
    for words in [
        "identify --robot by_urdf.toml --data data.csv --out arm.urdf",
        "identify --robot by_urdf.toml --data data.csv --out link.urdf",
        "discover --robot ./by_urdf.toml --data data.csv --out page/../arm.urdf",
        "simulate --plant plant2.toml --out arm.urdf",
        "simulate --plant plant2.toml --out by_urdf.toml",
    ] {
        let before = (folder.names(), folder.read("arm.urdf"), folder.read("by_urdf.toml"));
        let run = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
        assert!(
            run.log.starts_with("error: --out: `") && run.log.contains("would be overwritten"),
            "{}",
            run.log
        );
        assert_eq!((folder.names(), folder.read("arm.urdf"), folder.read("by_urdf.toml")), before, "{words}");
    }
    // Where a report or rivals may take its name.
    for (urdf, words) in [
        ("page/x.svg", "discover --robot by_urdf.toml --data data.csv --report page"),
        ("page/index.html", "identify --robot by_urdf.toml --data data.csv --report page"),
        ("page/1-x.json", "discover --robot by_urdf.toml --data data.csv --rivals page"),
    ] {
        std::fs::copy(folder.file("arm.urdf"), folder.file(urdf)).unwrap();
        folder.write("by_urdf.toml", &BY_URDF.replace("arm.urdf", urdf));
        let run = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
        assert!(run.log.contains("the robot's `urdf`"), "{words}: {}", run.log);
        assert_eq!(folder.read(urdf), folder.read("arm.urdf"));
        std::fs::remove_file(folder.file(urdf)).unwrap();
    }
}

#[test]
fn data_in_the_folder_of_a_report_or_of_rivals_is_not_written_over() {
    let folder = Folder::with_data();
    std::fs::create_dir(folder.file("page")).unwrap();
    for (name, output) in [
        ("x.svg", "--report"),
        ("index.html", "--report"),
        ("run.json", "--report"),
        ("2-x.json", "--rivals"),
    ] {
        let data = format!("page/{name}");
        folder.write(&data, &folder.read("data.csv"));
        let run =
            folder.run(&["discover", "--robot", "robot.toml", "--data", &data, output, "page"]).ended(2);
        assert!(
            run.log.starts_with(&format!("error: {output}: ")) && run.log.contains("--data"),
            "{}",
            run.log
        );
        assert_eq!(folder.read(&data), folder.read("data.csv"));
        std::fs::remove_file(folder.file(&data)).unwrap();
    }
}

#[test]
fn the_table_beside_a_program_is_not_written_over_an_input() {
    let folder = Folder::with_data();
    folder
        .run(&[
            "identify",
            "--robot",
            "robot.toml",
            "--data",
            "data.csv",
            "--folds",
            "0",
            "--out",
            "fit.json",
        ])
        .ended(0);
    folder.write("job.src", "DEF job( )\nPTP XP1\nEND\n");
    folder.write("new.src.corrections.csv", "DEFDAT job\nDECL E6AXIS XP1={A1 50,A2 10,A3 8}\nENDDAT\n");
    let before = folder.read("new.src.corrections.csv");
    let words =
        "compensate --fit fit.json --program job.src --with new.src.corrections.csv --mark --out new.src";
    let run = folder.run(&words.split(' ').collect::<Vec<_>>()).ended(2);
    assert!(run.log.contains("`new.src.corrections.csv` is what --with reads"), "{}", run.log);
    assert_eq!(folder.read("new.src.corrections.csv"), before);
}
