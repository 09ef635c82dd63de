"""How far lightmap pages are from the truth.

    python compare.py REFERENCE.npz NAME=PAGE [NAME=PAGE ...] [--part total | indirect]

PAGE is an .npz of cycles_bake.py, another reference's .npz, or an OpenEXR page of `farlight bake`. Errors are those of
luminance, over it, of texels that have at least a thousandth of the brightest one's light and no part
inside of something."""

import argparse
from pathlib import Path

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def page(path, index):
    """Pages of a file by name: luminance of the texels."""
    if path.suffix == ".npz":
        file = np.load(path)
        for name in ["page", "denoised"]:
            if name in file:
                label = f", {int(file['samples'])} samples" + (", denoised" if name == "denoised" else "")
                yield label, file[name].reshape(-1, 3)[index] @ LUMINANCE
    else:
        import mitsuba

        mitsuba.set_variant("scalar_rgb")
        yield "", np.array(mitsuba.Bitmap(str(path))).astype(np.float64)[..., :3].reshape(-1, 3)[index] @ LUMINANCE


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference")
    parser.add_argument("pages", nargs="+")
    parser.add_argument("--part", choices=["total", "indirect"], default="total")
    args = parser.parse_args()
    reference = np.load(args.reference)
    truth = reference["indirect"] @ LUMINANCE
    noise = reference["error"] @ LUMINANCE
    if args.part == "total":
        truth = truth + reference["direct"] @ LUMINANCE
    lit = reference["lit"] & (truth > 1e-3 * truth.max())
    noise = noise[lit] / truth[lit]
    print(f"{lit.sum()} texels; the reference's own error: median {100 * np.median(noise):.2f} %")
    print("| baker | median error | mean error | 95th percentile | bias (median) |\n|---|---|---|---|---|")
    for entry in args.pages:
        name, path = entry.split("=", 1)
        for label, found in page(Path(path), reference["index"]):
            signed = found[lit] / truth[lit] - 1
            error = np.abs(signed)
            cells = [np.median(error), error.mean(), np.percentile(error, 95), np.median(signed)]
            print(f"| {name}{label} | " + " | ".join(f"{100 * cell:.2f} %" for cell in cells) + " |")


if __name__ == "__main__":
    main()
