//! Looking at the machine: libraries in the linker's cache, headers by pkg-config, Vulkan drivers
//! by their manifests, GPUs by their device nodes.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::process;

/// How to see whether something is there.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Probe {
    /// A program on `PATH`.
    Program(&'static str),
    /// A package that pkg-config knows (so with headers).
    PkgConfig(&'static str),
    /// Any one of these shared libraries.
    Library(&'static [&'static str]),
    /// A Vulkan driver that will find a device here.
    VulkanDriver,
}

/// What was found.
#[derive(Debug, Default)]
pub(crate) struct Machine {
    /// File names of shared libraries, for example `libvulkan.so.1`.
    libraries: HashSet<String>,
    /// Vulkan drivers whose library exists.
    drivers: Vec<Driver>,
    /// Device nodes through which a GPU renders.
    gpus: Vec<PathBuf>,
}

/// A Vulkan driver by its manifest.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Driver {
    name: String,
    /// Renders on the CPU, so it needs no device.
    on_cpu: bool,
}

impl Machine {
    /// Looks around; nothing is started but `ldconfig`.
    pub(crate) fn look() -> Self {
        if !cfg!(target_os = "linux") {
            return Self::default();
        }
        let libraries = libraries();
        let drivers = manifests()
            .iter()
            .filter_map(|path| {
                let text = std::fs::read_to_string(path).ok()?;
                let library = library_path(&text)?;
                let there = if library.contains('/') {
                    path.parent()?.join(&library).exists()
                } else {
                    libraries.contains(&library)
                };
                let name = path.file_stem()?.to_string_lossy();
                there.then(|| Driver::new(&name))
            })
            .collect();
        Self { libraries, drivers, gpus: gpu_nodes() }
    }

    /// Whether the probed thing is there.
    pub(crate) fn has(&self, probe: &Probe) -> bool {
        match probe {
            Probe::Program(name) => process::is_on_path(name),
            Probe::PkgConfig(name) => process::output("pkg-config", &["--exists", name]).is_some(),
            Probe::Library(names) => names.iter().any(|name| self.libraries.contains(*name)),
            Probe::VulkanDriver => self.has_gpu() || self.drivers.iter().any(|one| one.on_cpu),
        }
    }

    /// Whether a GPU's device node and a driver for GPUs are there. A driver alone says nothing:
    /// Mesa installs one for every make.
    pub(crate) fn has_gpu(&self) -> bool {
        !self.gpus.is_empty() && self.drivers.iter().any(|driver| !driver.on_cpu)
    }

    /// One line for people.
    pub(crate) fn summary(&self) -> String {
        let list = |names: Vec<String>| {
            if names.is_empty() { "none".to_owned() } else { names.join(", ") }
        };
        format!(
            "GPU device nodes: {}. Vulkan drivers: {}.",
            list(self.gpus.iter().map(|path| path.display().to_string()).collect()),
            list(self.drivers.iter().map(|driver| driver.name.clone()).collect()),
        )
    }
}

impl Driver {
    /// `stem` is the manifest's file name without extension, for example `lvp_icd.x86_64`.
    fn new(stem: &str) -> Self {
        let on_cpu = ["lvp", "swiftshader", "swrast"].iter().any(|cpu| stem.contains(cpu));
        Self { name: stem.to_owned(), on_cpu }
    }
}

/// Names of the shared libraries that a program can load by name.
fn libraries() -> HashSet<String> {
    // Debian keeps ldconfig off the path of ordinary users.
    let cache = ["/sbin/ldconfig", "/usr/sbin/ldconfig", "ldconfig"]
        .iter()
        .find_map(|program| process::output(program, &["-p"]));
    let mut names = cache.map(|text| parse_ldconfig(&text)).unwrap_or_default();
    let machine = format!("{}-linux-gnu", std::env::consts::ARCH);
    let mut folders: Vec<PathBuf> = ["/usr/lib", "/usr/lib64", "/usr/local/lib", "/lib"]
        .iter()
        .flat_map(|folder| [PathBuf::from(folder), Path::new(folder).join(&machine)])
        .collect();
    if let Some(more) = std::env::var_os("LD_LIBRARY_PATH") {
        folders.extend(std::env::split_paths(&more));
    }
    for entry in folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten() {
        let Ok(entry) = entry else { continue };
        let name = entry.file_name().to_string_lossy().into_owned();
        // A dangling link is no library.
        if name.contains(".so") && entry.path().exists() {
            names.insert(name);
        }
    }
    names
}

