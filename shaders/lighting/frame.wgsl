// The tangent frame of a fragment: from the mesh where it has tangents, else from its UVs.

#define_import_path farlight::lighting::frame

#import bevy_pbr::forward_io::VertexOutput

// Unit vectors, orthogonal. The tangent points where u grows, the bitangent to where v falls:
// upwards in a picture whose row 0 is on top.
struct Frame {
    tangent: vec3<f32>,
    bitangent: vec3<f32>,
    normal: vec3<f32>,
}

// `normal` is the unit normal of the side that is seen. Takes derivatives: call it where all
// fragments go.
fn tangent_frame(in: VertexOutput, normal: vec3<f32>) -> Frame {
#ifdef VERTEX_TANGENTS
    // Tangents of meshes are those of MikkTSpace as glTF has them: w times the cross product points
    // up the picture. Found with the normal of the front, so that it holds for both sides.
    let upwards = in.world_tangent.w * cross(in.world_normal, in.world_tangent.xyz);
    return frame_of(normal, in.world_tangent.xyz, upwards);
#else
#ifdef VERTEX_UVS_A
    let x = dpdx(in.world_position.xyz);
    let y = dpdy(in.world_position.xyz);
    let uv_x = dpdx(in.uv);
    let uv_y = dpdy(in.uv);
    // Inverse of the derivatives of the UVs, but for the size of the determinant.
    let side = select(-1.0, 1.0, uv_x.x * uv_y.y - uv_x.y * uv_y.x >= 0.0);
    return frame_of(
        normal,
        side * (x * uv_y.y - y * uv_x.y),
        side * (x * uv_y.x - y * uv_x.x),
    );
#else
    return frame_of(normal, vec3(0.0), vec3(0.0));
#endif
#endif
}

// Made orthogonal; `upwards` only tells on which side the bitangent is.
fn frame_of(normal: vec3<f32>, along: vec3<f32>, upwards: vec3<f32>) -> Frame {
    var tangent = along - normal * dot(normal, along);
    let squared = dot(tangent, tangent);
    if squared > 1e-30 {
        tangent *= inverseSqrt(squared);
    } else {
        // No direction is better than another: any one will do.
        let axis = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
        tangent = normalize(cross(axis, normal));
    }
    let across = cross(normal, tangent);
    return Frame(tangent, select(-across, across, dot(across, upwards) >= 0.0), normal);
}

fn to_frame(frame: Frame, direction: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(direction, frame.tangent),
        dot(direction, frame.bitangent),
        dot(direction, frame.normal),
    );
}

fn from_frame(frame: Frame, direction: vec3<f32>) -> vec3<f32> {
    return direction.x * frame.tangent + direction.y * frame.bitangent + direction.z * frame.normal;
}
