//! A light arm in a cell where everything stands that it can be measured with.

use crate::prelude::*;
use truepose_errormodel::observation::{Camera, Distance, Linear, Observation, Plane, Relative, Sphere};
use truepose_errormodel::{KnownDistance, Landmark, Surroundings};
use truepose_simulate::PlantDescription;

/// What a campaign is made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    #[value(name = "same_point")]
    Sockets,
    #[value(name = "distance")]
    Wires,
    #[value(name = "plane")]
    Plates,
    #[value(name = "sphere")]
    Balls,
    #[value(name = "linear")]
    Gauges,
    #[value(name = "relative")]
    Series,
    #[value(name = "pixel, in the cell")]
    Cameras,
    #[value(name = "pixel, on the robot")]
    Eye,
}

/// What is wrong with one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    pub kind: Kind,
    /// The landmark that has it, and the word that the program has for it.
    pub landmark: &'static str,
    pub what: &'static str,
    pub word: &'static str,
    /// Lines of the landmark in the plant; `HALF` is the middle of the campaign, s.
    lines: &'static str,
}

const fn fault(kind: Kind, [landmark, what, word]: [&'static str; 3], lines: &'static str) -> Fault {
    Fault { kind, landmark, what, word, lines }
}

const MOVED: &str = "moved = { when_s = HALF, xyz_mm = [0.4, 0.3, 0] }\n";
const MOVED_EYE: &str = "moved = { when_s = HALF, xyz_mm = [0.8, -0.6, 0] }\n";

impl Fault {
    pub const EYE_LENS: Fault =
        fault(Kind::Eye, ["eye", "lens", "focal length on the robot 1 % off"], "fx = 909\nfy = 909\n");
    pub const EYE_MOVED: Fault =
        fault(Kind::Eye, ["eye", "moved", "the camera on the robot moved by 1 mm"], MOVED_EYE);
    pub const MISNAMED: Fault = fault(Kind::Sockets, ["S3", "row", "one row names another socket"], "");

    pub const ALL: [Fault; 10] = [
        fault(Kind::Sockets, ["S3", "moved", "a socket moved by 0.5 mm"], MOVED),
        fault(Kind::Wires, ["W2", "gain and offset", "a wire 0.2 % too long"], "gain = 1.002\n"),
        fault(Kind::Plates, ["P1", "flatness", "a plate bowed by 0.4 mm"], "bow_mm = 0.4\n"),
        fault(Kind::Balls, ["B2", "radius", "a ball 0.4 mm too large"], "radius_mm = 300.4\n"),
        fault(Kind::Gauges, ["G1", "gain", "a gauge 0.2 % too steep"], "gain = 1.002\n"),
        fault(Kind::Series, ["R1", "moved", "a series moved by 0.5 mm"], MOVED),
        fault(Kind::Cameras, ["C1", "lens", "focal length of a camera 1 % off"], "fx = 1616\nfy = 1616\n"),
        Fault::EYE_LENS,
        Fault::EYE_MOVED,
        Fault::MISNAMED,
    ];
}

/// How wrong the arm is, and how well everything measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Errors of each frame, mm; as many mrad.
    pub errors: f64,
    /// Factor on every deviation.
    pub noise: f64,
    /// Images of the camera on the robot.
    pub images: usize,
    /// A gear whose error is no part of the declared model, mrad.
    pub gear: f64,
}

impl Default for Size {
    fn default() -> Self {
        Size { errors: 0.5, noise: 1.0, images: 20, gear: 0.0 }
    }
}

/// A robot, what is known of its cell, and what it measured there.
pub struct Made {
    pub chain: Chain,
    pub described: Surroundings,
    pub plant: Plant,
    pub data: Dataset,
}

/// One thing: its table in the plant, and what the robot file says of it.
struct Thing {
    name: String,
    toml: String,
    known: Landmark,
}

/// Where the camera on the robot is, in the tool: mm; roll, pitch and yaw, degrees.
const EYE_MM: [f64; 3] = [40.0, -50.0, 30.0];
const EYE_DEG: [f64; 3] = [3.0, -2.0, 40.0];

/// The same as a pose.
pub fn eye_place() -> Pose {
    Pose::from_xyz_rpy(EYE_MM.map(|v| 1e-3 * v), EYE_DEG.map(f64::to_radians))
}

/// Seconds from one pose measurement to the next.
const VISIT_S: f64 = 30.0;

/// The arm: a UR10's lengths, a tool beside its flange.
pub fn arm() -> Outcome<Chain> {
    let joints = samples::ur10().joints().iter().map(|joint| joint.clone().with_limits(-2.8, 2.8)).collect();
    let tool = known(Pose::from_xyz_rpy([0.04, 0.03, 0.12], [0.0; 3]));
    Ok(Chain::new("light", joints)?.with_tool(tool)?)
}

