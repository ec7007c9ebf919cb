//! Campaigns of every kind of measurement: the real robot is where it is observed, and each number is the one of its formula.

use truepose_errormodel::observation::KINDS;
use truepose_errormodel::{Dataset, Landmark, Surroundings, observation};
use truepose_kinematics::nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use truepose_kinematics::samples;
use truepose_simulate::{Observation, Plant, PlantDescription, SimulateError};

/// An arm with errors of its frames, springs, backlash, and three targets on its tool.
const ARM: &str = r#"
seed = 5

[errors.geometric]
position_mm = 0.8
angle_mrad = 1.0
target_mm = 0.3

[[errors.joint_compliance]]
joint = "a2"
stiffness = 1e6

[[errors.backlash]]
joint = "a1"
width_mrad = 0.3
side = "approach"
"#;

const SOCKETS: &str = r#"
[[landmarks]]
name = "A"
rows = 12
xyz_mm = [2900, 700, 1300]

[[landmarks]]
name = "B"
rows = 12
xyz_mm = [2400, 1500, 900]
targets = ["T2"]
"#;

struct Seen {
    plant: Plant,
    seen: Observation,
}

fn observed_in(text: &str, described: &Surroundings) -> Result<Seen, SimulateError> {
    let chain = samples::heavy();
    let description = PlantDescription::from_toml(text)?;
    let plant = description.plant_in(&chain, described).map_err(|error| error.located(text))?;
    let campaign = description.campaign_of(&plant, description.seed)?;
    let seen = plant.observe(&campaign, description.seed).map_err(|error| error.located(text))?;
    Ok(Seen { plant, seen })
}

/// Without positions.
fn observed(things: &str) -> Seen {
    let text = format!("{ARM}{things}\n[campaign]\nvisits = 0\n");
    observed_in(&text, &Surroundings::default()).expect("a campaign")
}

impl Seen {
    /// Rows of a landmark.
    fn rows(&self, name: &str) -> Vec<usize> {
        let number = self.plant.cell.names.iter().position(|known| known == name);
        let all = 0..self.data().len();
        all.filter(|&row| number.is_some() && self.data().landmark(row) == number).collect()
    }

    fn data(&self) -> &Dataset {
        &self.seen.data
    }

    fn kind(&self, row: usize) -> Option<&'static str> {
        self.data().kind(row).map(|kind| KINDS[kind])
    }

    /// How far the postures of some rows are apart: the least of the widths of each joint, rad.
    fn variety(&self, rows: &[usize]) -> f64 {
        let width = |column: &Vec<f64>| {
            let of_rows = || rows.iter().map(|&row| column[row]);
            of_rows().fold(f64::MIN, f64::max) - of_rows().fold(f64::MAX, f64::min)
        };
        self.data().joints.iter().map(width).fold(f64::MAX, f64::min)
    }
}

fn mm(at: [f64; 3]) -> Vector3<f64> {
    Vector3::from(at) * 1e-3
}

#[test]
fn the_real_robot_is_in_the_socket_from_many_postures() {
    let of = observed(SOCKETS);
    of.data().validate(of.plant.chain()).expect("columns that fit");
    for (name, at, target) in
        [("A", [2900.0, 700.0, 1300.0], None), ("B", [2400.0, 1500.0, 900.0], Some("T2"))]
    {
        let rows = of.rows(name);
        assert_eq!((rows.len(), of.kind(rows[0])), (12, None));
        for &row in &rows {
            // 1 nm: where the search ends, and the turn of a pass.
            let away = (of.seen.true_positions[row] - mm(at)).norm();
            assert!(away < 1e-9, "{name}: {away} m");
            assert!(of.data().position[row].iter().all(|v| v.is_nan()));
            if let Some(target) = target {
                assert_eq!(of.data().target[row], of.plant.chain().target_named(target));
            }
            // The commanded joints are what the plant is at rest with.
            let again = of.plant.true_position(&of.data().conditions(row), of.data().target[row]);
            assert!((again.expect("a position") - mm(at)).norm() < 1e-9);
        }
        assert!(of.variety(&rows) > 0.3, "{}", of.variety(&rows));
    }
    // The robot as described does not touch: its errors are in the joints.
    let nominal = Plant::perfect(of.plant.chain()).expect("a plant");
    let row = of.rows("A")[3];
    let there = nominal.true_position(&of.data().conditions(row), of.data().target[row]).expect("a position");
    assert!((there - mm([2900.0, 700.0, 1300.0])).norm() > 3e-4);
}

