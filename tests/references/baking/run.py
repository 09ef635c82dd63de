"""`farlight bake` beside Blender's Cycles: equal processor time, the same lightmap page, Mitsuba's answer as
the truth. Run by `cargo xtask bench bake`.

    python run.py --farlight PROGRAM --data DIR --out DIR [--scene NAME ...] [--size N] [--quality Q ...]

Scenes: TwoRooms and CornellBox of DIR/reference, hotel-room of DIR/scenes with a lamp and a sun. Lights
get a range of 100 km: Cycles knows none."""

import argparse
import hashlib
import json
import resource
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from scene import Scene

HERE = Path(__file__).parent
SCENES = {"TwoRooms": "reference", "CornellBox": "reference", "hotel-room": "scenes"}
# The room's file is in millimetres and not centred, and has no lights. Directions and positions in metres.
ADDED = {
    "hotel-room": [
        ({"type": "point", "color": [1, 0.92, 0.75], "intensity": 120}, {"translation": [10.2, 1.8, -7.5]}),
        # It shines along -z, turned to (0.25, -0.6, 1).
        ({"type": "directional", "color": [1, 0.95, 0.85], "intensity": 2000}, {"direction": [0.25, -0.6, 1]}),
    ]
}
SCALE = {"hotel-room": 0.001}
# Mitsuba would need hours for the truth about these; our own path tracer agrees with it about them.
OWN = ["hotel-room"]


def prepare(name, source, target):
    """A copy of a .glb with lights that need no more than it says: added ones, and a range without effect."""
    data = source.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    gltf = json.loads(data[20 : 20 + length])
    lights = gltf.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    for light, place in ADDED.get(name, []):
        node = {"extensions": {"KHR_lights_punctual": {"light": len(lights)}}}
        if "translation" in place:
            node["translation"] = [v / SCALE.get(name, 1) for v in place["translation"]]
        if "direction" in place:
            node["rotation"] = turn(place["direction"])
        gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]))
        gltf["nodes"].append(node)
        lights.append(light)
    for light in lights:
        if light["type"] != "directional":
            light["range"] = 1e5 / SCALE.get(name, 1)
    if "KHR_lights_punctual" not in gltf.setdefault("extensionsUsed", []):
        gltf["extensionsUsed"].append("KHR_lights_punctual")
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    target.write_bytes(
        struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
    )


def turn(direction):
    """The quaternion that turns -z to a direction."""
    x, y, z = np.array(direction) / np.linalg.norm(direction)
    turned = np.array([y, -x, 0, 1 - z])
    return (turned / np.linalg.norm(turned)).tolist()


def timed(command):
    """Runs a command: seconds of processor time, seconds of the clock."""
    clock, before = time.time(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(part) for part in command], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return processor, time.time() - clock


def bench(args, name):
    folder = args.out / f"{name}-{args.size}"
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / f"{name}.glb"
    prepare(name, args.data / SCENES[name] / f"{name}.glb", scene)
    scale = ["--scale", SCALE.get(name, 1)]
    pages = []
    for quality in args.quality:
        out = folder / quality
        command = [args.farlight, "bake", scene, "--out", out, "--size", args.size, "--quality", quality]
        processor, clock = timed([*command, "--no-probes", "--force", *scale])
        manifest = out / f"{name}.baked.ron"
        print(f"farlight {quality}: {processor:.1f} s of processor time, {clock:.1f} s of the clock", flush=True)
        baked = Scene(manifest)
        pages.append(f"farlight, {quality}, {baked.rays} rays, {processor:.1f} s={baked.exr}")
        # The truth of one layout: the lines that say where receivers lie.
        layout = "".join(line for line in manifest.read_text().splitlines() if "rect:" in line)
        reference = folder / f"reference-{hashlib.sha256(layout.encode()).hexdigest()[:8]}.npz"
        if not reference.exists():
            tracer = ["--farlight", args.farlight, scene, SCALE.get(name, 1)] if name in OWN else []
            tool("reference.py", manifest, reference, "--texels", args.texels, "--paths", args.paths, *tracer)
        cycles = folder / f"cycles-{quality}.npz"
        tool("cycles_bake.py", manifest, cycles, "--seconds", processor, "--denoise")
        pages.append(f"Cycles={cycles}")
    print(f"\n{name}, {args.size} x {args.size}")
    tool("compare.py", reference, *pages)


def tool(name, *arguments):
    subprocess.run([sys.executable, HERE / name, *map(str, arguments)], check=True, stdout=None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--farlight", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--quality", nargs="+", default=["draft", "medium"])
    parser.add_argument("--texels", type=int, default=2048)
    parser.add_argument("--paths", type=int, default=32768)
    args = parser.parse_args()
    for name in args.scene:
        bench(args, name)


if __name__ == "__main__":
    main()
