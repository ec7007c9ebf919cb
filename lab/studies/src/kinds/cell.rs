//! A light arm in a cell where everything stands that it can be measured with.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::error::Error;
use std::fmt::Write;
use truepose_errormodel::observation::{Camera, Distance, Linear, Observation, Plane, Relative, Sphere};
use truepose_errormodel::{Dataset, KnownDistance, Landmark, Surroundings};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Placed, Pose, samples};
use truepose_simulate::{Plant, PlantDescription};

/// What a campaign is made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Sockets,
    Wires,
    Plates,
    Balls,
    Gauges,
    Series,
    Cameras,
    Eye,
}

impl Kind {
    pub const ALL: [Kind; 8] = [
        Kind::Sockets,
        Kind::Wires,
        Kind::Plates,
        Kind::Balls,
        Kind::Gauges,
        Kind::Series,
        Kind::Cameras,
        Kind::Eye,
    ];

    pub fn word(self) -> &'static str {
        match self {
            Kind::Sockets => "same_point",
            Kind::Wires => "distance",
            Kind::Plates => "plane",
            Kind::Balls => "sphere",
            Kind::Gauges => "linear",
            Kind::Series => "relative",
            Kind::Cameras => "pixel, in the cell",
            Kind::Eye => "pixel, on the robot",
        }
    }
}

/// What is wrong with one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    SocketMoved,
    WireGain,
    PlateBowed,
    BallRadius,
    GaugeGain,
    SeriesMoved,
    CameraLens,
    EyeLens,
    EyeMoved,
    Misnamed,
}

impl Fault {
    pub const ALL: [Fault; 10] = [
        Fault::SocketMoved,
        Fault::WireGain,
        Fault::PlateBowed,
        Fault::BallRadius,
        Fault::GaugeGain,
        Fault::SeriesMoved,
        Fault::CameraLens,
        Fault::EyeLens,
        Fault::EyeMoved,
        Fault::Misnamed,
    ];

    pub fn word(self) -> &'static str {
        match self {
            Fault::SocketMoved => "a socket moved by 0.5 mm",
            Fault::WireGain => "a wire 0.2 % too long",
            Fault::PlateBowed => "a plate bowed by 0.4 mm",
            Fault::BallRadius => "a ball 0.4 mm too large",
            Fault::GaugeGain => "a gauge 0.2 % too steep",
            Fault::SeriesMoved => "a series moved by 0.5 mm",
            Fault::CameraLens => "focal length of a camera 1 % off",
            Fault::EyeLens => "focal length on the robot 1 % off",
            Fault::EyeMoved => "the camera on the robot moved by 1 mm",
            Fault::Misnamed => "one row names another socket",
        }
    }

    /// The kind that has it, the landmark, and the word that the program has for it.
    pub fn place(self) -> (Kind, &'static str, &'static str) {
        match self {
            Fault::SocketMoved => (Kind::Sockets, "S3", "moved"),
            Fault::WireGain => (Kind::Wires, "W2", "gain and offset"),
            Fault::PlateBowed => (Kind::Plates, "P1", "flatness"),
            Fault::BallRadius => (Kind::Balls, "B2", "radius"),
            Fault::GaugeGain => (Kind::Gauges, "G1", "gain"),
            Fault::SeriesMoved => (Kind::Series, "R1", "moved"),
            Fault::CameraLens => (Kind::Cameras, "C1", "lens"),
            Fault::EyeLens => (Kind::Eye, "eye", "lens"),
            Fault::EyeMoved => (Kind::Eye, "eye", "moved"),
            Fault::Misnamed => (Kind::Sockets, "S3", "row"),
        }
    }

    /// Lines of the plant for a thing of this name.
    fn lines(self, name: &str, half_s: f64) -> String {
        let moved = |by: &str| format!("moved = {{ when_s = {half_s}, xyz_mm = [{by}] }}\n");
        match self {
            _ if self.place().1 != name => String::new(),
            Fault::SocketMoved | Fault::SeriesMoved => moved("0.4, 0.3, 0"),
            Fault::EyeMoved => moved("0.8, -0.6, 0"),
            Fault::WireGain | Fault::GaugeGain => "gain = 1.002\n".into(),
            Fault::PlateBowed => "bow_mm = 0.4\n".into(),
            Fault::BallRadius => "radius_mm = 300.4\n".into(),
            Fault::CameraLens => "fx = 1616\nfy = 1616\n".into(),
            Fault::EyeLens => "fx = 909\nfy = 909\n".into(),
            Fault::Misnamed => String::new(),
        }
    }
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
pub fn arm() -> Result<Chain, Box<dyn Error>> {
    let joints = samples::ur10().joints().iter().map(|joint| joint.clone().with_limits(-2.8, 2.8)).collect();
    let tool = Placed { pose: Pose::from_xyz_rpy([0.04, 0.03, 0.12], [0.0; 3]), known: true };
    Ok(Chain::new("light", joints)?.with_tool(tool)?)
}

