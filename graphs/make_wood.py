"""Makes the three views of a wood: three plane cuts of one procedural board, so that they agree (128 px).

    python3 graphs/make_wood.py

The trunk runs along z. `z` is the end grain (rows y, columns x), `y` has rows z and columns x, `x` has rows z and
columns y. Needs numpy and Pillow.
"""

from pathlib import Path

import numpy as np
from PIL import Image

FOLDER = Path(__file__).parent / "assets" / "wood"
SIZE = 128
PITH = (-150.0, -115.0)  # the trunk's axis, far enough away for rings to be arcs alike
RING = 13.0  # mean width of a ring in pixels
PALE, DARK, PORE = (214, 172, 116), (128, 74, 34), (96, 56, 28)


def hashed(seed, *lattice):
    """A number from 0 to 1 for every lattice point."""
    h = np.full(np.broadcast(*lattice).shape, (seed * 0x9E3779B9) & 0xFFFFFFFF, np.uint64)
    for c in lattice:
        h ^= (c.astype(np.int64) & 0xFFFFFFFF).astype(np.uint64)
        h = (h * np.uint64(0x85EBCA6B)) & np.uint64(0xFFFFFFFF)
        h ^= h >> np.uint64(13)
        h = (h * np.uint64(0xC2B2AE35)) & np.uint64(0xFFFFFFFF)
        h ^= h >> np.uint64(16)
    return h.astype(np.float64) / 0xFFFFFFFF


def noise(seed, x, y, z):
    """Smooth value noise with cells of one unit, from -1 to 1."""
    cell = [np.floor(c) for c in (x, y, z)]
    t = [c - f for c, f in zip((x, y, z), cell)]
    t = [c * c * (3 - 2 * c) for c in t]
    total = 0.0
    for i in range(8):
        bits = (i & 1, i >> 1 & 1, i >> 2)
        weight = 1.0
        for b, c in zip(bits, t):
            weight = weight * (c if b else 1 - c)
        total = total + weight * hashed(seed, *(f + b for f, b in zip(cell, bits)))
    return 2 * total - 1


def board(x, y, z):
    """The colour of every point."""
    x, y, z = np.broadcast_arrays(x, y, z)
    warp = 3.0 * noise(1, x / 40, y / 40, z / 160) + 0.8 * noise(2, x / 11, y / 11, z / 60)
    radius = np.hypot(x - PITH[0], y - PITH[1]) + warp
    rings = radius / RING + 0.2 * np.sin(radius / RING * 1.7) + 0.12 * np.sin(radius / RING * 0.73)
    phase = rings - np.floor(rings)
    # Early wood darkens slowly towards the late wood, which ends at once.
    late = np.clip((phase - 0.45) / 0.45, 0, 1) ** 1.6 * np.clip((1 - phase) / 0.06, 0, 1)
    shade = 0.11 * noise(3, x / 1.7, y / 1.7, z / 30) + 0.05 * noise(4, x / 5, y / 5, z / 120)
    # Pores are thin tubes along z, most of them in the early wood.
    pore = np.clip((noise(5, x / 1.7, y / 1.7, z / 40) - 0.45) / 0.25, 0, 1) * (0.65 - 0.5 * late)
    mix = np.clip(0.12 + 0.78 * late + shade, 0, 1)[..., None]
    color = (1 - mix) * np.array(PALE) + mix * np.array(DARK)
    pore = 0.7 * np.clip(pore, 0, 1)[..., None]
    return (1 - pore) * color + pore * np.array(PORE)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    # Four samples a pixel in each direction of the picture.
    fine = (np.arange(SIZE * 4) + 0.5) / 4
    rows, columns = fine[:, None], fine[None, :]
    middle = np.array(SIZE / 2)
    views = {
        "x": board(middle, columns, rows),
        "y": board(columns, middle, rows),
        "z": board(columns, rows, middle),
    }
    for name, view in views.items():
        view = view.reshape(SIZE, 4, SIZE, 4, 3).mean((1, 3))
        Image.fromarray((view + 0.5).astype(np.uint8)).save(FOLDER / f"view_{name}_128.png", optimize=True)


if __name__ == "__main__":
    main()