#[test]
fn the_example_measures_what_it_lists() {
    let of =
        observed_in(include_str!("../../examples/cell.toml"), &Surroundings::default()).expect("a campaign");
    let rows = ["A", "B", "wire", "table", "ball", "laser"].map(|name| of.rows(name).len());
    assert_eq!((rows, of.data().len()), ([20, 20, 40, 40, 30, 40], 190));
    // Mixed: hardly ever do more than ten rows of one landmark follow each other.
    let run = (0..180).any(|row| (row..row + 10).all(|k| of.data().landmark(k) == of.data().landmark(row)));
    assert!(!run);
}

#[test]
fn what_friction_leaves_behind_is_in_the_joints_as_well() {
    let text = format!("{ARM}{SOCKETS}\n[campaign]\nvisits = 0\nshuffled = true\n");
    let description = PlantDescription::from_toml(&text).expect("a description");
    let chain = samples::heavy();
    let plant = description.plant(&chain).expect("a plant");
    let mut truth = plant.truth().clone();
    let friction = truepose_simulate::physics::presliding::Presliding::Dahl { amplitude: 2e-4, width: 0.05 };
    truth.joints[1].presliding = Some(friction);
    let plant = plant.with_truth(truth).expect("a plant");
    let seen = plant.observe(&description.campaign_of(&plant, 5).expect("visits"), 5).expect("data");
    for row in 0..seen.data.len() {
        let places = [mm([2900.0, 700.0, 1300.0]), mm([2400.0, 1500.0, 900.0])];
        let away = (seen.true_positions[row] - places[seen.data.landmark(row).expect("a socket")]).norm();
        assert!(away < 2e-9, "row {row}: {away} m");
    }
}

#[test]
fn a_probe_touches_a_bowed_plate_and_the_upper_half_of_a_ball() {
    let of = observed(
        r#"
[[landmarks]]
name = "table"
kind = "plane"
rows = 20
xyz_mm = [2700, 600, 700]
normal = [0, 0, 2]
size_mm = [600, 400]
bow_mm = 0.4

[[landmarks]]
name = "ball"
kind = "sphere"
rows = 15
xyz_mm = [2500, 1100, 1000]
radius_mm = 40
"#,
    );
    let mut heights = Vec::new();
    for row in of.rows("table") {
        assert_eq!(of.kind(row), Some("plane"));
        let [x, y, z]: [f64; 3] = (of.seen.true_positions[row] - mm([2700.0, 600.0, 700.0])).into();
        assert!(x.abs() < 0.3001 && y.abs() < 0.3001);
        // Whichever way its sides lie: 0.6 m along one, 0.4 m along the other.
        let wave = |x: f64, size: f64| (std::f64::consts::PI * x / size).cos();
        let expected = [wave(x, 0.6) * wave(y, 0.4), wave(x, 0.4) * wave(y, 0.6)].map(|w| 4e-4 * w);
        assert!(expected.iter().any(|expected| (z - expected).abs() < 1e-9), "{z} for {expected:?}");
        heights.push(z);
    }
    assert!(heights.iter().any(|z| *z > 3e-4) && heights.iter().any(|z| *z < 2e-4), "{heights:?}");
    for row in of.rows("ball") {
        let away = of.seen.true_positions[row] - mm([2500.0, 1100.0, 1000.0]);
        assert!((away.norm() - 0.04).abs() < 1e-9 && away.z > -1e-9, "{away}");
    }
}

