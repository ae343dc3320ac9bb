"""Makes the maps that go with the cobbles: height, normal and roughness (128 px).

    python3 graphs/make_maps.py

The photograph has no such maps of its own. Height is a dome over every stone, from the distance to the border of
the mask, with a little of the luminance as relief; the normal is its gradient (OpenGL convention, green up);
roughness is high in the gaps and lower where the stones are bright. Needs numpy and Pillow.
"""

from pathlib import Path

import numpy as np
from PIL import Image

FOLDER = Path(__file__).parent / "assets" / "cobbles"
DOME = 6.0  # pixels from the border of a stone to its plateau
DEPTH = 4.0  # pixels from the gaps to the plateaus


def distance_inside(mask):
    """For every pixel of the mask, the distance to the nearest pixel outside."""
    inside, outside = np.argwhere(mask), np.argwhere(~mask)
    distance = np.zeros(mask.shape, np.float32)
    for chunk in np.array_split(inside, 64):
        gaps = chunk[:, None, :] - outside[None, :, :]
        distance[tuple(chunk.T)] = np.sqrt((gaps**2).sum(-1).min(1))
    return distance


def blur(field, rounds):
    for _ in range(rounds):
        for axis in (0, 1):
            field = (np.roll(field, 1, axis) + 2 * field + np.roll(field, -1, axis)) / 4
    return field


def save(name, field):
    levels = (np.clip(field, 0, 1) * 255 + 0.5).astype(np.uint8)
    Image.fromarray(levels).save(FOLDER / f"{name}_128.png", optimize=True)


def main():
    color = np.asarray(Image.open(FOLDER / "color_128.png").convert("RGB"), np.float32) / 255
    mask = np.asarray(Image.open(FOLDER / "mask_128.png").convert("L")) > 127
    luminance = color @ np.array([0.2126, 0.7152, 0.0722], np.float32)
    detail = luminance - blur(luminance, 8)

    dome = np.sqrt(np.clip(distance_inside(mask) / DOME, 0, 1))
    height = blur(0.15 + 0.7 * dome, 1) + 0.35 * detail * mask
    save("height", height)

    down, right = np.gradient(height * DEPTH)
    normal = np.stack([-right, down, np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    save("normal", normal * 0.5 + 0.5)

    spread = (luminance - luminance.mean()) / luminance.std()
    save("roughness", np.where(mask, 0.62 - 0.1 * spread, 0.92))


if __name__ == "__main__":
    main()
