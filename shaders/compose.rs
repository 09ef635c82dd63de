//! Joins pure modules without an engine.

use std::collections::HashMap;

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue,
};

use crate::{MODULES, Module};

/// A shader definition: what `#ifdef NAME` and `#{NAME}` refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Definition<'a> {
    /// A name that is there.
    Flag(&'a str),
    /// A name that stands for a number.
    Number(&'a str, u32),
}

/// Why modules could not be joined.
#[derive(Debug, thiserror::Error)]
pub enum ComposeError {
    /// There is no such module.
    #[error("there is no shader module {0}")]
    Unknown(String),
    /// The module imports parts of an engine; only the engine can join it.
    #[error("{0} needs the engine")]
    Engine(&'static str),
    /// A module is wrong, or a definition is missing. The text names file and line and shows it.
    #[error("{0}")]
    Wrong(String),
}

/// The module of the file `path` (`"btf/evaluate_points.wgsl"`) joined with all that it imports,
/// and validated.
///
/// # Errors
///
/// A path that is not one of [`MODULES`] or not pure, modules that are wrong under these
/// definitions.
pub fn compose(path: &str, definitions: &[Definition]) -> Result<naga::Module, ComposeError> {
    let position = MODULES.iter().position(|module| module.path == path);
    let position = position.ok_or_else(|| ComposeError::Unknown(path.to_owned()))?;
    let module = &MODULES[position];
    if !module.pure {
        return Err(ComposeError::Engine(module.path));
    }
    join(&MODULES[..position], module.source, module.path, definitions)
}

/// A module of your own joined with the pure modules that it imports, and validated; `path` stands
/// in errors.
///
/// # Errors
///
/// Modules that are wrong under these definitions.
pub fn compose_source(
    source: &str,
    path: &str,
    definitions: &[Definition],
) -> Result<naga::Module, ComposeError> {
    join(MODULES, source, path, definitions)
}

fn join(
    modules: &[Module],
    source: &str,
    path: &str,
    definitions: &[Definition],
) -> Result<naga::Module, ComposeError> {
    let mut composer = Composer::default();
    for imported in modules.iter().filter(|module| module.pure) {
        if !imported.source.contains("#define_import_path") {
            continue; // a kernel
        }
        let added = composer.add_composable_module(ComposableModuleDescriptor {
            source: imported.source,
            file_path: imported.path,
            ..ComposableModuleDescriptor::default()
        });
        if let Err(error) = added {
            return Err(ComposeError::Wrong(error.emit_to_string(&composer)));
        }
    }
    let shader_defs: HashMap<_, _> = definitions
        .iter()
        .map(|definition| match definition {
            Definition::Flag(name) => ((*name).to_owned(), ShaderDefValue::Bool(true)),
            Definition::Number(name, value) => ((*name).to_owned(), ShaderDefValue::UInt(*value)),
        })
        .collect();
    composer
        .make_naga_module(NagaModuleDescriptor {
            source,
            file_path: path,
            shader_defs,
            ..NagaModuleDescriptor::default()
        })
        .map_err(|error| ComposeError::Wrong(error.emit_to_string(&composer)))
}
