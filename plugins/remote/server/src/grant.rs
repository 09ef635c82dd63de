//! What a client gets of what it asks for.

use farlight_gi_solver::session::SessionSettings;

use crate::settings::{ServerSettings, bytes};

/// The settings of a session: what was asked for, within what the server allows. What changes how
/// light has to be shown (the size of a page) is refused rather than changed.
///
/// # Errors
/// A sentence for the client: what it asked for, and what it could get.
pub(crate) fn grant(
    server: &ServerSettings,
    asked: &SessionSettings,
) -> Result<SessionSettings, String> {
    let page_size = asked.page_size;
    if !page_size.is_power_of_two() || page_size < 16 {
        return Err(format!(
            "a lightmap page of {page_size} texels was asked for; its edge must be a power of two \
             from 16"
        ));
    }
    if page_size > server.max_page_size {
        return Err(format!(
            "a lightmap page of {page_size} texels was asked for; this server gives {} at most",
            server.max_page_size
        ));
    }
    let page_texels = u64::from(page_size) * u64::from(page_size);
    let pages = u64::from(server.max_texels) / page_texels;
    if pages == 0 {
        return Err(format!(
            "a lightmap page of {page_texels} texels was asked for; this server gives {} at most",
            server.max_texels
        ));
    }
    if !asked.texels_per_metre.is_finite() {
        return Err(format!("{} texels a metre were asked for", asked.texels_per_metre));
    }
    let pages = u32::try_from(pages).unwrap_or(u32::MAX).min(server.max_pages);
    Ok(SessionSettings {
        page_size,
        max_pages: asked.max_pages.clamp(1, pages),
        texels_per_metre: asked.texels_per_metre.clamp(0.01, 1000.0),
        rays_per_texel: asked.rays_per_texel.clamp(64, 8192),
        rays_per_probe: asked.rays_per_probe.clamp(64, 65_536),
        ray_memory: asked.ray_memory.min(bytes(server.ray_memory_mib)),
        bounces: asked.bounces.clamp(1, 64),
        converged_paths: asked.converged_paths.min(1 << 24),
        seed: asked.seed,
        threads: server.threads as usize,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_server_allows_is_granted_unchanged() {
        let asked = SessionSettings::default();
        assert_eq!(grant(&ServerSettings::default(), &asked), Ok(asked));
    }

    #[test]
    fn numbers_are_lowered() {
        let server = ServerSettings {
            max_pages: 3,
            max_texels: 5 * 512 * 512,
            ray_memory_mib: 16,
            threads: 2,
            ..ServerSettings::default()
        };
        let asked = SessionSettings {
            max_pages: u32::MAX,
            ray_memory: usize::MAX,
            rays_per_texel: u32::MAX,
            converged_paths: u32::MAX,
            bounces: 0,
            threads: 99,
            ..SessionSettings::default()
        };
        let granted = grant(&server, &asked).unwrap();
        assert_eq!(granted.max_pages, 3);
        assert_eq!(granted.ray_memory, 16 << 20);
        assert_eq!(granted.rays_per_texel, 8192);
        assert_eq!(granted.converged_paths, 1 << 24);
        assert_eq!((granted.bounces, granted.threads), (1, 2));
        let server = ServerSettings { max_texels: 2 * 512 * 512 + 1, ..server };
        assert_eq!(grant(&server, &asked).unwrap().max_pages, 2);
    }

    #[test]
    fn pages_that_are_too_large_are_refused_with_both_numbers() {
        let server = ServerSettings { max_page_size: 256, ..ServerSettings::default() };
        let ask = |server: &ServerSettings, page_size| {
            grant(server, &SessionSettings { page_size, ..SessionSettings::default() })
        };
        let why = ask(&server, 512).unwrap_err();
        assert!(why.contains("512") && why.contains("256"), "{why}");
        assert!(ask(&server, 100).is_err() && ask(&server, 0).is_err() && ask(&server, 8).is_err());
        let server = ServerSettings { max_texels: 1000, ..server };
        let why = ask(&server, 64).unwrap_err();
        assert!(why.contains("4096") && why.contains("1000"), "{why}");
        let asked = SessionSettings { texels_per_metre: f32::NAN, ..SessionSettings::default() };
        assert!(grant(&ServerSettings::default(), &asked).is_err());
    }
}