#[test]
fn numbers_are_those_of_their_formulas() {
    let of = observed(
        r#"
[[landmarks]]
name = "wire"
kind = "distance"
rows = 9
xyz_mm = [2500, 500, -300]
gain = 1.002
offset_mm = 3

[[landmarks]]
name = "laser"
kind = "linear"
rows = 9
normal = [0.6, 0.8, 0]
offset_mm = -20

[[landmarks]]
name = "dial"
kind = "linear"
rows = 9
xyz_mm = [2800, 500, 1200]
normal = [0, 0, 1]
travel_mm = 10

[[landmarks]]
name = "morning"
kind = "relative"
rows = 9
xyz_mm = [100, 200, 300]
rpy_deg = [10, 20, 30]
"#,
    );
    let scalar = |row: usize, k: usize| of.data().scalar(row, k).expect("a number");
    let at = |row: usize| of.seen.true_positions[row];
    for row in of.rows("wire") {
        let expected = 1.002 * (at(row) - mm([2500.0, 500.0, -300.0])).norm() + 3e-3;
        assert!((scalar(row, 0) - expected).abs() < 1e-12);
        assert_eq!(of.kind(row), Some("distance"));
    }
    for row in of.rows("laser") {
        let expected = 0.6 * at(row).x + 0.8 * at(row).y - 0.02;
        assert!((scalar(row, 0) - expected).abs() < 1e-12);
    }
    for row in of.rows("dial") {
        let off = at(row) - mm([2800.0, 500.0, 1200.0]);
        assert!(off.x.abs() < 1e-9 && off.y.abs() < 1e-9 && off.z.abs() < 5e-3 + 1e-9, "{off}");
        assert!((scalar(row, 0) - off.z).abs() < 1e-12);
    }
    let frame = Rotation3::from_euler_angles(10f64.to_radians(), 20f64.to_radians(), 30f64.to_radians());
    for row in of.rows("morning") {
        let expected = frame.inverse() * (at(row) - mm([100.0, 200.0, 300.0]));
        let read = Vector3::from([0, 1, 2].map(|k| scalar(row, k)));
        assert!((read - expected).norm() < 1e-12);
        assert_eq!(of.kind(row), Some("relative"));
    }
    // Anywhere in the workspace.
    assert!(of.variety(&of.rows("wire")) > 1.0);
}

/// A board of 30 mm in the frame of the measurement, and a camera of which the description knows the lens.
fn board() -> Surroundings {
    let point = |k: usize| Landmark {
        name: format!("c{k}"),
        position: Some(mm([2600.0 + 30.0 * (k % 4) as f64, 600.0 + 30.0 * (k / 4) as f64, 600.0])),
        known: true,
        ..Landmark::default()
    };
    let mut landmarks: Vec<Landmark> = (0..12).map(point).collect();
    let lens = observation::Camera {
        place: None,
        known: false,
        intrinsics: [900.0, 905.0, 640.0, 480.0],
        distortion: [-0.08, 0.0, 0.0, 0.0, 0.0],
        free_intrinsics: false,
        size: Some([1280.0, 960.0]),
    };
    landmarks.push(Landmark {
        name: "eye".into(),
        observed: Some(Box::new(lens)),
        mount: Some("tool".into()),
        ..Landmark::default()
    });
    Surroundings { landmarks, distances: Vec::new(), open: false }
}

const EYE: &str = r#"
[[cameras]]
name = "eye"
images = 10
xyz_mm = [40, -50, 60]
rpy_deg = [2, -1, 35]
distance_mm = [400, 800]
normal = [0, 0, 1]
sd_px = 0.0
"#;

/// Where the camera on the robot sees a row's point with this focal length: the pixel, and the point in the camera's axes, m.
fn seen_by_eye(of: &Seen, row: usize, fx: f64) -> ([f64; 2], Point3<f64>) {
    let place = Isometry3::from_parts(
        Translation3::new(0.04, -0.05, 0.06),
        UnitQuaternion::from_euler_angles(2f64.to_radians(), -(1f64.to_radians()), 35f64.to_radians()),
    );
    let number = of.data().point(row).expect("a point");
    let point = board().landmarks[number].position.expect("its place");
    let tool = of.seen.true_poses[row];
    let own =
        place.inverse_transform_point(&Point3::from(tool.rotation.transpose() * (point - tool.translation)));
    let (x, y) = (own.x / own.z, own.y / own.z);
    let radial = 1.0 - 0.08 * (x * x + y * y);
    ([fx * x * radial + 640.0, 905.0 * y * radial + 480.0], own)
}

