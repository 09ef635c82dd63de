//! Every pure module is valid and can be translated for every graphics interface.

use std::path::{Path, PathBuf};

use farlight_shaders::{ComposeError, Definition, MODULES, compose};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};

/// Where the tables of materials are bound, and every set of the names that decide something in a
/// module's folder.
fn definitions(path: &str) -> Vec<Vec<Definition<'static>>> {
    let names = [
        "BTF_HALF_END_SLOPE",
        "BTF_GUARD_BETA_POLE",
        "BTF_LINEAR",
        "STILL",
        "RESTED",
        "DEPTH",
        "VOLUME",
        "SAMPLES",
    ];
    let folder = |path: &'static str| path.split_once('/').map_or("", |(folder, _)| folder);
    let here = path.split_once('/').map_or("", |(folder, _)| folder);
    let decides = |name: &str| {
        let source = |module: &farlight_shaders::Module| module.source.contains(name);
        MODULES.iter().filter(|module| folder(module.path) == here).any(source)
    };
    let names: Vec<_> = names.into_iter().filter(|name| decides(name)).collect();
    (0..1 << names.len())
        .map(|set| {
            let chosen = (0..names.len()).filter(|name| set >> name & 1 == 1);
            let mut definitions =
                vec![Definition::Number("BTF_GROUP", 0), Definition::Number("BTF_TABLES", 1)];
            definitions.extend(chosen.map(|name| Definition::Flag(names[name])));
            definitions
        })
        .collect()
}

fn validate(name: &str, module: &Module) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .unwrap_or_else(|error| panic!("{name}: {error:?}"))
}

fn to_spirv(name: &str, module: &Module, info: &ModuleInfo) {
    let words =
        naga::back::spv::write_vec(module, info, &naga::back::spv::Options::default(), None)
            .unwrap_or_else(|error| panic!("{name}, SPIR-V: {error}"));
    assert!(words.len() > 5, "{name}: only a header");
}

fn to_msl(name: &str, module: &Module, info: &ModuleInfo) {
    let options = naga::back::msl::Options {
        fake_missing_bindings: true,
        ..naga::back::msl::Options::default()
    };
    naga::back::msl::write_string(module, info, &options, &Default::default())
        .unwrap_or_else(|error| panic!("{name}, MSL: {error}"));
}

fn to_hlsl(name: &str, module: &Module, info: &ModuleInfo) {
    let mut text = String::new();
    let options = naga::back::hlsl::Options {
        fake_missing_bindings: true,
        ..naga::back::hlsl::Options::default()
    };
    let pipeline = naga::back::hlsl::PipelineOptions::default();
    naga::back::hlsl::Writer::new(&mut text, &options, &pipeline)
        .write(module, info, None)
        .unwrap_or_else(|error| panic!("{name}, HLSL: {error}"));
}

#[test]
fn pure_modules_are_translated_for_every_interface() {
    for shader in MODULES.iter().filter(|module| module.pure) {
        for definitions in definitions(shader.path) {
            let name = format!("{} {definitions:?}", shader.path);
            let module = compose(shader.path, &definitions)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            let info = validate(&name, &module);
            to_spirv(&name, &module, &info);
            to_msl(&name, &module, &info);
            to_hlsl(&name, &module, &info);
            // A kernel has an entry point, perhaps with vertices of its own; a module to import has
            // none.
            let kernel = !shader.source.contains("#define_import_path");
            let stages = [ShaderStage::Compute, ShaderStage::Fragment];
            let entries = module.entry_points.iter().filter(|entry| stages.contains(&entry.stage));
            assert_eq!(entries.count(), usize::from(kernel), "{name}");
            assert!(kernel || module.entry_points.is_empty(), "{name}");
        }
    }
}

#[test]
fn a_module_is_found_where_its_import_path_says() {
    for module in MODULES {
        let Some(line) = module.source.lines().find(|line| line.starts_with("#define_import_path"))
        else {
            continue;
        };
        let expected = module.path.trim_end_matches(".wgsl").replace('/', "::");
        assert_eq!(line, format!("#define_import_path farlight::{expected}"), "{}", module.path);
    }
}

#[test]
fn what_is_pure_imports_nothing_of_the_engine() {
    for module in MODULES {
        let engine = module
            .source
            .lines()
            .filter(|line| line.trim_start().starts_with("#import"))
            .any(|line| !line.trim_start().starts_with("#import farlight::"));
        assert!(!(module.pure && engine), "{}", module.path);
    }
}

#[test]
fn every_file_is_listed() {
    fn files(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files(&path, found);
            } else if path.extension().is_some_and(|extension| extension == "wgsl") {
                found.push(path);
            }
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    files(folder, &mut found);
    assert!(!found.is_empty());
    for path in &found {
        let path = path.strip_prefix(folder).unwrap();
        let name = path.to_str().unwrap().replace(std::path::MAIN_SEPARATOR, "/");
        assert!(MODULES.iter().any(|module| module.path == name), "{name} is not in MODULES");
    }
    assert_eq!(found.len(), MODULES.len());
}

#[test]
fn errors_name_the_place() {
    assert!(matches!(compose("btf/no_such.wgsl", &[]), Err(ComposeError::Unknown(_))));
    // The bindings are not defined.
    let Err(ComposeError::Wrong(text)) = compose("btf/evaluate.wgsl", &[]) else {
        panic!("composed without its bindings");
    };
    assert!(text.contains("btf/tables.wgsl:6"), "{text}");
}
