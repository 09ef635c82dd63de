//! Shadows, fog and everything else of a scene.
