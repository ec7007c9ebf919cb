//! A light arm in a cell with a wire, a table, a ball, a gauge and a camera: what it measures there, by formulas of its own.

use crate::folder::Folder;
use std::fmt::Write as _;

/// A light arm of six turning joints, in numbers of its own: d, a, alpha of each joint, after Denavit and Hartenberg.
#[derive(Clone, Copy)]
pub struct Arm(pub [[f64; 3]; 6]);

pub const NOMINAL: Arm = Arm([
    [0.30, 0.0, 90.0],
    [0.0, -0.45, 0.0],
    [0.0, -0.40, 0.0],
    [0.13, 0.0, 90.0],
    [0.11, 0.0, -90.0],
    [0.09, 0.0, 0.0],
]);
/// The tool's tip beside the flange, m.
pub const TOOL: [f64; 3] = [0.03, 0.02, 0.12];

/// Always the same numbers between −1 and 1.
pub struct Draw(u64);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Draw(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Of standard deviation one, nearly normal.
    pub fn noise(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() / 2.0
    }

    fn point(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }
}

impl Arm {
    /// Where the tip is, with offsets of the joints.
    pub fn tip(&self, q: &[f64; 6], offsets: &[f64; 6]) -> [f64; 3] {
        self.point(q, offsets, TOOL)
    }

    /// Where a point of the flange is.
    pub fn point(&self, q: &[f64; 6], offsets: &[f64; 6], of: [f64; 3]) -> [f64; 3] {
        let mut p = of;
        for k in (0..6).rev() {
            let [d, a, alpha] = self.0[k];
            let (sa, ca) = alpha.to_radians().sin_cos();
            let (st, ct) = (q[k] + offsets[k]).sin_cos();
            let [x, y, z] = [p[0] + a, ca * p[1] - sa * p[2], sa * p[1] + ca * p[2]];
            p = [ct * x - st * y, st * x + ct * y, z + d];
        }
        p
    }

    /// Lengths, twists and joint offsets that the description does not have.
    pub fn real(seed: u64) -> (Arm, [f64; 6]) {
        let mut draw = Draw(seed);
        let mut arm = NOMINAL;
        for joint in &mut arm.0 {
            joint[0] += 1e-3 * draw.next();
            joint[1] += 1e-3 * draw.next();
            joint[2] += 0.1 * draw.next();
        }
        (arm, std::array::from_fn(|_| 3e-3 * draw.next()))
    }
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// A campaign: a table with the rows of each kind, in a cell of a wire, a table, a ball and a gauge.
pub struct Cell {
    pub arm: Arm,
    pub offsets: [f64; 6],
    pub draw: Draw,
    pub rows: String,
}

pub const ANCHOR: [f64; 3] = [1.4, 0.5, -0.3];
const NORMAL: [f64; 3] = [0.0, 0.28, 0.96];
const ON_TABLE: [f64; 3] = [0.45, 0.1, 0.15];
const BALL: [f64; 3] = [0.4, -0.35, 0.45];
const RADIUS: f64 = 0.06;
pub const GAUGE: [f64; 3] = [0.6, 0.8, 0.0];

/// Where the camera stands, and its axes to the right, down and ahead.
pub const EYE: [f64; 3] = [2.2, 0.1, 0.5];
const LOOKS: [[f64; 3]; 3] =
    [[0.0, 1.0, 0.0], [-0.0998334166, 0.0, -0.9950041653], [-0.9950041653, 0.0, 0.0998334166]];

impl Cell {
    pub fn new(seed: u64) -> Self {
        let (arm, offsets) = Arm::real(seed);
        let rows = String::from(
            "kind,landmark,distance[mm],value[mm],x[mm],y[mm],z[mm],u[px],v[px],j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad]\n",
        );
        Cell { arm, offsets, draw: Draw(seed ^ 0x5bd1), rows }
    }

    pub fn anywhere(&mut self) -> [f64; 6] {
        std::array::from_fn(|_| 1.8 * self.draw.next())
    }

