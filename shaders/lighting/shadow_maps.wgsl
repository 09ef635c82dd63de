// How much of a light reaches a surface, from Bevy's shadow maps and contact shadows.

#define_import_path farlight::lighting::shadow_maps

#import bevy_pbr::{
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    mesh_view_bindings::{clustered_lights, lights as view_lights},
    mesh_view_types::{
        DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT, POINT_LIGHT_FLAGS_SHADOWS_ENABLED_BIT,
    },
    shadows::{fetch_directional_shadow, fetch_point_shadow, fetch_spot_shadow},
}
#import farlight::lighting::{
    lights::{DIRECTIONAL_LIGHT, Light, POINT_LIGHT},
    surface::Surface,
}

#ifdef CONTACT_SHADOWS
#ifdef DEPTH_PREPASS
#import bevy_pbr::{
    mesh_view_bindings::contact_shadows_settings,
    mesh_view_types::{
        DIRECTIONAL_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT,
        POINT_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT,
    },
    pbr_functions::calculate_contact_shadow,
}
#endif
#endif

// 0 in full shadow, 1 in full light.
fn visibility(surface: ptr<function, Surface>, light: ptr<function, Light>) -> f32 {
    if ((*surface).mesh_flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) == 0u {
        return 1.0;
    }
    return shadow_map(surface, light) * contact_shadow(surface, light);
}

fn shadow_map(surface: ptr<function, Surface>, light: ptr<function, Light>) -> f32 {
    let id = (*light).id;
    let position = (*surface).world_position;
    let normal = (*surface).world_normal;
    let pixel = (*surface).frag_coord.xy;
    if (*light).kind == DIRECTIONAL_LIGHT {
        let flags = view_lights.directional_lights[id].flags;
        if (flags & DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) == 0u {
            return 1.0;
        }
        return fetch_directional_shadow(id, position, normal, (*surface).view_z, pixel);
    }
    if (clustered_lights.data[id].flags & POINT_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) == 0u {
        return 1.0;
    }
    if (*light).kind == POINT_LIGHT {
        return fetch_point_shadow(id, position, normal, pixel);
    }
    let near = clustered_lights.data[id].shadow_map_near_z;
    return fetch_spot_shadow(id, position, normal, near, pixel);
}

fn contact_shadow(surface: ptr<function, Surface>, light: ptr<function, Light>) -> f32 {
#ifdef CONTACT_SHADOWS
#ifdef DEPTH_PREPASS
    let steps = contact_shadows_settings.linear_steps;
    var enabled = steps > 0u;
    if (*light).kind == DIRECTIONAL_LIGHT {
        let flags = view_lights.directional_lights[(*light).id].flags;
        enabled &= (flags & DIRECTIONAL_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT) != 0u;
    } else {
        let flags = clustered_lights.data[(*light).id].flags;
        enabled &= (flags & POINT_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT) != 0u;
    }
    if enabled {
        return calculate_contact_shadow(
            (*surface).world_position.xyz,
            (*surface).frag_coord.xy,
            (*light).direction,
            steps,
        );
    }
#endif
#endif
    return 1.0;
}
