//! Solved light on surfaces that becomes another one.

use bevy::prelude::*;
use farlight_core::LightingChanged;

use crate::{Disturb, changes::KEEP_LIGHT};

/// Pictures follow light that others write into textures.
pub(crate) fn notice(
    mut relit: MessageReader<LightingChanged>,
    mut disturb: MessageWriter<Disturb>,
) {
    if relit.read().count() > 0 {
        disturb.write(Disturb { sphere: None, keep: KEEP_LIGHT });
    }
}
