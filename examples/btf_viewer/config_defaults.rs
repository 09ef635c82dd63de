//! What counts where the configuration says nothing: what the file that ships says.

use super::{
    CameraPlace, Environment, Headset, HeadsetMode, Light, Material, Model, Progressive,
    Resolution, Rig, Shape, Start, Viewer,
};

impl Default for Viewer {
    fn default() -> Self {
        let file = |name: &str| Model {
            name: name.into(),
            shape: Shape::File(format!("models/{name}.glb")),
            uv_metres: 1.0,
            turn: 0.0,
        };
        let shape = |name: &str, shape| Model { shape, ..file(name) };
        let environment = |name: &str| Environment {
            name: name.into(),
            path: format!("environments/{name}.hdr"),
            brightness: 1000.0,
            turn: 0.0,
        };
        Self {
            window: (1280, 720),
            resolution: Resolution::default(),
            background: (25, 25, 30),
            camera: CameraPlace::default(),
            screenshots: "screenshots".into(),
            base_scale: 1.0,
            base_offset: (0.0, 0.0, 0.0),
            models: vec![
                shape("sphere", Shape::Sphere),
                shape("plane", Shape::Plane),
                file("drape"),
                file("bunny"),
                file("hippo"),
            ],
            materials: vec![Material {
                name: "cloth".into(),
                path: "materials/cloth.fbtf".into(),
                size: None,
                gain: 1.0,
            }],
            environments: ["studio", "sky", "interior", "overcast", "evening"]
                .map(environment)
                .to_vec(),
            progressive: Progressive::default(),
            light: Light::default(),
            exposure: 9.7,
            controls: "config/controls.ron".into(),
            xr: Headset::default(),
            start: Start::default(),
        }
    }
}

impl Default for Resolution {
    fn default() -> Self {
        Self { least: 0.25, scale: 1.0, greatest: 2.0 }
    }
}

impl Default for CameraPlace {
    fn default() -> Self {
        Self { position: (1.7, 0.7, 3.7), field_of_view: 36.0 }
    }
}

impl Default for Progressive {
    fn default() -> Self {
        Self { on: true, lights: 200, per_frame: 5, shadows: true }
    }
}

impl Default for Headset {
    fn default() -> Self {
        let mode = HeadsetMode::Auto;
        Self { mode, resolution_scale: 1.0, height: 1.2, distance: 0.9, size: Some(0.6) }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self { illuminance: 3000.0, direction: (50.0, 40.0) }
    }
}

impl Default for Start {
    fn default() -> Self {
        Self {
            object: "bunny".into(),
            material: String::new(),
            light: Rig::Point,
            environment: "studio".into(),
            backdrop: true,
            floor: true,
        }
    }
}