#[test]
fn a_camera_on_the_robot_sees_the_board_and_what_it_does_not_see_is_not_written() {
    let of = observed_in(&format!("{ARM}{EYE}\n[campaign]\nvisits = 0\n"), &board()).expect("images");
    let rows = of.rows("eye");
    assert_eq!(rows.len(), of.data().len());
    let mut of_image = vec![0; 10];
    for &row in &rows {
        of_image[of.data().visit[row]] += 1;
        let (expected, own) = seen_by_eye(&of, row, 900.0);
        assert!((0.3..0.95).contains(&own.z), "{own}");
        for (k, (expected, size)) in expected.into_iter().zip([1280.0, 960.0]).enumerate() {
            let pixel = of.data().scalar(row, k).expect("a pixel");
            assert!((pixel - expected).abs() < 1e-6 && (0.0..=size).contains(&pixel), "{pixel} {expected}");
        }
        // From above, within 60°.
        let tool = of.seen.true_poses[row];
        let centre = tool.translation + tool.rotation * mm([40.0, -50.0, 60.0]);
        assert!((centre - mm([2645.0, 630.0, 600.0])).angle(&Vector3::z()) < 60.2f64.to_radians());
    }
    assert!(of_image.iter().all(|count| (4..=12).contains(count)), "{of_image:?}");
    assert!(of.variety(&rows) > 0.1);
}

#[test]
fn a_camera_in_the_cell_sees_all_targets_that_are_in_its_image() {
    let of = observed(
        r#"
[[cameras]]
name = "wall"
images = 12
xyz_mm = [4500, 0, 1000]
rpy_deg = [-90, 0, 90]
fx = 700
fy = 700
cx = 640
cy = 480
"#,
    );
    let (mut of_image, mut smallest) = (vec![0; 12], f64::MAX);
    for row in of.rows("wall") {
        of_image[of.data().visit[row]] += 1;
        // It looks along −x: y of the robot to its right, z up.
        let off = of.seen.true_positions[row] - mm([4500.0, 0.0, 1000.0]);
        let depth = -off.x;
        let expected = [700.0 * off.y / depth + 640.0, -700.0 * off.z / depth + 480.0];
        for (k, expected) in expected.into_iter().enumerate() {
            assert!((of.data().scalar(row, k).expect("a pixel") - expected).abs() < 1e-6);
        }
        smallest = smallest.min(depth);
        assert!(of.data().target[row].is_some() && of.data().point(row).is_none());
    }
    assert!(of_image.iter().all(|count| (1..=3).contains(count)), "{of_image:?}");
    assert!(smallest > 0.0);
}

#[test]
fn faults_are_where_they_were_planted() {
    // The robot file says 900 px; the lens is another one. A socket moves after 600 s.
    let text = format!(
        "{ARM}{EYE}fx = 915\n{SOCKETS}moved = {{ when_s = 600, xyz_mm = [0.5, 0, 0] }}\n\
         [[misnamed]]\nrow = 3\nnamed = \"A\"\n[campaign]\nvisits = 0\n"
    );
    let open = Surroundings { open: true, ..board() };
    let of = observed_in(&text, &open).expect("a campaign");
    let rows: Vec<usize> = of.rows("B").into_iter().chain([2]).collect();
    for row in of.rows("B") {
        let by = if of.data().time[row] >= 600.0 { 5e-4 } else { 0.0 };
        let away = (of.seen.true_positions[row] - mm([2400.0, 1500.0, 900.0]) - Vector3::x() * by).norm();
        assert!(away < 1e-9, "{away} m at {} s", of.data().time[row]);
    }
    assert!(of.data().time[rows[0]] < 600.0 && of.data().time[rows[10]] >= 600.0);
    // Row 3 was in A, and names A.
    assert_eq!((of.seen.misnamed.as_slice(), of.data().landmark(2)), (&[2][..], of.data().landmark(0)));
    // Pixels are those of the true lens, not of the stated one.
    for row in of.rows("eye") {
        let pixel = of.data().scalar(row, 0).expect("a pixel");
        assert!((pixel - seen_by_eye(&of, row, 915.0).0[0]).abs() < 1e-6);
    }
}

#[test]
fn a_wrong_association_names_something_else_than_was_observed() {
    let text = format!(
        "{ARM}{SOCKETS}\n[[misnamed]]\nrow = 13\nnamed = \"A\"\n[[misnamed]]\nrow = 2\nnamed = \"T3\"\n[campaign]\nvisits = 0\n"
    );
    let of = observed_in(&text, &Surroundings::default()).expect("a campaign");
    assert_eq!(of.data().landmark(12), Some(0));
    assert!((of.seen.true_positions[12] - mm([2400.0, 1500.0, 900.0])).norm() < 1e-9);
    assert_eq!(of.data().target[1], of.plant.chain().target_named("T3"));
    assert!((of.seen.true_positions[1] - mm([2900.0, 700.0, 1300.0])).norm() < 1e-9);
    assert_eq!(of.seen.misnamed, [12, 1]);
    // A row of a camera on the robot names another point.
    let text = format!("{ARM}{EYE}\n[[misnamed]]\nrow = 1\nnamed = \"c11\"\n[campaign]\nvisits = 0\n");
    let of = observed_in(&text, &board()).expect("a campaign");
    assert_eq!(of.data().point(0), Some(11));
}

