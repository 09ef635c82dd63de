"""Whether the path tracer of `farlight bake --receivers` and Mitsuba agree about texels.

    python agree.py REFERENCE.npz SCENE.glb FARLIGHT [--texels N] [--paths N] [OPTIONS of farlight bake]

Prints the root mean square of their differences over the standard error: 1 for two unbiased estimates."""

import argparse

import numpy as np

from points import texels


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference")
    parser.add_argument("scene")
    parser.add_argument("farlight")
    parser.add_argument("--texels", type=int, default=256)
    parser.add_argument("--paths", type=int, default=16384)
    args, options = parser.parse_known_args()
    reference = np.load(args.reference)
    chosen = np.random.default_rng(2).permutation(len(reference["index"]))[: args.texels]
    of = lambda name: reference[name][chosen]
    straight, mean, error, _ = texels(args.farlight, args.scene, of("position"), of("normal"), args.paths, options)
    truth, noise = of("indirect"), of("error")
    lit = truth.mean(1) > 1e-3 * truth.mean(1).max()
    z = ((mean - truth) / np.sqrt(error**2 + noise**2))[lit]
    worst = np.abs(straight - of("direct")).max() / reference["direct"].max()
    whole = mean[lit].sum() / truth[lit].sum() - 1
    print(
        f"{lit.sum()} texels: indirect light differs by {np.sqrt((z**2).mean()):.2f} standard errors (RMS) and by"
        f" {100 * whole:+.2f} % in all; direct light by {worst:.1e} of its largest value"
    )


if __name__ == "__main__":
    main()
