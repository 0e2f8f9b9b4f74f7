"""Puts the training modules on the path, and makes small data sets."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import cv2
import numpy as np


def write_pairs(images: Path, labels: Path, names: list[str], size: tuple[int, int] = (80, 60), seed: int = 1) -> None:
    """Images of which the upper half is one class and the lower another, in colours that tell them."""
    random = np.random.default_rng(seed)
    images.mkdir(parents=True, exist_ok=True)
    labels.mkdir(parents=True, exist_ok=True)
    width, height = size
    for name in names:
        label = np.full((height, width), 13, np.uint8)
        label[height // 2:] = 7
        image = np.where((label == 13)[..., None], (230, 180, 120), (70, 70, 70)) + random.normal(0, 5, (height, width, 3))
        cv2.imwrite(str(images / f"{name}.png"), np.clip(image, 0, 255).astype(np.uint8))
        cv2.imwrite(str(labels / f"{name}.png"), label)


def write_town(folder: Path, train: int = 6, val: int = 2) -> None:
    names = [f"{index:06d}" for index in range(train + val)]
    write_pairs(folder / "images", folder / "masks", names)
    (folder / "train.txt").write_text("\n".join(names[:train]) + "\n")
    (folder / "val.txt").write_text("\n".join(names[train:]) + "\n")