    /// Joints with which the real arm is at a point, by Newton's method; none where it does not reach it.
    fn touching(&mut self, to: [f64; 3]) -> Option<[f64; 6]> {
        for _ in 0..30 {
            let mut q = self.anywhere();
            for _ in 0..40 {
                let here = self.arm.tip(&q, &self.offsets);
                let away = minus(to, here);
                if dot(away, away) < 1e-22 {
                    let turn = std::f64::consts::TAU;
                    let q = q.map(|q| q - turn * (q / turn).round());
                    if q.iter().all(|q| q.abs() < 3.0) {
                        return Some(q);
                    }
                    break;
                }
                // Damped least squares over JᵀJ, solved by its gradient along J: q += Jᵀ (J Jᵀ + λ)⁻¹ away.
                let j: [[f64; 3]; 6] = std::array::from_fn(|k| {
                    let mut moved = q;
                    moved[k] += 1e-7;
                    minus(self.arm.tip(&moved, &self.offsets), here).map(|v| v / 1e-7)
                });
                let m: [[f64; 3]; 3] = std::array::from_fn(|r| {
                    std::array::from_fn(|c| {
                        j.iter().map(|j| j[r] * j[c]).sum::<f64>() + if r == c { 1e-9 } else { 0.0 }
                    })
                });
                let cross = |a: [f64; 3], b: [f64; 3]| {
                    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
                };
                let volume = dot(m[0], cross(m[1], m[2]));
                let x =
                    [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])].map(|c| dot(c, away) / volume);
                for k in 0..6 {
                    q[k] += dot(j[k], x).clamp(-0.4, 0.4);
                }
            }
        }
        None
    }

    fn row(&mut self, kind: &str, landmark: &str, cells: &str, q: &[f64; 6]) {
        let q: Vec<String> = q.iter().map(|q| format!("{q:.9}")).collect();
        writeln!(self.rows, "{kind},{landmark},{cells},{}", q.join(",")).unwrap();
    }

    pub fn wire(&mut self, rows: usize) -> &mut Self {
        for _ in 0..rows {
            let q = self.anywhere();
            let away = minus(self.arm.tip(&q, &self.offsets), ANCHOR);
            let length = dot(away, away).sqrt() + 0.025 + 3e-5 * self.draw.noise();
            self.row("distance", "wire", &format!("{:.5},,,,,,", 1e3 * length), &q);
        }
        self
    }

    pub fn table(&mut self, rows: usize) -> &mut Self {
        let mut left = rows;
        while left > 0 {
            let to = self.draw.point().map(|v| 0.25 * v);
            let off = dot(NORMAL, to) + 1e-4 * self.draw.noise();
            if let Some(q) = self.touching([0, 1, 2].map(|k| ON_TABLE[k] + to[k] - NORMAL[k] * off)) {
                self.row("plane", "table", ",,,,,,", &q);
                left -= 1;
            }
        }
        self
    }

    pub fn ball(&mut self, rows: usize) -> &mut Self {
        let mut left = rows;
        while left > 0 {
            let to = self.draw.point();
            let radius = (RADIUS + 2e-5 * self.draw.noise()) / dot(to, to).sqrt();
            if let Some(q) = self.touching([0, 1, 2].map(|k| BALL[k] + to[k] * radius)) {
                self.row("sphere", "ball", ",,,,,,", &q);
                left -= 1;
            }
        }
        self
    }

    pub fn gauge(&mut self, rows: usize) -> &mut Self {
        for _ in 0..rows {
            let q = self.anywhere();
            let value = 0.2 + dot(GAUGE, self.arm.tip(&q, &self.offsets)) + 4e-5 * self.draw.noise();
            self.row("linear", "gauge", &format!(",{:.5},,,,,", 1e3 * value), &q);
        }
        self
    }

    pub fn positions(&mut self, rows: usize) -> &mut Self {
        for _ in 0..rows {
            let q = self.anywhere();
            let p = self.arm.tip(&q, &self.offsets).map(|v| 1e3 * (v + 1e-4 * self.draw.noise()));
            self.row("position", "", &format!(",,{:.5},{:.5},{:.5},,", p[0], p[1], p[2]), &q);
        }
        self
    }

    /// Positions in a frame, three axes and an origin.
    pub fn series(&mut self, name: &str, rows: usize, frame: &[[f64; 3]; 4], noise: f64) -> &mut Self {
        for _ in 0..rows {
            let q = self.anywhere();
            let away = minus(self.arm.tip(&q, &self.offsets), frame[3]);
            let p = [0, 1, 2].map(|k| 1e3 * (dot(frame[k], away) + noise * self.draw.noise()));
            self.row("relative", name, &format!(",,{:.5},{:.5},{:.5},,", p[0], p[1], p[2]), &q);
        }
        self
    }

    /// What the camera sees of the tip; none where it is behind it or outside of the image.
    fn seen(&self, p: [f64; 3]) -> Option<[f64; 2]> {
        let away = minus(p, EYE);
        let [x, y, z] = LOOKS.map(|axis| dot(axis, away));
        let (x, y) = (x / z, y / z);
        let radial = 1.0 - 0.08 * (x * x + y * y);
        let [u, v] = [800.0 * x * radial + 640.0, 800.0 * y * radial + 480.0];
        (z > 0.3 && (2.0..1278.0).contains(&u) && (2.0..958.0).contains(&v)).then_some([u, v])
    }

    pub fn pixels(&mut self, rows: usize) -> &mut Self {
        let mut left = rows;
        while left > 0 {
            let q = self.anywhere();
            if let Some([u, v]) = self.seen(self.arm.tip(&q, &self.offsets)) {
                let [u, v] = [u + 0.04 * self.draw.noise(), v + 0.04 * self.draw.noise()];
                self.row("pixel", "eye", &format!(",,,,,{u:.4},{v:.4}"), &q);
                left -= 1;
            }
        }
        self
    }

    /// Images of points on the flange (m): what the camera sees of all of them at once, in rows of a table of their own.
    pub fn images(&mut self, count: usize, points: &[[f64; 3]]) -> String {
        let mut table = String::from(
            "kind,landmark,target,visit,u[px],v[px],j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad]\n",
        );
        let mut image = 0;
        while image < count {
            let q = self.anywhere();
            let see = |point: &[f64; 3]| self.seen(self.arm.point(&q, &self.offsets, *point));
            let Some(all) = points.iter().map(see).collect::<Option<Vec<_>>>() else { continue };
            let joints = q.map(|q| format!("{q:.9}")).join(",");
            for (k, [u, v]) in all.into_iter().enumerate() {
                let [u, v] = [u + 0.04 * self.draw.noise(), v + 0.04 * self.draw.noise()];
                writeln!(table, "pixel,eye,c{k},{image},{u:.4},{v:.4},{joints}").unwrap();
            }
            image += 1;
        }
        table
    }

    /// RMS of the distances between pairs of points that the fit of a folder predicts and those of the real arm, mm.
    pub fn lengths(&self, folder: &Folder) -> f64 {
        let mut draw = Draw(99);
        let joints: Vec<[f64; 6]> = (0..120).map(|_| std::array::from_fn(|_| 1.8 * draw.next())).collect();
        let mut table = String::from("j1[rad],j2[rad],j3[rad],j4[rad],j5[rad],j6[rad]\n");
        for q in &joints {
            writeln!(table, "{}", q.map(|q| format!("{q:.9}")).join(",")).unwrap();
        }
        folder.write("new.csv", &table);
        folder.run("predict --fit fit.json --data new.csv --out p.csv").ended(0);
        let predicted = positions(&folder.read("p.csv"));
        let truth: Vec<[f64; 3]> = joints.iter().map(|q| self.arm.tip(q, &self.offsets)).collect();
        let apart = |points: &[[f64; 3]], k: usize| {
            let away = minus(points[k], points[k + 1]);
            dot(away, away).sqrt()
        };
        let squares = (0..119).map(|k| (apart(&predicted, k) - apart(&truth, k)).powi(2)).sum::<f64>();
        1e3 * (squares / 119.0).sqrt()
    }
}

