//! The links and joints of a URDF with their places in the text.

use crate::IoError;
use crate::text::Text;
use roxmltree::{Attribute, Document, Node, ParsingOptions};
use std::borrow::Cow;
use std::ops::Range;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::{Quaternion, UnitQuaternion};

/// Elements nest no deeper than this in any robot description.
const DEEPEST: usize = 200;
/// No robot description has more elements, texts and comments.
const MOST_NODES: u32 = 1 << 20;

/// A URDF. Places are byte offsets.
#[derive(Debug)]
pub(super) struct Urdf {
    pub name: String,
    pub at: usize,
    /// Behind the `>` of `<robot …>`.
    pub opened: usize,
    pub links: Vec<UrdfLink>,
    pub joints: Vec<UrdfJoint>,
}

#[derive(Debug)]
pub(super) struct UrdfLink {
    pub name: String,
    pub at: usize,
    /// In kg.
    pub mass: f64,
    /// Centre of mass in the link's frame, in m.
    pub com: [f64; 3],
}

#[derive(Debug)]
pub(super) struct UrdfJoint {
    pub name: String,
    pub at: usize,
    /// Behind the `>` of `<joint …>`.
    pub opened: usize,
    pub kind: String,
    pub parent: String,
    pub child: String,
    pub origin: Pose,
    /// The `<origin>`, where there is one.
    pub written: Option<UrdfOrigin>,
    pub axis: [f64; 3],
    /// Lower and upper limit in rad or m; infinite where version 1.2 has none.
    pub limits: Option<(f64, f64)>,
    pub mimic: Option<UrdfMimic>,
}

/// Places of an `<origin>`.
#[derive(Debug)]
pub(super) struct UrdfOrigin {
    /// Behind its name.
    pub named: usize,
    /// The values of these attributes, without quotes.
    pub xyz: Option<Range<usize>>,
    pub rpy: Option<Range<usize>>,
    /// The whole attribute.
    pub quat_xyzw: Option<Range<usize>>,
}

#[derive(Debug)]
pub(super) struct UrdfMimic {
    pub joint: String,
    pub ratio: f64,
    pub offset: f64,
}

impl Urdf {
    /// # Errors
    /// What is not XML or not a URDF, with its line and column.
    pub(super) fn read(text: &Text) -> Result<Urdf, IoError> {
        if text.text.trim().is_empty() {
            return Err(IoError::file(&text.file, "is empty; a URDF begins with <robot name=\"…\">"));
        }
        let bound = bound(&text.text);
        let document = parsed(&bound).map_err(|error| {
            let (line, column) = (u64::from(error.pos().row), u64::from(error.pos().col));
            let message = match error {
                roxmltree::Error::DtdDetected => {
                    "document type declarations are not read; remove the `<!…>`".into()
                }
                _ if !text.text.contains("<robot") && !text.text.trim_start().starts_with('<') => {
                    "is not a URDF: it has no <robot>".into()
                }
                // The place is in front already.
                other => {
                    format!(
                        "is not a valid URDF: {}",
                        other.to_string().replace(&format!(" at {line}:{column}"), "")
                    )
                }
            };
            IoError::Text { file: text.file.clone(), line, column, message }
        })?;
        let root = document.root_element();
        let reader = Reader { text, version: version(root) };
        if root.tag_name().name() != "robot" {
            let message = format!("is not a URDF: it begins with <{}>, not <robot>", root.tag_name().name());
            return Err(reader.error(root, message));
        }
        reader.depth(root)?;
        // A property whose value nobody uses any more is harmless.
        let left = root.descendants().find_map(|node| {
            let (name, space) = (node.tag_name().name(), node.tag_name().namespace());
            let own =
                name.strip_prefix("xacro_").or(space.filter(|at| at.contains("xacro")).map(|_| name))?;
            (!["property", "arg"].contains(&own)).then_some((node, own))
        });
        if let Some((node, name)) = left {
            return Err(reader.error(node, format!("<xacro:{name}> is left; {EXPAND}")));
        }
        let named = |element: &'static str| {
            root.children().filter(move |node| node.is_element() && node.tag_name().name() == element)
        };
        Ok(Urdf {
            name: root.attribute("name").unwrap_or_default().into(),
            at: root.range().start,
            opened: reader.opened(root),
            links: named("link").map(|node| reader.link(node)).collect::<Result<_, _>>()?,
            joints: named("joint").map(|node| reader.joint(node)).collect::<Result<_, _>>()?,
        })
    }

    /// Place of the joint of this name; that of the robot where there is none.
    pub(super) fn joint_at(&self, name: &str) -> usize {
        self.joints.iter().find(|joint| joint.name == name).map_or(self.at, |joint| joint.at)
    }
}

