// Directions, and where they fall among the samples: the twin of plugins/btf/codec/src/angles.rs.
//
// Frame of the surface: x along the columns of the picture (azimuth 0), z along the normal.

#define_import_path farlight::btf::angles

#import farlight::math::{HALF_PI, TAU, arc_sine, arc_tangent, finite, sine_cosine}

// In radians: theta from the normal, phi round it; i is the light, v the view.
struct Angles {
    theta_i: f32,
    phi_i: f32,
    theta_v: f32,
    phi_v: f32,
}

// The light round the axis that lies in the surface across the view.
struct SliceAngles {
    // Angle of the light out of the plane of normal and view, -pi/2 to pi/2.
    beta: f32,
    sin_beta: f32,
    // Tilt of the light's arc, -pi/2 (the side of the view) to pi/2 (the mirror side).
    alpha: f32,
}

// Two neighbouring samples of an axis; weight is that of the upper one, 0 to 1.
struct Cell {
    low: u32,
    high: u32,
    weight: f32,
}

// Below this cosine of beta, BTF_GUARD_BETA_POLE takes alpha for 0.
const BETA_POLE: f32 = 0.001;

// Whether both directions are above the surface, or in it.
fn above(angles: Angles) -> bool {
    return angles.theta_i <= HALF_PI && angles.theta_v <= HALF_PI;
}

// Of two unit vectors away from the surface. Where many lights meet one view, take `elevation` and
// `azimuth` of the view and `slice_of_direction` of each light.
fn angles_of_directions(light: vec3<f32>, view: vec3<f32>) -> Angles {
    return Angles(elevation(light), azimuth(light), elevation(view), azimuth(view));
}

// Theta of a direction.
fn elevation(direction: vec3<f32>) -> f32 {
    return arc_tangent(length(direction.xy), direction.z);
}

// Phi of a direction.
fn azimuth(direction: vec3<f32>) -> f32 {
    return arc_tangent(direction.y, direction.x);
}

// Cosine and sine of phi of a direction; phi is 0 along the normal.
fn unit_azimuth(direction: vec3<f32>) -> vec2<f32> {
    let across = length(direction.xy);
    return select(direction.xy / max(across, 1e-30), vec2(1.0, 0.0), across < 1e-30);
}

// Of a light with the elevation `theta_i`, `difference` (phi of the light less phi of the view)
// round the normal from the view.
fn slice_of_angles(theta_i: f32, difference: f32) -> SliceAngles {
    let theta = sine_cosine(finite(theta_i));
    let phi = sine_cosine(finite(difference));
    return slice_of_vector(-phi.x * theta.x, -phi.y * theta.x, theta.y);
}

// Of a light's unit vector in the frame of the surface and the `unit_azimuth` of the view.
fn slice_of_direction(light: vec3<f32>, view_azimuth: vec2<f32>) -> SliceAngles {
    let across = light.x * view_azimuth.y - light.y * view_azimuth.x;
    let mirror = -dot(light.xy, view_azimuth);
    return slice_of_vector(finite(across), finite(mirror), finite(light.z));
}

// Of a light's unit vector on the axes "across the view", "away from the view" and normal.
fn slice_of_vector(across: f32, mirror: f32, up: f32) -> SliceAngles {
    let above = max(up, 0.0);
    let cos_beta = sqrt(mirror * mirror + above * above);
    var alpha = arc_tangent(mirror, above);
#ifdef BTF_GUARD_BETA_POLE
    alpha = select(alpha, 0.0, cos_beta < BETA_POLE);
#endif
    return SliceAngles(arc_tangent(across, cos_beta), across, alpha);
}

// Among `count` samples from `first` to `last`, both included.
fn cell_between(value: f32, first: f32, last: f32, count: u32) -> Cell {
    let at = (value - first) * (f32(count - 1u) / (last - first));
    let low = min(u32(max(at, 0.0)), count - 2u);
    return Cell(low, low + 1u, saturate(at - f32(low)));
}

// Among `count` samples round a circle from 0 on.
fn cell_on_circle(angle: f32, count: u32) -> Cell {
    let turns = angle * (1.0 / TAU);
    let at = (turns - floor(turns)) * f32(count);
    let low = min(u32(at), count - 1u);
    let high = select(low + 1u, 0u, low + 1u == count);
    return Cell(low, high, saturate(at - f32(low)));
}

// Among `count` samples at equal steps of the sine; the weight is linear in the angle.
fn cell_in_sine(angles: SliceAngles, count: u32) -> Cell {
    let half = f32(count - 1u) * 0.5;
    let at = (angles.sin_beta + 1.0) * half;
    let low = min(u32(max(at, 0.0)), count - 2u);
    let start = arc_sine(f32(low) / half - 1.0);
    let end = arc_sine(f32(low + 1u) / half - 1.0);
    return Cell(low, low + 1u, saturate((angles.beta - start) / (end - start)));
}