#[test]
fn a_touch_scatters_by_its_own_deviation_and_not_by_the_robots() {
    let things = SOCKETS.replace("rows = 12", "rows = 400").replace("xyz_mm", "sd_um = 30\nxyz_mm");
    let text = format!("seed = 1\n{things}\n[repeatability]\nsd_um = 50\n[campaign]\nvisits = 0\n");
    let of = observed_in(&text, &Surroundings::default()).expect("a campaign");
    // The commanded joints make up for the deviation of the pose and for that of the seat: √(30² + 50²) µm an axis; 2400 numbers, 5 % is
    // more than three deviations.
    let rows = of.rows("A");
    let squares: f64 = rows
        .iter()
        .map(|&row| (of.seen.true_positions[row] - mm([2900.0, 700.0, 1300.0])).norm_squared())
        .sum();
    let sd = (squares / (3 * rows.len()) as f64).sqrt();
    assert!((sd / 58.3e-6 - 1.0).abs() < 0.08, "{sd}");
}

#[test]
fn landmarks_leave_measured_positions_as_they_were() {
    let positions =
        format!("{ARM}[instrument]\nsd_um = 20\n[repeatability]\nsd_um = 20\n[campaign]\nvisits = 8\n");
    let alone = observed_in(&positions, &Surroundings::default()).expect("a campaign");
    let both = observed_in(&format!("{positions}{SOCKETS}"), &Surroundings::default()).expect("a campaign");
    assert_eq!((alone.data().len(), both.data().len()), (24, 48));
    let part = both.data().select(&(0..24).collect::<Vec<_>>());
    assert_eq!(part.position, alone.data().position);
    assert_eq!(part.joints, alone.data().joints);
    let truth = both.seen.truth();
    truth.validate(both.plant.chain()).expect("columns that fit");
    assert!(truth.landmarks().is_none() && (0..48).all(|row| truth.seen(row).count() == 6));
    assert!((truth.measured_position(30) - both.seen.true_positions[30]).norm() < 1e-15);
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let check = |things: &str, words: &str| {
        let text = format!("{things}\n[campaign]\nvisits = 0\n");
        let told = match observed_in(&text, &board()) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("nothing was refused: {things}"),
        };
        assert!(told.contains(words), "{words}\n{told}");
    };
    check(
        "[[landmarks]]\nname = \"Z\"\nrows = 2\n",
        "line 2, column 8: the robot has no landmark `Z`; it has: c0, c1",
    );
    check("[[landmarks]]\nname = \"c1\"\nrow = 2\n", "line 3, column 1");
    check(
        "[[landmarks]]\nname = \"c1\"\nkind = \"plane\"\nrows = 1\n",
        "line 2, column 8: `c1`: neither this file nor the robot's has its `normal`",
    );
    check("[[landmarks]]\nname = \"c1\"\nkind = \"sphere\"\nrows = 1\n", "it has no `radius_mm`");
    check(
        "[[landmarks]]\nname = \"c1\"\nkind = \"sphere\"\nradius_mm = 0\nrows = 1\n",
        "`radius_mm` has to be above zero",
    );
    check(
        "[[landmarks]]\nname = \"c1\"\nxyz_mm = [90000, 0, 0]\nrows = 1\n",
        "line 2, column 8: no posture within the joints' limits of 1000",
    );
    check("[[cameras]]\nname = \"eye\"\nimages = 1\n", "it needs `xyz_mm` and `rpy_deg`");
    check("[[landmarks]]\nname = \"c1\"\ntargets = [\"T9\"]\nrows = 1\n", "the robot has no target `T9`");
    check("[[landmarks]]\nname = \"c1\"\nsd_um = -1\nrows = 1\n", "zero or more");
    check(&format!("{EYE}\n[[misnamed]]\nrow = 500\nnamed = \"c1\"\n"), "row 500 cannot name something else");
    check("[[landmarks]]\nname = \"c1\"\nrows = 1\n[[misnamed]]\nrow = 1\nnamed = \"nobody\"\n", "`nobody`");
}