fn parsed(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options)
}

/// What to do with a description that is no URDF yet.
const EXPAND: &str = "expand the file first, as in `xacro arm.urdf.xacro > arm.urdf`";

/// The text with prefixes that no namespace is declared for as parts of names, as parsers that know no namespaces read it: every byte stays
/// where it was.
fn bound(text: &str) -> Cow<'_, str> {
    /// Prefixes at most.
    const MOST: usize = 32;
    let mut bound = Cow::Borrowed(text);
    for _ in 0..MOST {
        let prefix = match parsed(&bound) {
            Err(roxmltree::Error::UnknownNamespace(prefix, _)) => prefix,
            _ => break,
        };
        let mut next = bound.into_owned();
        for before in ["<", "</", " ", "\t", "\n"] {
            next = next.replace(&format!("{before}{prefix}:"), &format!("{before}{prefix}_"));
        }
        bound = Cow::Owned(next);
    }
    bound
}

/// Version of the format, 1.0 where none is declared.
fn version(root: Node<'_, '_>) -> (u32, u32) {
    let parse = |text: &str| {
        let (major, minor) = text.trim().split_once('.')?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    root.attribute("version").and_then(parse).unwrap_or((1, 0))
}

struct Reader<'t> {
    text: &'t Text,
    version: (u32, u32),
}