/// A campaign of these kinds with this robot.
pub fn made(kinds: &[Kind], fault: Option<Fault>, size: Size, seed: u64) -> Result<Made, Box<dyn Error>> {
    let chain = arm()?;
    let mut things: Vec<Thing> = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for kind in Kind::ALL {
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
        text += &fault.map_or(String::new(), |fault| fault.lines(&thing.name, half_s));
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
    if fault == Some(Fault::Misnamed) {
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
        let table = if matches!(kind, Kind::Cameras | Kind::Eye) && !lines.contains("rows") {
            "cameras"
        } else {
            "landmarks"
        };
        let toml = format!("[[{table}]]\nname = \"{name}\"\n{lines}");
        Thing { known: Landmark { name: name.clone(), ..known }, name, toml }
    };
    match kind {
        Kind::Sockets => {
            let places = [
                [500.0, 350.0, 100.0],
                [650.0, -200.0, 400.0],
                [-400.0, 500.0, 500.0],
                [100.0, -600.0, 250.0],
            ];
            let pair = |(k, at): (usize, [f64; 3])| {
                let [x, y, z] = near(at);
                // 100 mm apart.
                [[x, y, z], [x + 60.0, y + 80.0, z]].into_iter().enumerate().map(move |(second, at)| {
                    let name = format!("S{}", 2 * k + second + 1);
                    (name, format!("rows = 15\nxyz_mm = {at:?}\nsd_um = {}\n", 20.0 * noise))
                })
            };
            let all: Vec<_> = places.into_iter().enumerate().flat_map(pair).collect();
            all.into_iter().map(|(name, lines)| thing(name, lines, Landmark::default())).collect()
        }
        Kind::Wires => [[1500.0, 300.0, -300.0], [-900.0, 1200.0, 100.0], [200.0, -1500.0, 1300.0]]
            .into_iter()
            .enumerate()
            .map(|(k, at)| {
                let lines = format!("rows = 40\nxyz_mm = {:?}\nsd_um = {}\n", near(at), 40.0 * noise);
                thing(format!("W{}", k + 1), lines, seen(Distance::default(), None))
            })
            .collect(),
        Kind::Plates => [
            ([550.0, 100.0, 50.0], [0.0, 0.0, 1.0]),
            ([750.0, 0.0, 450.0], [-1.0, 0.0, 0.0]),
            ([100.0, 700.0, 400.0], [0.0, -1.0, 0.0]),
            ([500.0, -200.0, 600.0], [0.0, 0.0, -1.0]),
        ]
        .into_iter()
        .enumerate()
        .map(|(k, (at, normal))| {
            // Known planes, of which two are parallel: three that meet in a corner do not say how long anything is.
            let at = near(at);
            let lines = format!("rows = 30\nsize_mm = [500, 500]\nsd_um = {}\n", 30.0 * noise);
            let plane = Plane {
                normal: Some(Vector3::from(normal)),
                point: Some(Vector3::from(at) * 1e-3),
                known: true,
            };
            thing(format!("P{}", k + 1), lines, seen(plane, Some((at, true))))
        })
        .collect(),
        Kind::Balls => [[500.0, 200.0, 200.0], [-300.0, 550.0, 300.0], [100.0, -550.0, 500.0]]
            .into_iter()
            .enumerate()
            .map(|(k, at)| {
                let lines = format!(
                    "rows = 40\nxyz_mm = {:?}\nnormal = [0, 0, 1]\nwithin_deg = 120\nsd_um = {}\n",
                    near(at),
                    20.0 * noise
                );
                thing(format!("B{}", k + 1), lines, seen(Sphere::of_radius(0.3), None))
            })
            .collect(),
        Kind::Gauges => [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.28, 0.96]]
            .into_iter()
            .enumerate()
            .map(|(k, normal)| {
                let lines = format!("rows = 40\nnormal = {normal:?}\nsd_um = {}\n", 40.0 * noise);
                thing(format!("G{}", k + 1), lines, seen(Linear::default(), None))
            })
            .collect(),
        Kind::Series => [[900.0, -200.0, 100.0], [-300.0, 800.0, 200.0]]
            .into_iter()
            .enumerate()
            .map(|(k, at)| {
                let lines = format!(
                    "rows = 30\nxyz_mm = {:?}\nrpy_deg = [5, 10, {}]\nsd_um = {}\n",
                    near(at),
                    100 * k,
                    60.0 * noise
                );
                thing(format!("R{}", k + 1), lines, seen(Relative::default(), None))
            })
            .collect(),
        Kind::Cameras => {
            [([3000.0, 100.0, 500.0], [-90.0, 0.0, 90.0]), ([0.0, -3000.0, 600.0], [-90.0, 0.0, 0.0])]
                .into_iter()
                .enumerate()
                .map(|(k, (at, rpy))| {
                    // Both stand at known places, a base line apart.
                    let [r, p, y] = [rpy[0], rpy[1], rpy[2]].map(f64::to_radians);
                    let place = Pose::from_xyz_rpy(at.map(|v| 1e-3 * v), [r, p, y]);
                    let lens = lens([1600.0, 1600.0, 960.0, 600.0], Some(place));
                    let lines = format!("images = 60\nsd_px = {}\n", 0.05 * noise);
                    thing(format!("C{}", k + 1), lines, seen(lens, Some((at, true))))
                })
                .collect()
        }
        Kind::Eye => {
            let at = near([550.0, 150.0, 30.0]);
            let mut all: Vec<Thing> = (0..12)
                .map(|k: usize| {
                    let at = [at[0] + 30.0 * (k % 4) as f64, at[1] + 30.0 * (k / 4) as f64, at[2]];
                    let position = Some(Vector3::from(at) * 1e-3);
                    let known = Landmark { position, known: true, ..Landmark::default() };
                    thing(format!("c{k}"), "rows = 0\n".into(), known)
                })
                .collect();
            let lines = format!(
                "images = {}\nxyz_mm = {:?}\nrpy_deg = {:?}\ndistance_mm = [250, 500]\nnormal = [0, 0, 1]\nsd_px = {}\n",
                size.images,
                EYE_MM,
                EYE_DEG,
                0.1 * noise
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
