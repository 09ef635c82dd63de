"""What `farlight bake --out` wrote, as arrays: triangles in the world with their places on the lightmap
page, diffuse colours, lights.

Only numpy is needed. The scene is read from the folder's .glb without a glTF library, so that all
bakers get the same triangles."""

import json
import re
import struct
from pathlib import Path

import numpy as np

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Scene:
    """All triangles that reflect light.

    position, normal  (n, 3, 3) world, metres; normals of vertices
    uv                (n, 3, 2) first UV set, v down
    texel             (n, 3, 2) place on the page in texels, rows from the top; NaN without a lightmap
    material          (n) index into `materials`: (linear RGB factor, bytes of a picture or None)
    lights            of the scenario: dicts kind, position, direction, intensity, inner, outer
    rays, exr         of the scenario: gather rays a texel, the page as OpenEXR
    """

    def __init__(self, manifest, scenario=0):
        manifest = Path(manifest)
        text = manifest.read_text()
        self.page_size = int(re.search(r"^ *page_size: (\d+)", text, re.M)[1])
        if int(re.search(r"^ *pages: (\d+)", text, re.M)[1]) != 1:
            raise SystemExit(f"{manifest}: more than one page; bake with --size instead of --resolution")
        receivers = {}
        for line in re.finditer(
            r"\(node: (\d+), primitive: (\d+), .*page: 0, rect: \((\d+), (\d+), (\d+), (\d+)\)", text
        ):
            node, primitive, *rect = map(int, line.groups())
            receivers[node, primitive] = np.array(rect, np.float64)
        block = re.split(r"^    scenarios: \[", text, flags=re.M)[1]
        block = re.split(r"^        \(\n", block, flags=re.M)[1:][scenario]
        self.lights = [light(m[0]) for m in re.finditer(r"^ *\(node: .*direct: .*", block, re.M)]
        self.sky = numbers(re.search(r"sky: (\(.*?\))", block)[1])
        self.rays = int(re.search(r"^ *samples: (\d+)", block, re.M)[1])
        exr = re.search(r'exr: "(.+?)"', block)
        self.exr = manifest.parent / exr[1] if exr else None
        self.read(manifest.parent / re.search(r'scene: "(.+?)"', text)[1], receivers)

    def read(self, path, receivers):
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        gltf = json.loads(data[20 : 20 + length])
        blob = data[28 + length :]

        def view(index):
            v = gltf["bufferViews"][index]
            start = v.get("byteOffset", 0)
            return blob[start : start + v["byteLength"]], v.get("byteStride")

        def accessor(index):
            a = gltf["accessors"][index]
            raw, stride = view(a["bufferView"])
            kind, width = np.dtype(COMPONENTS[a["componentType"]]), WIDTHS[a["type"]]
            rows = np.ndarray(
                (a["count"], width), kind, raw, a.get("byteOffset", 0), (stride or kind.itemsize * width, kind.itemsize)
            )
            return rows.astype(np.int64 if kind.kind == "u" else np.float64)

        self.materials = []
        for m in gltf.get("materials", []):
            pbr = m.get("pbrMetallicRoughness", {})
            image = None
            if "baseColorTexture" in pbr:
                source = gltf["textures"][pbr["baseColorTexture"]["index"]]["source"]
                image = view(gltf["images"][source]["bufferView"])[0]
            self.materials.append((np.array(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3]), image))
        white = len(self.materials)
        self.materials.append((np.ones(3), None))

        parts = {"position": [], "normal": [], "uv": [], "texel": [], "material": []}

        def visit(index, parent):
            node = gltf["nodes"][index]
            world = parent @ local(node)
            if "mesh" in node:
                for at, primitive in enumerate(gltf["meshes"][node["mesh"]]["primitives"]):
                    if primitive.get("mode", 4) == 4:
                        add(world, primitive, receivers.get((index, at)))
            for child in node.get("children", []):
                visit(child, world)

        def add(world, primitive, rect):
            attributes = primitive["attributes"]
            position = accessor(attributes["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            order = accessor(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(position))
            corners = order[: len(order) // 3 * 3].reshape(-1, 3)
            parts["position"].append(position[corners])
            if "NORMAL" in attributes:
                normal = accessor(attributes["NORMAL"]) @ np.linalg.inv(world[:3, :3])
            else:
                normal = np.zeros_like(position)
            parts["normal"].append(normal[corners])
            uv = accessor(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else np.zeros((len(position), 2))
            parts["uv"].append(uv[corners])
            if rect is None:
                texel = np.full((len(position), 2), np.nan)
            else:
                texel = accessor(attributes["TEXCOORD_1"]) * rect[2:] + rect[:2]
            parts["texel"].append(texel[corners])
            parts["material"].append(np.full(len(corners), primitive.get("material", white)))

        for root in gltf["scenes"][gltf.get("scene", 0)]["nodes"]:
            visit(root, np.eye(4))
        for name, arrays in parts.items():
            setattr(self, name, np.concatenate(arrays))

        p = self.position
        face = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        area = np.linalg.norm(face, axis=1, keepdims=True)
        solid = area[:, 0] > 0
        face = face / np.where(area > 0, area, 1)
        length = np.linalg.norm(self.normal, axis=2, keepdims=True)
        self.normal = np.where(length > 1e-6, self.normal / np.where(length > 0, length, 1), face[:, None])
        self.face = face
        for name in [*parts, "face"]:
            setattr(self, name, getattr(self, name)[solid])

    def samples(self, side=4):
        """Points of the texels that surfaces cover wholly: (texel indices row by row, positions
        (m, side², 3), normals). A sub-texel that two triangles share belongs to the later one."""
        size = self.page_size * side
        owner = np.full((size, size), -1, np.int32)
        bary = np.zeros((size, size, 2), np.float32)
        for index in np.flatnonzero(np.isfinite(self.texel[:, 0, 0])):
            a, b, c = self.texel[index] * side
            low = np.floor(np.min([a, b, c], 0)).astype(int).clip(0, size)
            high = np.ceil(np.max([a, b, c], 0)).astype(int).clip(0, size)
            u, v = b - a, c - a
            det = u[0] * v[1] - u[1] * v[0]
            if det == 0 or (high <= low).any():
                continue
            x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5 - a[0], np.arange(low[1], high[1]) + 0.5 - a[1])
            s, t = (x * v[1] - y * v[0]) / det, (y * u[0] - x * u[1]) / det
            inside = (s >= 0) & (t >= 0) & (s + t <= 1)
            rows, columns = np.nonzero(inside)
            owner[low[1] + rows, low[0] + columns] = index
            bary[low[1] + rows, low[0] + columns] = np.stack([s[inside], t[inside]], 1)
        blocks = lambda a: a.reshape(self.page_size, side, self.page_size, side, *a.shape[2:]).swapaxes(1, 2)
        owner = blocks(owner).reshape(-1, side * side)
        bary = blocks(bary).reshape(-1, side * side, 2)
        full = np.flatnonzero((owner >= 0).all(1))
        owner, bary = owner[full], bary[full].astype(np.float64)
        weights = np.stack([1 - bary.sum(2), bary[..., 0], bary[..., 1]], 2)[..., None]
        position = (self.position[owner] * weights).sum(2)
        normal = (self.normal[owner] * weights).sum(2)
        normal /= np.linalg.norm(normal, axis=2, keepdims=True)
        return full, position, normal


def local(node):
    """The matrix of a node."""
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def numbers(text):
    return np.array([float(n) for n in text.strip("()").split(",")])


def light(line):
    """A line of the manifest as a dict."""
    field = lambda name: numbers(re.search(name + r": (\(.*?\))", line)[1])
    single = lambda name: float(re.search(name + r": ([-\d.e]+)", line)[1])
    kind = re.search(r"kind: (\w+)", line)[1]
    result = {"kind": kind, "radius": single("radius"), "range": single("range")}
    result |= {name: field(name) for name in ["position", "direction", "intensity"]}
    if kind == "Spot":
        result |= {"inner": single("inner"), "outer": single("outer")}
    return result
