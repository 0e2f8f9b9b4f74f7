"""Stereo images of two textured walls that a camera drives past, without any library for images.

The camera moves sideways by STEP_M a frame. In the upper half of the image the wall is NEAR_M away, in the lower half
FAR_M, so that what it sees moves by whole pixels.
"""

import random

WIDTH, HEIGHT = 400, 304
FOCAL_PX = 300.0
BASELINE_M = 0.5
STEP_M = 0.05
NEAR_M, FAR_M = 5.0, 7.5
NEAR_CLASS, FAR_CLASS = 1, 11  # Building, Wall
FRAMES = 120

_BLOCK = 8
_LENGTH = 1200


def _texture(seed):
    """Rows of blocks of random brightness, longer than an image is wide."""
    numbers = random.Random(seed)
    rows = []
    for _ in range(HEIGHT // _BLOCK):
        row = bytearray()
        for _ in range(_LENGTH // _BLOCK):
            row += bytes([numbers.randrange(20, 236)]) * _BLOCK
        rows += [bytes(row)] * _BLOCK
    return rows


_TEXTURE = _texture(7)


def image(frame, right=False):
    """Grey pixels, row by row, of the left or the right camera in this frame (from 0)."""
    camera_m = STEP_M * frame + (BASELINE_M if right else 0)
    pixels = bytearray()
    for y, row in enumerate(_TEXTURE):
        depth = NEAR_M if y < HEIGHT // 2 else FAR_M
        start = round(FOCAL_PX * camera_m / depth)
        pixels += row[start:start + WIDTH]
    return bytes(pixels)


def class_mask():
    """The class of each pixel; the same in every frame."""
    half = WIDTH * HEIGHT // 2
    return bytes([NEAR_CLASS]) * half + bytes([FAR_CLASS]) * half
