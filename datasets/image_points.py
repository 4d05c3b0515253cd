#!/usr/bin/python3
"""Points in the plane that draw a picture, denser where it is darker.

    datasets/image_points.py portrait|gradient OUT.xyz [--points 74000] [--seed 1]

The same numbers on every machine: only sums, products and quotients, and Python's own random numbers.
"""

import argparse
import random
import sys

# Of the portrait, from back to front: middle, half axes, share of them over which the edge fades, darkness.
ELLIPSES = [
    ((0.50, 0.02), (0.46, 0.24), 0.25, 0.75),  # shoulders
    ((0.50, 0.55), (0.30, 0.37), 0.25, 1.00),  # hair
    ((0.50, 0.26), (0.10, 0.16), 0.40, 0.30),  # neck
    ((0.51, 0.50), (0.20, 0.28), 0.20, 0.10),  # face
    ((0.38, 0.42), (0.09, 0.12), 0.90, 0.22),  # shade of the cheek
    ((0.43, 0.60), (0.07, 0.020), 0.60, 0.60),  # eyebrows
    ((0.60, 0.60), (0.07, 0.020), 0.60, 0.60),
    ((0.43, 0.55), (0.05, 0.025), 0.50, 0.95),  # eyes
    ((0.60, 0.55), (0.05, 0.025), 0.50, 0.95),
    ((0.52, 0.43), (0.035, 0.05), 0.90, 0.45),  # nose
    ((0.52, 0.34), (0.08, 0.026), 0.50, 0.80),  # mouth
]
LIGHTEST = 0.06  # where nothing is dark there are points, too


def portrait(x, y):
    """Darkness in [LIGHTEST, 1], y upwards."""
    darkness = 0.15 + 0.3 * x  # the wall
    for (cx, cy), (rx, ry), edge, value in ELLIPSES:
        # Squared: 1 on the ellipse.
        u, v = (x - cx) / rx, (y - cy) / ry
        r = u * u + v * v
        t = min(1.0, max(0.0, (1 + edge - r) / (2 * edge)))
        cover = t * t * (3 - 2 * t)
        darkness += cover * (value - darkness)
    return max(LIGHTEST, darkness)


def gradient(x, y):
    """Rises linearly from the left to the right."""
    return LIGHTEST + (1 - LIGHTEST) * x


PICTURES = {"portrait": portrait, "gradient": gradient}


def points_of(picture, count, seed):
    """Of the unit square, their density proportional to the darkness."""
    source = random.Random(seed)
    points = []
    while len(points) < count:
        x, y, threshold = source.random(), source.random(), source.random()
        if threshold < picture(x, y):
            points.append((x, y))
    return points


def write_xyz(points, path):
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"{x:.7f} {y:.7f} 0\n" for x, y in points)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", choices=PICTURES)
    parser.add_argument("out")
    parser.add_argument("--points", type=int, default=74000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    write_xyz(points_of(PICTURES[arguments.picture], arguments.points, arguments.seed), arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
