// Light that does not come straight from a light: Bevy's lightmaps, irradiance volumes, ambient
// light and environment maps, in Bevy's order of precedence.

#define_import_path farlight::lighting::indirect

#import bevy_pbr::{lighting::F_AB, mesh_view_bindings::lights as view_lights}
#import farlight::lighting::surface::Surface

#ifdef LIGHTMAP
#import bevy_pbr::lightmap::lightmap
#endif
#ifdef IRRADIANCE_VOLUME
#import bevy_pbr::irradiance_volume::irradiance_volume_light
#endif
#ifdef ENVIRONMENT_MAP
#import bevy_pbr::{
    environment_map::compute_radiances,
    lighting::{LayerLightingInput, perceptualRoughnessToRoughness},
}
#endif
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_pbr::{
    mesh_view_bindings::screen_space_ambient_occlusion_texture, ssao_utils::ssao_multibounce,
}
#endif

// What a white diffuse surface reflects, E / pi in cd/m2.
struct DiffuseLight {
    // Of the lightmap: nothing dims it.
    baked: vec3<f32>,
    // Of volumes and ambient light, which ambient occlusion dims.
    open: vec3<f32>,
    // Whether the environment map still counts: not where a lightmap or a volume holds it.
    environment: bool,
}

// For the first lightmap square `uv` of the mesh instance.
fn diffuse_light(
    surface: ptr<function, Surface>,
    normal: vec3<f32>,
    uv: vec2<f32>,
    instance: u32,
) -> DiffuseLight {
    var light = DiffuseLight(vec3(0.0), vec3(0.0), true);
    var ambient = true;
#ifdef LIGHTMAP
    light.baked = lightmap(uv, 1.0, instance);
    light.environment = false;
    ambient = view_lights.ambient_light_affects_lightmapped_meshes != 0u;
#else
#ifdef IRRADIANCE_VOLUME
    // A copy: naga 29 has no pointers into what a pointer points to.
    var ranges = (*surface).ranges;
    light.open = irradiance_volume_light((*surface).world_position.xyz, normal, &ranges);
    // Outside of all volumes there is nothing of them.
    light.environment = all(light.open == vec3(0.0));
#endif
#endif
    if ambient {
        // Bevy's measure for ambient light on white, about one half of what white would reflect.
        let scale = F_AB(1.0, max(dot(normal, (*surface).to_camera), 0.0001));
        light.open += view_lights.ambient_color.rgb * (scale.x + scale.y);
    }
    return light;
}

// Radiance of the environment from a direction in the world, in cd/m2, blurred as a mirror of this
// perceptual roughness would: reflection probes here, the view's map elsewhere. Black without.
fn environment_radiance(
    surface: ptr<function, Surface>,
    direction: vec3<f32>,
    perceptual_roughness: f32,
) -> vec3<f32> {
#ifdef ENVIRONMENT_MAP
    var layer: LayerLightingInput;
    layer.N = direction;
    layer.R = direction;
    layer.NdotV = 1.0;
    layer.perceptual_roughness = perceptual_roughness;
    layer.roughness = perceptualRoughnessToRoughness(perceptual_roughness);
    var ranges = (*surface).ranges;
    return compute_radiances(layer, &ranges, (*surface).world_position.xyz, true).radiance;
#else
    return vec3(0.0);
#endif
}

// How much of the open hemisphere is seen, as the depth buffer knows it.
fn ambient_occlusion(surface: ptr<function, Surface>, albedo: vec3<f32>) -> vec3<f32> {
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
    let pixel = vec2<i32>((*surface).frag_coord.xy);
    let seen = textureLoad(screen_space_ambient_occlusion_texture, pixel, 0i).r;
    return min(vec3(1.0), ssao_multibounce(seen, albedo));
#else
    return vec3(1.0);
#endif
}
