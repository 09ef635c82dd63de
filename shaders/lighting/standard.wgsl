// The reflection of Bevy's StandardMaterial for one light of the loop: diffuse after Burley, GGX
// specular with spheres as lights. Clear coat, anisotropy and transmission are left out.

#define_import_path farlight::lighting::standard

#import bevy_pbr::lighting::{
    Fd_Burley, LAYER_BASE, LightingInput, compute_specular_layer_values_for_point_light,
    derive_lighting_input, specular, specular_fix_remap,
}
#import farlight::lighting::lights::{DIRECTIONAL_LIGHT, Light}

// Radiance for an irradiance of 1 on a surface that faces the light: the BRDF times the cosine.
fn standard_reflection(
    input: ptr<function, LightingInput>,
    light: ptr<function, Light>,
) -> vec3<f32> {
    let N = (*input).layers[LAYER_BASE].N;
    let V = (*input).V;
    var derived = derive_lighting_input(N, V, (*light).direction);
    var diffuse = vec3(0.0);
    if (*light).diffuse {
        diffuse = (*input).diffuse_color * Fd_Burley(input, &derived);
    }
    let roughness = (*input).layers[LAYER_BASE].roughness;
    if (*light).kind == DIRECTIONAL_LIGHT {
        return (diffuse + specular(input, &derived, roughness, 1.0)) * derived.NdotL;
    }

    // The point of the sphere that is closest to the mirror direction stands for the whole (Karis
    // 2013, pages 14 to 16), as Bevy has it.
    let distance = length((*light).offset);
    let point = compute_specular_layer_values_for_point_light(
        input, LAYER_BASE, V, (*light).offset, (*light).radius, distance,
    );
    let spread = point.w;
    var derived_specular = derive_lighting_input(N, V, point.xyz);
    let normalization = roughness / spread;
    let blended = mix(roughness, spread, specular_fix_remap(roughness));
    var highlight = specular(input, &derived_specular, blended, normalization * normalization);
    if (*light).radius > 0.0 {
        let solid_angle = (*light).radius * (*light).radius / (distance * distance);
        highlight *=
            saturate(derived_specular.NdotL / max(derived_specular.NdotL + solid_angle, 1e-4));
    }
    return diffuse * derived.NdotL + highlight * derived_specular.NdotL;
}