/// Names in the output of `ldconfig -p` that are for this processor.
fn parse_ldconfig(text: &str) -> HashSet<String> {
    let tag = match std::env::consts::ARCH {
        "x86_64" => Some("x86-64"),
        "aarch64" => Some("AArch64"),
        _ => None,
    };
    text.lines()
        .filter_map(|line| line.trim().split_once(' '))
        .filter(|(name, _)| name.contains(".so"))
        .filter(|(_, rest)| tag.is_none_or(|tag| rest.contains(tag)))
        .map(|(name, _)| name.to_owned())
        .collect()
}

/// Manifests of Vulkan drivers, where the loader looks for them (Khronos, "Vulkan Loader
/// Interface": driver discovery on Linux).
fn manifests() -> Vec<PathBuf> {
    let chosen = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"]
        .iter()
        .find_map(std::env::var_os)
        .filter(|paths| !paths.is_empty());
    if let Some(paths) = chosen {
        return std::env::split_paths(&paths).collect();
    }
    let home = std::env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
    [
        PathBuf::from("/etc/vulkan/icd.d"),
        PathBuf::from("/usr/local/share/vulkan/icd.d"),
        PathBuf::from("/usr/share/vulkan/icd.d"),
        home.join(".local/share/vulkan/icd.d"),
    ]
    .iter()
    .filter_map(|folder| std::fs::read_dir(folder).ok())
    .flatten()
    .filter_map(|entry| Some(entry.ok()?.path()))
    .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
    .collect()
}

/// `library_path` of a driver's manifest.
fn library_path(manifest: &str) -> Option<String> {
    let (_, rest) = manifest.split_once("\"library_path\"")?;
    let (_, rest) = rest.split_once(':')?;
    let (_, rest) = rest.split_once('"')?;
    rest.split_once('"').map(|(path, _)| path.to_owned())
}

/// Render nodes of the kernel's graphics drivers, of NVIDIA's own, and of WSL.
fn gpu_nodes() -> Vec<PathBuf> {
    let mut nodes: Vec<PathBuf> = std::fs::read_dir("/dev/dri")
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("renderD"))
        })
        .collect();
    let others = ["/dev/nvidia0", "/dev/dxg"].map(PathBuf::from);
    nodes.extend(others.into_iter().filter(|path| path.exists()));
    nodes.sort();
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine(gpus: &[&str], drivers: &[&str]) -> Machine {
        Machine {
            libraries: HashSet::from(["libX11.so.6".to_owned()]),
            drivers: drivers.iter().map(|name| Driver::new(name)).collect(),
            gpus: gpus.iter().map(PathBuf::from).collect(),
        }
    }

    #[test]
    fn a_driver_counts_only_with_its_device() {
        let mesa = ["intel_icd.x86_64", "radeon_icd.x86_64"];
        let node = ["/dev/dri/renderD128"];
        assert!(!machine(&[], &mesa).has(&Probe::VulkanDriver));
        assert!(!machine(&node, &[]).has(&Probe::VulkanDriver));
        assert!(machine(&node, &mesa).has(&Probe::VulkanDriver));
        assert!(machine(&[], &["lvp_icd.x86_64"]).has(&Probe::VulkanDriver));
        assert!(!machine(&node, &["lvp_icd.x86_64"]).has_gpu());
    }

    #[test]
    fn any_one_of_the_libraries_is_enough() {
        let machine = machine(&[], &[]);
        assert!(machine.has(&Probe::Library(&["libnone.so", "libX11.so.6"])));
        assert!(!machine.has(&Probe::Library(&["libX11.so"])));
    }

    #[test]
    fn the_library_cache_is_read_for_this_processor() {
        let text = "2 libs found in cache `/etc/ld.so.cache'\n\
            \tlibvulkan.so.1 (libc6,x86-64) => /lib/x86_64-linux-gnu/libvulkan.so.1\n\
            \tlibvulkan.so.1 (libc6,AArch64) => /lib/aarch64-linux-gnu/libvulkan.so.1\n\
            \tlibold.so.1 (libc6) => /lib/i386-linux-gnu/libold.so.1\n";
        let names = parse_ldconfig(text);
        assert!(names.contains("libvulkan.so.1"));
        if cfg!(any(target_arch = "x86_64", target_arch = "aarch64")) {
            assert!(!names.contains("libold.so.1"));
        }
    }

    #[test]
    fn the_library_of_a_manifest() {
        let manifest = "{ \"ICD\": { \"api_version\": \"1.3.2\",\n \"library_path\" : \
                        \"/usr/lib/libvulkan_lvp.so\" }, \"file_format_version\": \"1.0.0\" }";
        assert_eq!(library_path(manifest).as_deref(), Some("/usr/lib/libvulkan_lvp.so"));
        assert_eq!(library_path("{}"), None);
        assert_eq!(library_path("{\"library_path\":"), None);
    }
}
