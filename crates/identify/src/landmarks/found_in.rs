//! Effects of a campaign by their type.

use truepose_errormodel::AnyEffect;

/// The effect of a kind.
pub(super) fn found_in<E: 'static>(effects: &[Box<dyn AnyEffect>]) -> Option<&E> {
    effects.iter().find_map(|effect| effect.concrete())
}
