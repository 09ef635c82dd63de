"""The path tracer of `farlight bake --receivers`, asked about texels."""

import json
import math
import subprocess
import tempfile
from pathlib import Path

import numpy as np


def texels(farlight, scene, position, normal, paths, options=()):
    """E / π at texels of points (n, k, 3) with `paths` paths a texel: direct, indirect, the standard
    error of the latter, whether every point got any."""
    count, points = position.shape[:2]
    pairs = zip(position.reshape(-1, 3), normal.reshape(-1, 3))
    surface = [{"position": p.tolist(), "normal": n.tolist()} for p, n in pairs]
    with tempfile.TemporaryDirectory() as folder:
        job, result = Path(folder) / "job.json", Path(folder) / "result.json"
        job.write_text(json.dumps({"surface": surface}))
        command = [farlight, "bake", scene, "--receivers", job, "--result", result]
        command += ["--samples", max(32, paths // points), *options]
        subprocess.run([str(part) for part in command], check=True)
        found = json.loads(result.read_text())["surface"]
    part = lambda name: np.array([f[name] for f in found]).reshape(count, points, 3) / math.pi
    error = np.sqrt((part("indirect_se") ** 2).sum(1)) / points
    lit = part("indirect").any(2).all(1)
    return part("direct").mean(1), part("indirect").mean(1), error, lit
