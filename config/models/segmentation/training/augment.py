"""Random changes of an image and its label, the same for both where they move pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from classes import CLASS_COUNT, IGNORE


@dataclass(frozen=True)
class Augmentation:
    """Sizes are of what the network sees. `base_width` is the width to which a whole image is scaled first (0: as it
    is); scale, rotation and the four corners vary around that."""

    width: int
    height: int
    base_width: int = 0
    scale: tuple[float, float] = (1.0, 1.0)
    rotation: float = 0.0  # degrees
    flip: float = 0.5
    noise: float = 0.2
    noise_sigma: float = 10.0  # of 255
    perspective: float = 0.5
    perspective_shift: float = 0.1  # of the crop's sides
    colour: float = 0.0
    shadow: float = 0.0  # of a part of the image, with a straight edge
    grey: float = 0.0  # vehicles may have cameras without colour
    rare: float = 0.0  # probability that the crop is laid over a pixel of a class drawn at random from the image's


def crop_centre(label: np.ndarray, wanted: tuple[float, float], options: Augmentation,
                random: np.random.Generator) -> tuple[float, float]:
    """Middle of a crop of the wanted size inside the image, over a random class of it where asked for."""
    height, width = label.shape
    margins = [min(size, side) / 2 for size, side in zip(wanted, (width, height))]
    if random.random() < options.rare:
        small = label[::2, ::2]
        present = np.flatnonzero(np.bincount(small.ravel(), minlength=256)[:CLASS_COUNT])
        if present.size:
            pixels = np.flatnonzero(small == random.choice(present))
            row, column = divmod(int(random.choice(pixels)), small.shape[1])
            around = [2 * column + random.uniform(-0.35, 0.35) * wanted[0], 2 * row + random.uniform(-0.35, 0.35) * wanted[1]]
            return tuple(float(np.clip(value, margin, side - margin))
                         for value, margin, side in zip(around, margins, (width, height)))
    return tuple(random.uniform(margin, side - margin) for margin, side in zip(margins, (width, height)))


def transform(label: np.ndarray, options: Augmentation, random: np.random.Generator) -> np.ndarray:
    """Homography from the image's pixels to the crop's."""
    scale = np.exp(random.uniform(*np.log(options.scale)))
    if options.base_width:
        scale *= options.base_width / label.shape[1]
    size = (options.width / scale, options.height / scale)
    centre = crop_centre(label, size, options, random)
    half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    angle = np.radians(random.uniform(-options.rotation, options.rotation))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    source = (half * size) @ turn.T + centre
    if random.random() < options.perspective:
        source += random.uniform(-options.perspective_shift, options.perspective_shift, (4, 2)) * size
    target = (half + 0.5) * (options.width, options.height)
    if random.random() < options.flip:
        target[:, 0] = options.width - target[:, 0]
    # Half a pixel: corners are between pixels, coordinates at their middles.
    return cv2.getPerspectiveTransform((source - 0.5).astype(np.float32), (target - 0.5).astype(np.float32))


def recolour(image: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Brightness, contrast, gamma, saturation and tint of a float image in 0..255."""
    grey = image.mean(2, keepdims=True)
    image = grey + (image - grey) * random.uniform(0.6, 1.4)
    image = (image - 127) * random.uniform(0.75, 1.3) + 127 + random.uniform(-25, 25)
    image = image * random.uniform(0.92, 1.08, 3)
    return 255 * np.power(np.clip(image, 0, 255) / 255, random.uniform(0.75, 1.35))


def shade(image: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Darkens one side of a straight line, as a house does that stands between sun and street."""
    height, width = image.shape[:2]
    angle = random.uniform(0, 2 * np.pi)
    row, column = random.uniform(0, height), random.uniform(0, width)
    distance = np.cos(angle) * (np.arange(width) - column) + np.sin(angle) * (np.arange(height)[:, None] - row)
    dark = np.clip(distance / random.uniform(1, 12), 0, 1) * (1 - random.uniform(0.35, 0.85))
    return image * (1 - dark[..., None])


def augment(image: np.ndarray, label: np.ndarray, options: Augmentation,
            random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """RGB float32 in 0..255 and the label, both height x width; beyond the image 0 and IGNORE."""
    size = (options.width, options.height)
    homography = transform(label, options, random)
    out = cv2.warpPerspective(image, homography, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    out_label = cv2.warpPerspective(label, homography, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT,
                                    borderValue=IGNORE)
    out = out.astype(np.float32)
    if random.random() < options.colour:
        out = recolour(out, random).astype(np.float32)
    if options.shadow and random.random() < options.shadow:
        out = shade(out, random).astype(np.float32)
    if options.grey and random.random() < options.grey:
        out = np.repeat(cv2.cvtColor(out, cv2.COLOR_RGB2GRAY)[..., None], 3, 2)
    if random.random() < options.noise:
        sigma = random.uniform(0, options.noise_sigma)
        out = out + random.standard_normal(out.shape, dtype=np.float32) * np.float32(sigma)
    return np.clip(out, 0, 255), out_label