impl Reader<'_> {
    fn error(&self, node: Node<'_, '_>, message: impl Into<String>) -> IoError {
        self.text.error(node.range().start, message)
    }

    fn depth(&self, root: Node<'_, '_>) -> Result<(), IoError> {
        let (mut node, mut depth) = (root, 1);
        while let Some(next) = node.first_element_child().map(|child| (child, depth + 1)).or_else(|| {
            node.ancestors()
                .take(depth)
                .enumerate()
                .find_map(|(up, above)| Some((above.next_sibling_element()?, depth - up)))
        }) {
            (node, depth) = next;
            if depth > DEEPEST {
                let message = format!("elements nest more than {DEEPEST} deep; this is not a URDF");
                return Err(self.error(node, message));
            }
        }
        Ok(())
    }

    /// Behind the `>` that ends the opening tag of an element, not one within quotes.
    fn opened(&self, node: Node<'_, '_>) -> usize {
        let mut quote = None;
        for (at, byte) in self.text.text.bytes().enumerate().skip(node.range().start) {
            match (quote, byte) {
                (None, b'>') => return at + 1,
                (None, b'"' | b'\'') => quote = Some(byte),
                (Some(open), byte) if open == byte => quote = None,
                _ => {}
            }
        }
        self.text.text.len()
    }

    fn link(&self, node: Node<'_, '_>) -> Result<UrdfLink, IoError> {
        let name = self.required(node, "name")?;
        let (mut mass, mut com) = (0.0, [0.0; 3]);
        if let Some(inertial) = child(node, "inertial") {
            let Some(given) = child(inertial, "mass") else {
                return Err(self.error(inertial, format!("the inertial of link `{name}` has no <mass>")));
            };
            mass = self.number(given, "value")?.ok_or_else(|| self.error(given, "<mass> has no `value`"))?;
            if let Some(origin) = child(inertial, "origin") {
                com = self.triple(origin, "xyz")?.unwrap_or_default();
            }
        }
        Ok(UrdfLink { name, at: node.range().start, mass, com })
    }

    fn joint(&self, node: Node<'_, '_>) -> Result<UrdfJoint, IoError> {
        let name = self.required(node, "name")?;
        let end = |element: &str| match child(node, element) {
            Some(end) => self.required(end, "link"),
            None => Err(self.error(node, format!("joint `{name}` has no <{element} link=…>"))),
        };
        let (origin, written) = match child(node, "origin") {
            Some(origin) => self.origin(origin)?,
            None => (Pose::IDENTITY, None),
        };
        let axis = child(node, "axis").map(|axis| self.triple(axis, "xyz")).transpose()?.flatten();
        let open = if self.version >= (1, 2) { f64::INFINITY } else { 0.0 };
        let limits = child(node, "limit").map(|limit| {
            let (lower, upper) = (self.number(limit, "lower")?, self.number(limit, "upper")?);
            Ok((lower.unwrap_or(-open), upper.unwrap_or(open)))
        });
        let mimic = child(node, "mimic").map(|mimic| {
            Ok(UrdfMimic {
                joint: self.required(mimic, "joint")?,
                ratio: self.number(mimic, "multiplier")?.unwrap_or(1.0),
                offset: self.number(mimic, "offset")?.unwrap_or(0.0),
            })
        });
        Ok(UrdfJoint {
            at: node.range().start,
            opened: self.opened(node),
            kind: self.required(node, "type")?,
            parent: end("parent")?,
            child: end("child")?,
            origin,
            written,
            axis: axis.unwrap_or([1.0, 0.0, 0.0]),
            limits: limits.transpose()?,
            mimic: mimic.transpose()?,
            name,
        })
    }

    /// `quat_xyzw` is of version 1.1, and is ignored below, as ROS does.
    fn origin(&self, node: Node<'_, '_>) -> Result<(Pose, Option<UrdfOrigin>), IoError> {
        let xyz = self.triple(node, "xyz")?.unwrap_or_default();
        let rpy = self.triple(node, "rpy")?;
        let mut pose = Pose::from_xyz_rpy(xyz, rpy.unwrap_or_default());
        let quaternion = node.attribute_node("quat_xyzw").filter(|_| self.version >= (1, 1));
        if let Some(given) = quaternion {
            if rpy.is_some() {
                return Err(self.error(node, "<origin> has both `rpy` and `quat_xyzw`; give one of them"));
            }
            let [x, y, z, w] = self.numbers(given)?;
            let unit = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9)
                .ok_or_else(|| self.error(node, "`quat_xyzw` has no direction"))?;
            pose.rotation = unit.to_rotation_matrix().into_inner();
        }
        let value = |name: &str| node.attribute_node(name).map(|attribute| attribute.range_value());
        let written = UrdfOrigin {
            named: node.range().start + "<origin".len(),
            xyz: value("xyz"),
            rpy: value("rpy"),
            quat_xyzw: quaternion.map(|attribute| attribute.range()),
        };
        Ok((pose, Some(written)))
    }

    fn required(&self, node: Node<'_, '_>, name: &str) -> Result<String, IoError> {
        node.attribute(name)
            .map(String::from)
            .ok_or_else(|| self.error(node, format!("<{}> has no `{name}`", node.tag_name().name())))
    }

    fn number(&self, node: Node<'_, '_>, name: &str) -> Result<Option<f64>, IoError> {
        let number = node.attribute_node(name).map(|attribute| self.numbers::<1>(attribute));
        Ok(number.transpose()?.map(|[value]| value))
    }

    fn triple(&self, node: Node<'_, '_>, name: &str) -> Result<Option<[f64; 3]>, IoError> {
        node.attribute_node(name).map(|attribute| self.numbers(attribute)).transpose()
    }

    /// The numbers of an attribute, which has as many as are wanted.
    fn numbers<const N: usize>(&self, attribute: Attribute<'_, '_>) -> Result<[f64; N], IoError> {
        let words: Vec<&str> = attribute.value().split_whitespace().collect();
        let numbers: Result<Vec<f64>, _> = words.iter().map(|word| word.parse()).collect();
        numbers.ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| {
            let wanted = if N == 1 { "a number".into() } else { format!("{N} numbers") };
            let xacro = attribute.value().contains("${") || attribute.value().contains("$(");
            let hint = if xacro { format!(": a xacro expression is left; {EXPAND}") } else { String::new() };
            let message = format!("`{}=\"{}\"` is not {wanted}{hint}", attribute.name(), attribute.value());
            self.text.error(attribute.range_value().start, message)
        })
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.is_element() && child.tag_name().name() == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Urdf, String> {
        let text = Text { file: "a.urdf".into(), text: text.into() };
        Urdf::read(&text).map_err(|error| error.to_string())
    }

    #[test]
    fn elements_have_places_and_numbers() {
        let text = "<?xml version='1.0'?><!-- <joint name='no'/> --><robot name=\"r\" version='1.1'>\n<link name='b'/>\
                    <joint name = 'j>1' type='revolute'><origin xyz='1 2 3' quat_xyzw='0 0 1 0'/><parent link='b'/><child link='b'/></joint></robot>";
        let urdf = read(text).unwrap();
        assert_eq!((urdf.name.as_str(), urdf.links.len(), urdf.joints.len()), ("r", 1, 1));
        assert_eq!(&text[urdf.opened..=urdf.opened], "\n");
        let joint = &urdf.joints[0];
        assert!(text[joint.at..].starts_with("<joint name = 'j>1'"));
        assert!(text[joint.opened..].starts_with("<origin"));
        let written = joint.written.as_ref().unwrap();
        assert_eq!(&text[written.xyz.clone().unwrap()], "1 2 3");
        assert_eq!(&text[written.quat_xyzw.clone().unwrap()], "quat_xyzw='0 0 1 0'");
        assert!((joint.origin.rotation[(0, 0)] + 1.0).abs() < 1e-15);
        assert_eq!(urdf.joint_at("j>1"), joint.at);
        assert_eq!(urdf.joint_at("other"), urdf.at);
    }

    #[test]
    fn prefixes_without_a_namespace_are_parts_of_names() {
        let text = "<robot name='a'>\n<link name='l'/><gazebo><sensor:camera a:b='1' name='c:d'/></gazebo>\n<joint name='j' type='fixed'><parent link='l'/><child link='l'/><origin xyz='1 2 3'/></joint></robot>";
        let urdf = read(text).unwrap();
        let written = urdf.joints[0].written.as_ref().unwrap().xyz.clone().unwrap();
        assert_eq!(&text[written], "1 2 3");
        assert!(read("<robot><x:property name='l' value='2'/><link name='l'/></robot>").is_ok());
    }

    #[test]
    fn errors_have_places() {
        let deep = |n: usize| format!("<robot>{}{}</robot>", "<a>".repeat(n), "</a>".repeat(n));
        assert!(read(&deep(DEEPEST - 1)).is_ok());
        assert!(read(&deep(100_000)).unwrap_err().contains("nest more than 200 deep"));
        for (text, message) in [
            ("<robot>\n <link/></robot>", "a.urdf:2:2: <link> has no `name`"),
            (
                "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>\n <xacro:arm side='l'/></robot>",
                "a.urdf:2:2: <xacro:arm> is left; expand the file first",
            ),
            ("<robot>\n <xacro:include filename='a'/></robot>", "a.urdf:2:2: <xacro:include> is left"),
            (
                "<robot><joint name='j' type='fixed'><origin xyz='0 0 ${l}'/></joint></robot>",
                "a.urdf:1:50: `xyz=\"0 0 ${l}\"` is not 3 numbers: a xacro expression is left; expand",
            ),
            ("<robot", "a.urdf:1:1: is not a valid URDF: "),
            ("<!DOCTYPE x><robot/>", "a.urdf:1:1: document type declarations are not read"),
            (
                "<robot><link name='l'><inertial><mass value='1kg'/></inertial></link></robot>",
                "a.urdf:1:46: `value=\"1kg\"` is not a number",
            ),
            (
                "<robot><link name='l'><inertial/></link></robot>",
                "a.urdf:1:23: the inertial of link `l` has no <mass>",
            ),
            (
                "<robot><joint name='j' type='fixed'><origin xyz='1 2'/></joint></robot>",
                "a.urdf:1:50: `xyz=\"1 2\"` is not 3 numbers",
            ),
            ("<robot><joint name='j' type='fixed'/></robot>", "a.urdf:1:8: joint `j` has no <parent link=…>"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
