//! The seam through which hypotheses enter a search.

use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::limits::Limit;
use crate::hypotheses::nonlinear::Nonlinear;
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use std::fmt::Debug;
use truepose_errormodel::AnyEffect;
use truepose_kinematics::JointId;

/// A sort of cause that a model may lack: which effects would describe it, and what the search has to know about them.
///
/// An [`Effect`](truepose_errormodel::Effect) says how an error arises from its coefficients; a hypothesis says where such an error is to be
/// suspected, in which variants, and how a finding is to be read. Three methods are required; the others have the values of a cause whose
/// effects are linear in few coefficients.
///
/// Effects that a method is given are those of the hypothesis' own [`Change::Add`](crate::Change::Add), singly or all of one candidate. A
/// concrete effect is recovered with `effect.concrete::<E>()`.
pub trait Hypothesis: Debug + Send + Sync {
    /// Its family: the word in files.
    fn family(&self) -> Family;

    /// All variants for a robot and its data, from few to many coefficients: every place where the cause may act, nonlinear parameters on a
    /// coarse grid. Those that do not fit the robot ([`Effect::validate`](truepose_errormodel::Effect::validate)) are left out by the search.
    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant>;

    /// One sentence for a mechanic: what a finding at this place means, and what to look at.
    fn meaning(&self, place: &Place) -> String;

    /// What drives it. Two findings with a driver in common are tested against one cause in place of both.
    fn drivers(&self, _place: &Place, _effects: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        Vec::new()
    }

    /// What a finding is drawn as, and against what: by default a site's error against the drivers.
    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site(self.drivers(place, effects))
    }

    /// The family beside which it stands in the order of simplicity. Of two explanations that the data cannot distinguish the simpler one is
    /// reported.
    fn rank(&self) -> Family {
        self.family()
    }

    /// How its coefficients are penalised.
    fn penalty(&self, _effects: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::Number
    }

    /// Signs and sizes that the mechanism can have.
    fn limits(&self) -> &[Limit] {
        &[]
    }

    /// Whether the name says no more than that the error is a curve over something (time, load): then an unmodelled structure that explains as
    /// much is listed beside it.
    fn is_curve(&self) -> bool {
        false
    }

    /// The parameter in which an effect is not linear, where it was found rather than known.
    fn nonlinear(&self, _effect: &dyn AnyEffect) -> Option<Nonlinear> {
        None
    }

    /// The effect with another value of that parameter: fixed, or to be found within a range. None where [`Self::nonlinear`] is none.
    fn with_value(
        &self,
        _effect: &dyn AnyEffect,
        _value: f64,
        _range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// A second parameter in which an effect is not linear, where it was found: the end of an interval, another time constant.
    fn second(&self, _effect: &dyn AnyEffect) -> Option<Nonlinear> {
        None
    }

    /// The effect with another value of the second parameter: fixed, or to be found within a range. None where [`Self::second`] is none.
    fn with_second(
        &self,
        _effect: &dyn AnyEffect,
        _value: f64,
        _range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// The effect of a change point that is known to lie between two instants, s; none of an effect without change point.
    fn between(&self, _effect: &dyn AnyEffect, _instants: [f64; 2]) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// The effect that is periodic in the value of a joint with this period, rad or m; none where the cause has no period there. The search
    /// tries all periods that the data can resolve, and several of one joint together.
    fn at_period(&self, _joint: JointId, _period: f64) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// The effect with one component fewer or more, each in turn.
    fn neighbours(&self, _effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        Vec::new()
    }

    /// The effect with more terms, tried when the variants of its place are compared.
    fn richer(&self, _effect: &dyn AnyEffect) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// Richer forms of an effect that the data may tell apart, tried when the variants of its place are compared: an interval in place of a step,
    /// a part of the travel in place of all of it. They are proposed for causes that are compared alone, so that the number of candidates of a screen
    /// does not grow with them.
    fn richer_in(&self, effect: &dyn AnyEffect, _setting: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        self.richer(effect).into_iter().collect()
    }
}
