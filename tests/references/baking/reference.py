"""Irradiance of lightmap texels by Mitsuba's path tracer: the truth that bakers are compared with.

    python reference.py NAME.baked.ron OUT.npz [--texels N] [--paths N] [--farlight PROGRAM SCENE.glb SCALE]

or, with --farlight, by that of `farlight bake --receivers`, which is quicker; agree.py compares the two.

Means over the areas of random texels that a surface covers wholly: E / π, `direct` and `indirect`, with
the standard error of the latter; `lit` is false where a part of a texel lies inside of something. No limit on reflections; surfaces are two-sided, Lambertian and flat."""

import argparse
import glob
import math
import os
import re
import tempfile
import time

import numpy as np

import points
from scene import Scene

# Mitsuba's vector back end compiles with LLVM 17 or newer; Debian's libraries have it in their names.
libraries = {
    int(version[1]): path
    for path in glob.glob("/usr/lib/*/libLLVM*.so*")
    if (version := re.search(r"libLLVM[-.](?:so\.)?(\d+)", path)) and int(version[1]) >= 17
}
if libraries:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", libraries[max(libraries)])

import drjit as dr
import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

LANES = 1 << 20


def by_mitsuba(scene, position, normal, paths):
    world = mitsuba_scene(scene)
    flat = [a.reshape(-1, 3) for a in (position, normal)]
    straight = direct(world, scene, *flat).reshape(position.shape).mean(1)
    return straight, *indirect(world, position, normal, paths)


def bsdf(factor, picture):
    reflectance = {"type": "rgb", "value": factor.tolist()}
    if picture is not None:
        with tempfile.NamedTemporaryFile(suffix=".png" if picture[:4] == b"\x89PNG" else ".jpg") as file:
            file.write(picture)
            file.flush()
            bitmap = mi.Bitmap(file.name)
        bitmap = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
        texels = np.array(bitmap) * factor.astype(np.float32)
        reflectance = {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True}
    return mi.load_dict({"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}})


def mitsuba_scene(scene):
    parts = {"type": "scene"}
    for index, (factor, picture) in enumerate(scene.materials):
        of = np.flatnonzero(scene.material == index)
        if len(of) == 0:
            continue
        properties = mi.Properties()
        properties["bsdf"] = bsdf(factor, picture)
        properties["face_normals"] = True
        mesh = mi.Mesh(f"m{index}", 3 * len(of), len(of), has_vertex_texcoords=True, props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = mi.Float(scene.position[of].ravel().astype(np.float32))
        parameters["vertex_texcoords"] = mi.Float(scene.uv[of].ravel().astype(np.float32))
        parameters["faces"] = mi.UInt32(np.arange(3 * len(of), dtype=np.uint32))
        parameters.update()
        parts[f"m{index}"] = mesh
    for index, light in enumerate(scene.lights):
        value = {"type": "rgb", "value": light["intensity"].tolist()}
        if light["kind"] == "Point":
            emitter = {"type": "point", "position": light["position"].tolist(), "intensity": value}
        elif light["kind"] == "Directional":
            emitter = {"type": "directional", "direction": light["direction"].tolist(), "irradiance": value}
        else:
            raise SystemExit("spot lights fall off differently everywhere; leave them out")
        parts[f"light{index}"] = emitter
    if scene.sky.any():
        parts["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": scene.sky.tolist()}}
    return mi.load_dict(parts)


def direct(world, scene, position, normal):
    """E / π straight from the lights at points (n, 3)."""
    total = np.zeros_like(position)
    start = position + 1e-4 * normal
    for light in scene.lights:
        if light["kind"] == "Point":
            toward = light["position"] - position
            distance = np.linalg.norm(toward, axis=1, keepdims=True)
            toward, fall = toward / distance, 1 / distance**2
            reach = distance[:, 0] * (1 - 1e-4)
        else:
            toward, fall = np.broadcast_to(-light["direction"], position.shape), 1
            reach = np.full(len(position), 1e6)
        ray = mi.Ray3f(mi.Point3f(*start.T.astype(np.float32)), mi.Vector3f(*toward.T.astype(np.float32)))
        ray.maxt = mi.Float(reach.astype(np.float32))
        seen = ~np.array(world.ray_test(ray))
        cosine = np.maximum((toward * normal).sum(1), 0) * seen
        total += cosine[:, None] * fall * light["intensity"] / math.pi
    return total


def indirect(world, position, normal, paths):
    """E / π from everywhere else at texels (n, k, 3): mean, its standard error, whether every point got
    any."""
    count, points = position.shape[:2]
    integrator = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 8})
    lanes = count * points
    each = max(1, LANES // lanes)
    passes = max(8, math.ceil(paths / (points * each)))
    # One lane a point and repetition, points of a texel next to each other.
    tile = lambda a: np.repeat(a.reshape(lanes, 3), each, axis=0).T.astype(np.float32)
    p, n = mi.Point3f(*tile(position)), mi.Vector3f(*tile(normal))
    frame, origin = mi.Frame3f(n), p + n * 1e-4
    dr.eval(frame, origin)
    sums, squares = np.zeros((2, count, 3))
    lit = np.zeros((count, points), bool)
    for seed in range(passes):
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, lanes * each)
        local = mi.warp.square_to_cosine_hemisphere(sampler.next_2d())
        ray = mi.RayDifferential3f(mi.Ray3f(origin, frame.to_world(local)))
        light, _, _ = integrator.sample(world, sampler, ray)
        by_point = np.array(light).reshape(3, count, points, each).mean(3)
        lit |= by_point.any(0)
        mean = by_point.mean(2).T
        sums += mean
        squares += mean**2
    mean = sums / passes
    variance = np.maximum(squares / passes - mean**2, 0) / (passes - 1)
    return mean, np.sqrt(variance), lit.all(1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manifest")
    parser.add_argument("out")
    parser.add_argument("--texels", type=int, default=4096)
    parser.add_argument("--paths", type=int, default=16384)
    parser.add_argument("--farlight", nargs=3)
    args = parser.parse_args()
    started = time.time()
    scene = Scene(args.manifest)
    index, position, normal = scene.samples()
    chosen = np.sort(np.random.default_rng(1).permutation(len(index))[: args.texels])
    index, position, normal = index[chosen], position[chosen], normal[chosen]
    if args.farlight:
        program, file, scale = args.farlight
        options = ["--scale", scale]
        straight, rest, error, lit = points.texels(program, file, position, normal, args.paths, options)
    else:
        straight, rest, error, lit = by_mitsuba(scene, position, normal, args.paths)
    np.savez(
        args.out,
        index=index,
        direct=straight,
        indirect=rest,
        error=error,
        lit=lit,
        position=position,
        normal=normal,
    )
    bright = rest.mean(1) > 1e-3 * rest.mean(1).max()
    relative = np.median(error.mean(1)[bright] / rest.mean(1)[bright])
    print(
        f"reference: {len(index)} of {scene.page_size}² texels, {args.paths} paths each, standard error"
        f" {100 * relative:.2f} % (median), {time.time() - started:.0f} s"
    )


if __name__ == "__main__":
    main()
