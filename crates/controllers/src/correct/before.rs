//! Where the robot is before a motion, as far as it is known.

/// Where the robot is before a motion.
#[derive(Debug, Clone, Default)]
pub(super) struct Before {
    /// Joints that it may have (variables); empty: not known.
    pub(super) joints: Vec<Vec<f64>>,
    /// Only shoulder, elbow and wrist are those of the joints: it has moved along a line since.
    pub(super) sides: bool,
    /// The point since which there are several, in words.
    pub(super) since: Option<String>,
    /// Configuration data of the point before that is not interpreted.
    pub(super) opaque: Option<String>,
}

/// How a motion comes to a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Travel {
    /// Along a line or an arc.
    pub(super) linear: bool,
    /// Whether the configuration data of the point is followed.
    pub(super) followed: bool,
}

/// Why the joints of a point are not known.
#[derive(Debug, Clone)]
pub(super) struct Open {
    pub(super) reason: String,
    /// Those that it may have, where they are a few.
    pub(super) may_be: Vec<Vec<f64>>,
}

impl From<String> for Open {
    fn from(reason: String) -> Open {
        Open { reason, may_be: Vec::new() }
    }
}

impl Open {
    /// The same with other joints.
    pub(super) fn of(self, joints: impl Fn(&[f64]) -> Vec<f64>) -> Open {
        Open { may_be: self.may_be.iter().map(|some| joints(some)).collect(), ..self }
    }
}

impl Before {
    pub(super) fn at(joints: Vec<f64>) -> Before {
        Before { joints: vec![joints], ..Before::default() }
    }

    /// The same with other joints.
    pub(super) fn of(&self, joints: impl Fn(&[f64]) -> Vec<f64>) -> Before {
        Before { joints: self.joints.iter().map(|all| joints(all)).collect(), ..self.clone() }
    }

    /// Behind a motion to a place that is not known.
    pub(super) fn elsewhere(&mut self, linear: bool) {
        self.opaque = None;
        if linear {
            self.sides = true;
        } else {
            self.joints.clear();
        }
    }

    /// Behind a motion to a point of these joints, or of what is known of them.
    pub(super) fn reach(
        &mut self,
        at: &Result<Vec<f64>, Open>,
        point: impl FnOnce() -> String,
        linear: bool,
    ) {
        match at {
            Ok(joints) => *self = Before::at(joints.clone()),
            Err(open) if open.may_be.is_empty() => self.elsewhere(linear),
            Err(open) => {
                let since = self.since.take().unwrap_or_else(point);
                *self = Before { joints: open.may_be.clone(), since: Some(since), ..Before::default() };
            }
        }
    }
}
