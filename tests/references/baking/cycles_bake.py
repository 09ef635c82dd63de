"""Bakes what `farlight bake --out` wrote once more, with Blender's Cycles (the PyPI package bpy).

    python cycles_bake.py NAME.baked.ron OUT.npz [--samples N | --seconds S] [--denoise] [--indirect]

Diffuse light, direct and indirect, without colour: E / π. The same triangles, second UV set, lights and
page; no limit on reflections, no clamping, no threshold under which lights are left out. With --seconds
the samples are chosen such that baking takes so many seconds of processor time on all cores together,
after two short bakes that tell what a sample costs."""

import argparse
import math
import os
import sys
import tempfile
import time

import bpy
import mathutils
import numpy as np

from scene import Scene

THREADS = 2


def processor_time():
    t = os.times()
    return t.user + t.system


def material(name, factor, picture, page):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    links.new(diffuse.outputs[0], output.inputs[0])
    diffuse.inputs[0].default_value = (*factor, 1)
    if picture is not None:
        with tempfile.NamedTemporaryFile(suffix=".png" if picture[:4] == b"\x89PNG" else ".jpg") as file:
            file.write(picture)
            file.flush()
            image = bpy.data.images.load(file.name)
            image.pack()
        texture, uv, multiply = (
            nodes.new("ShaderNodeTexImage"),
            nodes.new("ShaderNodeUVMap"),
            nodes.new("ShaderNodeVectorMath"),
        )
        texture.image, uv.uv_map, multiply.operation = image, "uv", "MULTIPLY"
        multiply.inputs[1].default_value = factor
        links.new(uv.outputs[0], texture.inputs[0])
        links.new(texture.outputs[0], multiply.inputs[0])
        links.new(multiply.outputs[0], diffuse.inputs[0])
    # The active picture of every material is what is baked into.
    target = nodes.new("ShaderNodeTexImage")
    target.image = page
    nodes.active = target
    return made


def build(scene):
    """The scene in Blender, and the picture that is baked into."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    page = bpy.data.images.new("page", scene.page_size, scene.page_size, float_buffer=True, is_data=True)
    count = len(scene.position)
    mesh = bpy.data.meshes.new("scene")
    mesh.from_pydata(scene.position.reshape(-1, 3).tolist(), [], np.arange(3 * count).reshape(-1, 3).tolist())
    texel = np.where(np.isfinite(scene.texel), scene.texel, 0) / scene.page_size
    for name, uv in [("uv", scene.uv), ("page", texel)]:
        layer = mesh.uv_layers.new(name=name)
        up = np.stack([uv[..., 0], 1 - uv[..., 1]], -1)
        layer.data.foreach_set("uv", up.ravel())
    mesh.uv_layers.active = mesh.uv_layers["page"]
    for index, (factor, picture) in enumerate(scene.materials):
        mesh.materials.append(material(f"m{index}", factor, picture, page))
    mesh.polygons.foreach_set("material_index", scene.material.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(count, bool))
    mesh.normals_split_custom_set(scene.normal.reshape(-1, 3).tolist())
    mesh.update()
    thing = bpy.data.objects.new("scene", mesh)
    collection = bpy.context.scene.collection.objects
    collection.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)

    for light in scene.lights:
        largest = light["intensity"].max()
        if light["kind"] == "Point":
            made = bpy.data.lights.new("light", "POINT")
            made.energy, made.shadow_soft_size = 4 * math.pi * largest, light["radius"]
        elif light["kind"] == "Directional":
            made = bpy.data.lights.new("light", "SUN")
            made.energy, made.angle = largest, 2 * light["radius"]
        else:
            raise SystemExit("spot lights fall off differently everywhere; leave them out")
        made.color = light["intensity"] / largest
        made.cycles.max_bounces = 1024
        placed = bpy.data.objects.new("light", made)
        placed.location = light["position"]
        placed.rotation_mode = "QUATERNION"
        placed.rotation_quaternion = mathutils.Vector(light["direction"]).to_track_quat("-Z", "Y")
        collection.link(placed)
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs[0].default_value = (*scene.sky, 1)
    bpy.context.scene.world = world

    settings = bpy.context.scene
    settings.render.engine = "CYCLES"
    settings.render.threads_mode, settings.render.threads = "FIXED", THREADS
    settings.render.use_persistent_data = False
    cycles = settings.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = 1024
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
    cycles.blur_glossy = 0
    return page


def bake(page, samples, passes):
    """Seconds of processor time, and of the clock."""
    bpy.context.scene.cycles.samples = samples
    clock, processor = time.time(), processor_time()
    bpy.ops.object.bake(
        type="DIFFUSE", pass_filter=passes, margin=8, margin_type="EXTEND", use_clear=True, uv_layer="page"
    )
    return processor_time() - processor, time.time() - clock


def denoise(page):
    """Through the compositor's node, which is Open Image Denoise. Answers the picture's pixels."""
    scene = bpy.data.scenes.new("denoise")
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.resolution_x, scene.render.resolution_y = page.size
    scene.render.resolution_percentage = 100
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    source, filter, output = (
        nodes.new("CompositorNodeImage"),
        nodes.new("CompositorNodeDenoise"),
        nodes.new("CompositorNodeComposite"),
    )
    source.image = page
    filter.use_hdr = True
    links.new(source.outputs[0], filter.inputs[0])
    links.new(filter.outputs[0], output.inputs[0])
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth = "OPEN_EXR", "32"
        scene.render.filepath = os.path.join(folder, "page.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return pixels(bpy.data.images.load(scene.render.filepath))


def pixels(image):
    """RGB, rows from the top."""
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], -1)[::-1, :, :3]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manifest")
    parser.add_argument("out")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--seconds", type=float)
    parser.add_argument("--denoise", action="store_true")
    parser.add_argument("--indirect", action="store_true")
    args = parser.parse_args()
    before = processor_time()
    page = build(Scene(args.manifest))
    setup = processor_time() - before
    passes = {"INDIRECT"} if args.indirect else {"DIRECT", "INDIRECT"}
    samples = args.samples
    if args.seconds:
        bake(page, 1, passes)
        (few, _), (more, _) = bake(page, 2, passes), bake(page, 10, passes)
        each = max((more - few) / 8, 1e-3)
        samples = max(1, round((args.seconds - few) / each) + 2)
    processor, clock = bake(page, samples, passes)
    result = {"page": pixels(page).copy()}
    filtered = 0
    if args.denoise:
        before = processor_time()
        result["denoised"] = denoise(page)
        filtered = processor_time() - before
    np.savez(args.out, samples=samples, processor=processor, clock=clock, setup=setup, filtered=filtered, **result)
    print(
        f"cycles {bpy.app.version_string}: {samples} samples in {processor:.1f} s of processor time,"
        f" {clock:.1f} s of the clock; {setup:.1f} s to set up, {filtered:.1f} s to denoise",
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()