/// x, y, z of a file of predictions, m.
pub fn positions(text: &str) -> Vec<[f64; 3]> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = ["x[m]", "y[m]", "z[m]"].map(|name| header.iter().position(|cell| *cell == name).unwrap());
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            at.map(|k| cells[k].parse().unwrap())
        })
        .collect()
}

/// The description: the nominal arm, and what stands in the cell.
pub fn robot(landmarks: &str) -> String {
    let mut text = String::from("name = \"light\"\n\n[units]\nlength = \"mm\"\nangle = \"deg\"\n\n");
    for (k, [d, a, alpha]) in NOMINAL.0.iter().enumerate() {
        let (d, a) = (1e3 * d, 1e3 * a);
        writeln!(text, "[[joints]]\nname = \"j{}\"\ntype = \"revolute\"\nlimits = [-175, 175]\ndh = {{ theta = 0, d = {d}, a = {a}, alpha = {alpha} }}\n", k + 1).unwrap();
    }
    let tool = TOOL.map(|v| 1e3 * v);
    writeln!(text, "[tool]\nxyz = {tool:?}\n").unwrap();
    text + landmarks
}

pub const LANDMARKS: &str = "[[landmarks]]\nname = \"wire\"\nkind = \"distance\"\nfree = [\"offset\"]\n\n\
    [[landmarks]]\nname = \"table\"\nkind = \"plane\"\n\n\
    [[landmarks]]\nname = \"ball\"\nkind = \"sphere\"\nradius = 60\n\n\
    [[landmarks]]\nname = \"gauge\"\nkind = \"linear\"\n\n\
    [[cameras]]\nname = \"eye\"\nfx = 800\nfy = 800\ncx = 640\ncy = 480\ndistortion = [-0.08]\nsize = [1280, 960]\n";

pub fn identified(cell: &Cell, landmarks: &str) -> (Folder, serde_json::Value) {
    let folder = Folder::empty();
    folder.write("robot.toml", &robot(landmarks));
    folder.write("data.csv", &cell.rows);
    let words = "identify --robot robot.toml --data data.csv --out fit.json --json";
    let found = folder.run(words).ended(0).json();
    (folder, found)
}

pub fn kind<'a>(found: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let kinds = found["kinds"]["kinds"].as_array().unwrap();
    kinds.iter().find(|kind| kind["kind"] == name).unwrap()
}
