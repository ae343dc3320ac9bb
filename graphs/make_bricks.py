"""Makes the view of a brick wall that a photo of its front does not show, for the preset `brick_wall`.

    python3 graphs/make_bricks.py

`front_128.png` is the photo (rows y, columns x) and serves as the cut normal to y too (rows z, columns x): bricks as deep as
they are high. The cut normal to x (rows z, columns y) shows their ends: the photo squeezed along the bricks until they are
square, and turned so that courses lie on each other along y. Needs Pillow.
"""

from pathlib import Path

from PIL import Image

FOLDER = Path(__file__).parent / "assets" / "bricks"
LENGTH, HEIGHT = 29.0, 14.2  # mean distance of bricks along and across the courses, in pixels

for name, filter in (("front_128", Image.LANCZOS), ("front_mask_128", Image.BOX)):
    image = Image.open(FOLDER / f"{name}.png")
    squeezed = image.resize((round(image.width * HEIGHT / LENGTH), image.height), filter)
    if name.startswith("front_mask"):
        squeezed = squeezed.point(lambda v: 255 if v > 127 else 0)
    squeezed.transpose(Image.TRANSPOSE).save(FOLDER / f"{name.replace('front', 'end')}.png")
