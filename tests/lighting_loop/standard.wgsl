// StandardMaterial on Farlight's own light loop, without indirect light.

#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    lighting::{F_AB, LAYER_BASE, LightingInput, perceptualRoughnessToRoughness},
    mesh_view_bindings::view,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{
        calculate_F0_dielectric, calculate_diffuse_color, main_pass_post_lighting_processing,
    },
}
#import farlight::lighting::{
    lights::{Light, lights_begin, lights_next},
    shadow_maps::visibility,
    standard::standard_reflection,
    surface::surface_of_fragment,
}

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    let pbr = pbr_input_from_standard_material(in, is_front);
    let material = pbr.material;
    var input: LightingInput;
    input.layers[LAYER_BASE].N = pbr.N;
    input.layers[LAYER_BASE].NdotV = max(dot(pbr.N, pbr.V), 0.0001);
    input.layers[LAYER_BASE].R = reflect(-pbr.V, pbr.N);
    input.layers[LAYER_BASE].perceptual_roughness = material.perceptual_roughness;
    input.layers[LAYER_BASE].roughness =
        perceptualRoughnessToRoughness(material.perceptual_roughness);
    input.P = pbr.world_position.xyz;
    input.V = pbr.V;
    input.diffuse_color =
        calculate_diffuse_color(material.base_color.rgb, material.metallic, 0.0, 0.0);
    input.metallic = material.metallic;
    input.F0_dielectric = calculate_F0_dielectric(material.reflectance);
    input.F0_metallic = material.base_color.rgb;
    input.F_ab = F_AB(material.perceptual_roughness, input.layers[LAYER_BASE].NdotV);

    var surface = surface_of_fragment(in, is_front);
    var radiance = vec3(0.0);
    var lights = lights_begin(&surface);
    var light: Light;
    while lights_next(&lights, &surface, &light) {
        radiance += light.irradiance * visibility(&surface, &light)
            * standard_reflection(&input, &light);
    }
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr, vec4(view.exposure * radiance, 1.0));
    return out;
}
