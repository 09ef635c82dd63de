// One loop over the lights that reach a point of a surface. The reflection and the visibility are
// the caller's:
//
//     var lights = lights_begin(&surface);
//     var light: Light;
//     while lights_next(&lights, &surface, &light) {
//         radiance += light.irradiance * visibility(&surface, &light) * my_reflection(light.direction);
//     }
//
// Point and spot lights come from the clusters of Bevy, directional ones follow.

#define_import_path farlight::lighting::lights

#import bevy_pbr::{
    clustered_forward::get_clusterable_object_id,
    mesh_view_bindings::{clustered_lights, lights as view_lights},
    mesh_view_types::{
        DIRECTIONAL_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT,
        POINT_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT,
        POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE,
    },
}
#import farlight::lighting::surface::Surface

#ifdef ATMOSPHERE
#import bevy_pbr::{
    atmosphere::functions::{calculate_visible_sun_ratio, clamp_to_surface},
    lighting::sample_transmittance_lut,
    mesh_view_bindings::atmosphere,
}
#endif

const POINT_LIGHT: u32 = 0u;
const SPOT_LIGHT: u32 = 1u;
const DIRECTIONAL_LIGHT: u32 = 2u;

struct Light {
    // POINT_LIGHT, SPOT_LIGHT or DIRECTIONAL_LIGHT, ...
    kind: u32,
    // ... and its place among the view's clustered or directional lights.
    id: u32,
    // Unit vector from the surface to the light.
    direction: vec3<f32>,
    // From the surface to the centre of the light in metres; for directional lights the direction.
    offset: vec3<f32>,
    // Radius of the sphere that shines, in metres; directional lights have none.
    radius: f32,
    // On a surface that faces the light, before anything stands in between: lux a channel.
    irradiance: vec3<f32>,
    // False where the lightmap of this mesh holds the light's diffuse reflection already.
    diffuse: bool,
}

// How far a loop is.
struct Lights {
    next: u32,
    first_spot: u32,
    // One past the last clustered light.
    clustered_end: u32,
    end: u32,
}

fn lights_begin(surface: ptr<function, Surface>) -> Lights {
    let clustered_end = (*surface).ranges.first_reflection_probe_index_offset;
    return Lights(
        (*surface).ranges.first_point_light_index_offset,
        (*surface).ranges.first_spot_light_index_offset,
        clustered_end,
        clustered_end + view_lights.n_directional_lights,
    );
}

// The next light, or false.
fn lights_next(
    lights: ptr<function, Lights>,
    surface: ptr<function, Surface>,
    light: ptr<function, Light>,
) -> bool {
    let at = (*lights).next;
    if at >= (*lights).end {
        return false;
    }
    (*lights).next = at + 1u;
    if at < (*lights).clustered_end {
        clustered_light(get_clusterable_object_id(at), at >= (*lights).first_spot, surface, light);
    } else {
        directional_light(at - (*lights).clustered_end, surface, light);
    }
    return true;
}

// Intensity over squared distance; a window brings it to 0 at the light's range (Karis, "Real
// Shading in Unreal Engine 4", 2013).
fn clustered_light(
    id: u32,
    is_spot: bool,
    surface: ptr<function, Surface>,
    light: ptr<function, Light>,
) {
    let data = &clustered_lights.data[id];
    let offset = (*data).position_radius.xyz - (*surface).world_position.xyz;
    let distance_squared = dot(offset, offset);
    let range = distance_squared * (*data).color_inverse_square_range.w;
    let window = saturate(1.0 - range * range);

    (*light).id = id;
    (*light).kind = POINT_LIGHT;
    (*light).offset = offset;
    (*light).direction = normalize(offset);
    (*light).radius = (*data).position_radius.w;
    (*light).irradiance = (*data).color_inverse_square_range.rgb
        * (window * window / max(distance_squared, 0.0001));
    (*light).diffuse = true;
#ifdef LIGHTMAP
    (*light).diffuse =
        ((*data).flags & POINT_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT) != 0u;
#endif
    if is_spot {
        (*light).kind = SPOT_LIGHT;
        (*light).irradiance *= spot_cone((*data).light_custom_data, (*data).flags, (*light).direction);
    }
}

// `cone` holds the x and z of the spot's axis, and scale and offset of the cosine.
fn spot_cone(cone: vec4<f32>, flags: u32, direction: vec3<f32>) -> f32 {
    var axis = vec3(cone.x, 0.0, cone.y);
    axis.y = sqrt(max(0.0, 1.0 - axis.x * axis.x - axis.z * axis.z));
    if (flags & POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE) != 0u {
        axis.y = -axis.y;
    }
    let edge = saturate(dot(-axis, direction) * cone.z + cone.w);
    return edge * edge;
}

fn directional_light(id: u32, surface: ptr<function, Surface>, light: ptr<function, Light>) {
    let data = &view_lights.directional_lights[id];
    (*light).id = id;
    (*light).kind = DIRECTIONAL_LIGHT;
    (*light).direction = (*data).direction_to_light;
    (*light).offset = (*data).direction_to_light;
    (*light).radius = 0.0;
    (*light).irradiance = (*data).color.rgb;
    (*light).diffuse = true;
#ifdef LIGHTMAP
    (*light).diffuse =
        ((*data).flags & DIRECTIONAL_LIGHT_FLAGS_AFFECTS_LIGHTMAPPED_MESH_DIFFUSE_BIT) != 0u;
#endif
#ifdef ATMOSPHERE
    let position = (atmosphere.world_to_atmosphere * vec4((*surface).world_position.xyz, 1.0)).xyz;
    let above_ground = clamp_to_surface(atmosphere, position);
    let radius = length(above_ground);
    let cosine = dot((*light).direction, normalize(above_ground));
    (*light).irradiance *= sample_transmittance_lut(radius, cosine)
        * calculate_visible_sun_ratio(atmosphere, radius, cosine, (*data).sun_disk_angular_size);
#endif
}