/// A campaign of these kinds with this robot.
pub fn made(kinds: &[Kind], fault: Option<Fault>, size: Size, seed: u64) -> Outcome<Made> {
    let chain = arm()?;
    let mut things: Vec<Thing> = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for &kind in Kind::all() {
        // All are drawn, so that a kind stands where it stands whatever there is beside it.
        let drawn = of_kind(kind, size, &mut rng);
        things.extend(drawn.into_iter().filter(|_| kinds.contains(&kind)));
    }
    let rows: usize = things.iter().map(|thing| rows_of(&thing.toml)).sum();
    let half_s = VISIT_S * rows as f64 / 2.0;
    let mut text = format!(
        "seed = {seed}\n[campaign]\nvisits = 0\nshuffled = true\nvisit_s = {VISIT_S}\n[errors.geometric]\nposition_mm = {e}\nangle_mrad = {e}\n",
        e = size.errors
    );
    if size.gear > 0.0 {
        let gear = size.gear;
        write!(text, "[[errors.transmission]]\njoint = \"j2\"\namplitude_mrad = {gear}\ncycles = 3\n")?;
    }
    for thing in &things {
        text += &thing.toml;
        if let Some(fault) = fault.filter(|fault| fault.landmark == thing.name) {
            text += &fault.lines.replace("HALF", &half_s.to_string());
        }
    }
    let mut described = Surroundings {
        landmarks: things.iter().map(|thing| thing.known.clone()).collect(),
        ..Surroundings::default()
    };
    let number = |name: &str| things.iter().position(|thing| thing.name == name);
    for pair in [["S1", "S2"], ["S3", "S4"], ["S5", "S6"], ["S7", "S8"]] {
        if let [Some(a), Some(b)] = pair.map(number) {
            described.distances.push(KnownDistance { between: [a, b], value: 0.1, sd: 0.0 });
        }
    }
    let description = PlantDescription::from_toml(&text)?;
    let plant = description.plant_in(&chain, &described)?;
    let campaign = description.campaign_of(&plant, seed)?;
    let mut data = plant.observe(&campaign, seed)?.data;
    if fault == Some(Fault::MISNAMED) {
        // The first row of one socket names the next.
        let (from, to) = (number("S2"), number("S3"));
        let mut of_row: Vec<Option<usize>> = (0..data.len()).map(|row| data.landmark(row)).collect();
        if let Some(row) = of_row.iter_mut().find(|at| **at == from) {
            *row = to;
        }
        data.set_landmarks(Some(&of_row));
    }
    Ok(Made { chain, described, plant, data })
}

/// Pose measurements of a table.
fn rows_of(toml: &str) -> usize {
    let value =
        |line: &str| line.strip_prefix("rows = ").or_else(|| line.strip_prefix("images = "))?.parse().ok();
    toml.lines().find_map(value).unwrap_or(0)
}

