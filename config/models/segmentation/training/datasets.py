"""Where images and labels are, which are held out, and one file of pixels for each set so that loading costs nothing."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

import classes
from classes import CLASS_COUNT, Merges

# CARLA's frames are one drive: the last block is held out, and a gap keeps its neighbours out of training.
CARLA_HELD_OUT = 80
CARLA_GAP = 20
# An image counts as having a class from this share of its pixels on.
PRESENT_SHARE = 1e-4


@dataclass(frozen=True)
class Pair:
    image: Path
    label: Path


@dataclass(frozen=True)
class Split:
    """Pairs of one origin whose labels mean the same."""

    name: str
    pairs: list[Pair]
    merges: Merges = field(default_factory=dict)


def paired(images: Path, labels: Path) -> list[Pair]:
    """Images with the label of the same name, in order of names."""
    by_name = {path.stem: path for path in labels.iterdir()}
    found = [Pair(path, by_name[path.stem]) for path in sorted(images.iterdir()) if path.stem in by_name]
    if not found:
        raise ValueError(f"no image of {images} has a label in {labels}")
    return found


def town(folder: Path, part: str) -> Split:
    """`part` is train or val: the lists that `semmap town collect` wrote."""
    names = [Path(line).stem for line in (folder / f"{part}.txt").read_text().split() if line]
    pairs = [Pair(folder / "images" / f"{name}.png", folder / "masks" / f"{name}.png") for name in names]
    return Split(f"town_{part}", pairs, classes.TOWN)


def carla(folder: Path, part: str) -> Split:
    pairs = paired(folder / "images", folder / "labels_carla23")
    first_held_out = len(pairs) - CARLA_HELD_OUT
    chosen = pairs[first_held_out:] if part == "val" else pairs[: first_held_out - CARLA_GAP]
    return Split(f"carla_{part}", chosen, classes.CARLA)


def camvid11(folder: Path, part: str) -> Split:
    pairs = paired(folder / part / "images", folder / part / "labels_carla23")
    return Split(f"camvid11_{part}", pairs, classes.CAMVID11)


def camvid32(folder: Path, held_out: Split) -> Split:
    """All images but those that another set holds out under the same name."""
    names = {pair.image.stem for pair in held_out.pairs}
    pairs = [pair for pair in paired(folder / "images", folder / "labels_carla23") if pair.image.stem not in names]
    return Split("camvid32_train", pairs, classes.CAMVID32)


def read_label(path: Path) -> np.ndarray:
    label = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if label is None:
        raise ValueError(f"{path}: not an image")
    # CARLA keeps ids in the red channel.
    return label if label.ndim == 2 else label[..., 2]


def read_image(path: Path) -> np.ndarray:
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError(f"{path}: not an image")
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


@dataclass(frozen=True)
class Pixels:
    """A split, resized once. Images N x H x W x 3 and labels N x H x W are views of files."""

    split: Split
    images: np.ndarray
    labels: np.ndarray
    counts: np.ndarray  # N x 256: pixels of each label

    def present(self) -> np.ndarray:
        """N x CLASS_COUNT: which image has which class."""
        area = self.labels.shape[1] * self.labels.shape[2]
        return self.counts[:, :CLASS_COUNT] >= max(1, PRESENT_SHARE * area)


def load(split: Split, cache: Path, width: int, height: int) -> Pixels:
    """Reads the cache of a split, or makes it: anew when its files or the size change."""
    listing = [[str(pair.image), pair.image.stat().st_mtime, pair.label.stat().st_mtime] for pair in split.pairs]
    key = hashlib.sha256(json.dumps([listing, width, height]).encode()).hexdigest()[:16]
    cache.mkdir(parents=True, exist_ok=True)
    base = cache / f"{split.name}_{width}x{height}_{key}"
    count = len(split.pairs)
    shapes = {"images": (count, height, width, 3), "labels": (count, height, width)}
    paths = {kind: base.with_name(f"{base.name}_{kind}.npy") for kind in ("images", "labels", "counts")}
    if not paths["counts"].exists():  # written last
        arrays = {kind: np.lib.format.open_memmap(paths[kind], "w+", np.uint8, shapes[kind]) for kind in shapes}
        counts = np.zeros((count, 256), np.int64)
        for index, pair in enumerate(split.pairs):
            image, label = read_image(pair.image), read_label(pair.label)
            arrays["images"][index] = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
            arrays["labels"][index] = cv2.resize(label, (width, height), interpolation=cv2.INTER_NEAREST)
            counts[index] = np.bincount(arrays["labels"][index].ravel(), minlength=256)
        for array in arrays.values():
            array.flush()
        np.save(paths["counts"], counts)
    return Pixels(split, np.load(paths["images"], mmap_mode="r"), np.load(paths["labels"], mmap_mode="r"),
                  np.load(paths["counts"]))
