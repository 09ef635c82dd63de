// A measured material in Bevy's main pass.
//
// A value contains the cosine of the light already: radiance is the irradiance of a surface that
// faces the light, over pi, times the value in linear light.

#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    mesh_bindings::mesh,
    mesh_view_bindings::view,
    pbr_functions::main_pass_post_lighting_processing,
    pbr_types::{
        STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE, STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT,
        pbr_input_new,
    },
}
#import bevy_render::maths::PI
#import farlight::lighting::{
    frame::{Frame, from_frame, tangent_frame, to_frame},
    indirect::{DiffuseLight, ambient_occlusion, diffuse_light, environment_radiance},
    lights::{Light, lights_begin, lights_next},
    shadow_maps::visibility,
    surface::{Surface, surface_of_fragment},
}

#if AVAILABLE_STORAGE_BUFFER_BINDINGS >= 8
#import farlight::btf::{
    angles::{slice_of_direction, unit_azimuth},
    bindings::{Entry, btf_entries},
    taps::{Footprint, Taps, find_taps, reflectance},
}
#else
#import farlight::btf::bindings::btf_mean
#endif

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither
#endif

// Interpolated normals may turn away from the viewer where the surface does not: the view is then
// taken for this grazing one (88.3 degrees).
const LEAST_COSINE_OF_VIEW: f32 = 0.03;
const GOLDEN_ANGLE: f32 = 2.3999632;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    var surface = surface_of_fragment(in, is_front);
    let frame = tangent_frame(in, normalize(surface.world_normal));
    let radiance = reflected(in, &surface, frame);

    // Fog, tone mapping and dither are Bevy's.
    var pbr = pbr_input_new();
    pbr.material.flags =
        STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE | STANDARD_MATERIAL_FLAGS_FOG_ENABLED_BIT;
    pbr.frag_coord = in.position;
    pbr.world_position = in.world_position;
    pbr.world_normal = surface.world_normal;
    pbr.is_orthographic = surface.is_orthographic;
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr, vec4(view.exposure * radiance, 1.0));
    return out;
}

#if AVAILABLE_STORAGE_BUFFER_BINDINGS >= 8

fn reflected(in: VertexOutput, surface: ptr<function, Surface>, frame: Frame) -> vec3<f32> {
    let slot = mesh[in.instance_index].material_and_lightmap_bind_group_slot & 0xffffu;
    var entry = btf_entries[slot];
    var footprint: Footprint;
    footprint.pixel = in.position.xy;
#ifdef VERTEX_UVS_A
    footprint.uv = in.uv * entry.repeat;
    footprint.along_x = dpdx(in.uv) * entry.repeat;
    footprint.along_y = dpdy(in.uv) * entry.repeat;
#endif
    var to_camera = to_frame(frame, (*surface).to_camera);
    to_camera.z = max(to_camera.z, LEAST_COSINE_OF_VIEW);
    var taps = find_taps(&entry, footprint, to_camera);
    let view_azimuth = unit_azimuth(to_camera);

    let around = surroundings_of(in, surface, frame, &entry);
    // A mirror of this roughness sees about the solid angle of one direction, 2 pi / count.
    let blur = sqrt(sqrt(1.0 / f32(max(around.count, 1u))));
    var direct = vec3(0.0);
    var albedo = vec3(0.0);
    var environment = vec3(0.0);

    // Lights first, then directions all round: one loop, so that the longest part of the program is
    // in it once, left at its end, since drivers that compute on the processor go through the body
    // once more after a condition at its beginning fails.
    var lights = lights_begin(surface);
    var light: Light;
    var is_light = lights_next(&lights, surface, &light);
    var k = 0u;
    loop {
        var direction = vec3(0.0, 0.0, 1.0);
        var share = vec3(0.0);
        if is_light {
            direction = to_frame(frame, light.direction);
            if direction.z > 0.0 && light.diffuse {
                share = light.irradiance * (visibility(surface, &light) / PI);
            }
        } else if k < around.count {
            direction = direction_all_round(k, around.count);
            share = vec3(2.0 / f32(around.count));
        }
        if any(share > vec3(0.0)) {
            let value =
                share * min(1.0, entry.fade * direction.z)
                * reflectance(entry.btf, &taps, slice_of_direction(direction, view_azimuth));
            if is_light {
                direct += value;
            } else {
                albedo += value;
                if around.environment {
                    environment +=
                        value * environment_radiance(surface, from_frame(frame, direction), blur);
                }
            }
        }
        if is_light {
            is_light = lights_next(&lights, surface, &light);
        } else {
            k++;
        }
        if !is_light && k >= around.count {
            break;
        }
    }
    let occlusion = ambient_occlusion(surface, albedo);
    return entry.gain * (direct + albedo * (around.light.baked + around.light.open * occlusion)
        + environment * occlusion);
}

// Light from all round, and at how many directions it is met.
struct Surroundings {
    light: DiffuseLight,
    count: u32,
    environment: bool,
}

fn surroundings_of(
    in: VertexOutput,
    surface: ptr<function, Surface>,
    frame: Frame,
    entry: ptr<function, Entry>,
) -> Surroundings {
    var around: Surroundings;
#ifdef VERTEX_UVS_B
    around.light = diffuse_light(surface, frame.normal, in.uv_b, in.instance_index);
#else
    around.light = diffuse_light(surface, frame.normal, vec2(0.0), in.instance_index);
#endif
    if any(around.light.baked + around.light.open > vec3(0.0)) {
        around.count = (*entry).albedo_directions;
    }
#ifdef ENVIRONMENT_MAP
    around.environment = around.light.environment;
    if around.environment {
        around.count = (*entry).environment_directions;
    }
#endif
    return around;
}

// Directions of equal solid angle, the same for each fragment. Heights are the middles of equal
// steps, which makes sums exact for diffuse surfaces.
fn direction_all_round(k: u32, count: u32) -> vec3<f32> {
    let height = (f32(k) + 0.5) / f32(count);
    let turn = GOLDEN_ANGLE * f32(k);
    return vec3(sqrt(1.0 - height * height) * vec2(cos(turn), sin(turn)), height);
}

#else

// The mean colour as a diffuse surface.
fn reflected(in: VertexOutput, surface: ptr<function, Surface>, frame: Frame) -> vec3<f32> {
    var direct = vec3(0.0);
    var lights = lights_begin(surface);
    var light: Light;
    while lights_next(&lights, surface, &light) {
        let cosine = dot(frame.normal, light.direction);
        if cosine > 0.0 && light.diffuse {
            direct += light.irradiance * (cosine * visibility(surface, &light));
        }
    }
#ifdef VERTEX_UVS_B
    let around = diffuse_light(surface, frame.normal, in.uv_b, in.instance_index);
#else
    let around = diffuse_light(surface, frame.normal, vec2(0.0), in.instance_index);
#endif
    var surroundings = around.open;
    if around.environment {
        surroundings += environment_radiance(surface, frame.normal, 1.0);
    }
    let occlusion = ambient_occlusion(surface, btf_mean.rgb);
    return btf_mean.rgb * (direct / PI + around.baked + surroundings * occlusion);
}

#endif