/// All things of one kind; `near` moves each about its place.
fn of_kind(kind: Kind, size: Size, rng: &mut ChaCha8Rng) -> Vec<Thing> {
    let noise = size.noise;
    let mut near = |at: [f64; 3]| at.map(|v| v + 40.0 * (rng.random::<f64>() - 0.5));
    let thing = |name: String, lines: String, known: Landmark| {
        let camera = matches!(kind, Kind::Cameras | Kind::Eye) && !lines.contains("rows");
        let table = if camera { "cameras" } else { "landmarks" };
        let toml = format!("[[{table}]]\nname = \"{name}\"\n{lines}");
        Thing { known: Landmark { name: name.clone(), ..known }, name, toml }
    };
    // One thing for each place of a list, under a letter and its number.
    let each = |letter: &str, lines: Vec<(String, Landmark)>| -> Vec<Thing> {
        let named = (1..).zip(lines);
        named.map(|(k, (lines, known))| thing(format!("{letter}{k}"), lines, known)).collect()
    };
    match kind {
        Kind::Sockets => {
            let places = [
                [500.0, 350.0, 100.0],
                [650.0, -200.0, 400.0],
                [-400.0, 500.0, 500.0],
                [100.0, -600.0, 250.0],
            ];
            let pair = |at: [f64; 3]| {
                let [x, y, z] = near(at);
                // 100 mm apart.
                [[x, y, z], [x + 60.0, y + 80.0, z]].map(|at| {
                    (format!("rows = 15\nxyz_mm = {at:?}\nsd_um = {}\n", 20.0 * noise), Landmark::default())
                })
            };
            each("S", places.into_iter().flat_map(pair).collect())
        }
        Kind::Wires => {
            let places = [[1500.0, 300.0, -300.0], [-900.0, 1200.0, 100.0], [200.0, -1500.0, 1300.0]];
            let one = |at: [f64; 3]| {
                let lines = format!("rows = 40\nxyz_mm = {:?}\nsd_um = {}\n", near(at), 40.0 * noise);
                (lines, seen(Distance::default(), None))
            };
            each("W", places.map(one).into())
        }
        Kind::Plates => {
            // Known planes, of which two are parallel: three that meet in a corner do not say how long anything is.
            let places = [
                ([550.0, 100.0, 50.0], [0.0, 0.0, 1.0]),
                ([750.0, 0.0, 450.0], [-1.0, 0.0, 0.0]),
                ([100.0, 700.0, 400.0], [0.0, -1.0, 0.0]),
                ([500.0, -200.0, 600.0], [0.0, 0.0, -1.0]),
            ];
            let one = |(at, normal): ([f64; 3], [f64; 3])| {
                let at = near(at);
                let lines = format!("rows = 30\nsize_mm = [500, 500]\nsd_um = {}\n", 30.0 * noise);
                let (normal, point) = (Some(Vector3::from(normal)), Some(Vector3::from(at) * 1e-3));
                (lines, seen(Plane { normal, point, known: true }, Some((at, true))))
            };
            each("P", places.map(one).into())
        }
        Kind::Balls => {
            let places = [[500.0, 200.0, 200.0], [-300.0, 550.0, 300.0], [100.0, -550.0, 500.0]];
            let one = |at: [f64; 3]| {
                let (at, sd) = (near(at), 20.0 * noise);
                let lines = format!(
                    "rows = 40\nxyz_mm = {at:?}\nnormal = [0, 0, 1]\nwithin_deg = 120\nsd_um = {sd}\n"
                );
                (lines, seen(Sphere::of_radius(0.3), None))
            };
            each("B", places.map(one).into())
        }
        Kind::Gauges => {
            let one = |normal: [f64; 3]| {
                let lines = format!("rows = 40\nnormal = {normal:?}\nsd_um = {}\n", 40.0 * noise);
                (lines, seen(Linear::default(), None))
            };
            each("G", [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.28, 0.96]].map(one).into())
        }
        Kind::Series => {
            let one = |(yaw, at): (usize, [f64; 3])| {
                let (at, sd) = (near(at), 60.0 * noise);
                let lines = format!("rows = 30\nxyz_mm = {at:?}\nrpy_deg = [5, 10, {yaw}]\nsd_um = {sd}\n");
                (lines, seen(Relative::default(), None))
            };
            each("R", [(0, [900.0, -200.0, 100.0]), (100, [-300.0, 800.0, 200.0])].map(one).into())
        }
        Kind::Cameras => {
            // Both are at known places, a base line apart.
            let places =
                [([3000.0, 100.0, 500.0], [-90.0, 0.0, 90.0f64]), ([0.0, -3000.0, 600.0], [-90.0, 0.0, 0.0])];
            let one = |(at, rpy): ([f64; 3], [f64; 3])| {
                let place = Pose::from_xyz_rpy(at.map(|v| 1e-3 * v), rpy.map(f64::to_radians));
                let lens = lens([1600.0, 1600.0, 960.0, 600.0], Some(place));
                (format!("images = 60\nsd_px = {}\n", 0.05 * noise), seen(lens, Some((at, true))))
            };
            each("C", places.map(one).into())
        }
        Kind::Eye => {
            let at = near([550.0, 150.0, 30.0]);
            let corner = |k: usize| {
                let at = [at[0] + 30.0 * (k % 4) as f64, at[1] + 30.0 * (k / 4) as f64, at[2]];
                let position = Some(Vector3::from(at) * 1e-3);
                let known = Landmark { position, known: true, ..Landmark::default() };
                thing(format!("c{k}"), "rows = 0\n".into(), known)
            };
            let mut all: Vec<Thing> = (0..12).map(corner).collect();
            let (images, sd) = (size.images, 0.1 * noise);
            let lines = format!(
                "images = {images}\nxyz_mm = {EYE_MM:?}\nrpy_deg = {EYE_DEG:?}\ndistance_mm = [250, 500]\nnormal = [0, 0, 1]\nsd_px = {sd}\n"
            );
            let known = seen(lens([900.0, 900.0, 640.0, 480.0], None), None);
            all.push(thing("eye".into(), lines, Landmark { mount: Some("tool".into()), ..known }));
            all
        }
    }
}

fn lens(intrinsics: [f64; 4], place: Option<Pose>) -> Camera {
    Camera {
        place,
        known: place.is_some(),
        intrinsics,
        distortion: [-0.08, 0.0, 0.0, 0.0, 0.0],
        free_intrinsics: false,
        size: Some([2.0 * intrinsics[2], 2.0 * intrinsics[3]]),
    }
}

fn seen(observed: impl Observation + 'static, known: Option<([f64; 3], bool)>) -> Landmark {
    Landmark {
        position: known.map(|(at, _)| Vector3::from(at) * 1e-3),
        known: known.is_some_and(|(_, known)| known),
        observed: Some(Box::new(observed)),
        ..Landmark::default()
    }
}
