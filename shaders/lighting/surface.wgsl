// A point of a surface, as lights need to know it: made once a fragment.

#define_import_path farlight::lighting::surface

#import bevy_pbr::{
    clustered_forward::{
        ClusterableObjectIndexRanges, unpack_clusterable_object_index_ranges,
        view_fragment_cluster_index,
    },
    forward_io::VertexOutput,
    mesh_bindings::mesh,
    mesh_view_bindings::view,
    pbr_functions::calculate_view,
}

struct Surface {
    world_position: vec4<f32>,
    // Normal of the mesh towards the viewer's side, not normalized: for the biases of shadow maps.
    world_normal: vec3<f32>,
    // Unit vector towards the camera.
    to_camera: vec3<f32>,
    // Position in the picture; w as in the fragment's built-in.
    frag_coord: vec4<f32>,
    // Depth in front of the camera, negative.
    view_z: f32,
    is_orthographic: bool,
    // MESH_FLAGS_* of the mesh.
    mesh_flags: u32,
    // What the cluster of this point holds: lights, probes, volumes.
    ranges: ClusterableObjectIndexRanges,
}

// Of a fragment. The normal is turned to the viewer on back faces that are seen.
fn surface_of_fragment(in: VertexOutput, is_front: bool) -> Surface {
    let normal = select(-in.world_normal, in.world_normal, is_front);
    return surface_at(in.world_position, normal, in.position, mesh[in.instance_index].flags);
}

fn surface_at(
    world_position: vec4<f32>,
    world_normal: vec3<f32>,
    frag_coord: vec4<f32>,
    mesh_flags: u32,
) -> Surface {
    var surface: Surface;
    surface.world_position = world_position;
    surface.world_normal = world_normal;
    surface.frag_coord = frag_coord;
    surface.mesh_flags = mesh_flags;
    surface.is_orthographic = view.clip_from_view[3].w == 1.0;
    surface.to_camera = calculate_view(world_position, surface.is_orthographic);
    let depth = vec4(
        view.view_from_world[0].z,
        view.view_from_world[1].z,
        view.view_from_world[2].z,
        view.view_from_world[3].z,
    );
    surface.view_z = dot(depth, world_position);
    let cluster =
        view_fragment_cluster_index(frag_coord.xy, surface.view_z, surface.is_orthographic);
    surface.ranges = unpack_clusterable_object_index_ranges(cluster);
    return surface;
}
