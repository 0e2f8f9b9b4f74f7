#!/usr/bin/python3
"""Prints the paper's Table 1 of an exported model: images go through it as they do in the service, and its logits are
enlarged to the label's resolution."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np
import torch

import datasets
import modelfile
from datasets import Split
from metrics import Confusion

DATASETS = ("town", "carla", "camvid")


def held_out(name: str, town: Path | None, data: Path | None) -> Split:
    if name == "town":
        if town is None:
            raise ValueError("--town is missing")
        return datasets.town(town, "val")
    if data is None:
        raise ValueError("--segmentation-data is missing")
    if name == "carla":
        return datasets.carla(data / "carla_town_409", "val")
    return datasets.camvid11(data / "camvid11", "val")


class Predictor:
    def __init__(self, description: Path, grey: bool = False):
        self.grey = grey
        self.description = modelfile.read(description)
        self.model = torch.jit.load(str(self.description.file))
        self.mean = np.array(self.description.mean, np.float32)
        self.std = np.array(self.description.std, np.float32)

    @torch.no_grad()
    def classes(self, image: np.ndarray) -> np.ndarray:
        """Class of each pixel of an RGB image."""
        height, width = image.shape[:2]
        if self.grey:
            image = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
        size = self.description.network_size(width, height)
        shrinks = size[0] < width
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        x = (small.astype(np.float32) / 255 - self.mean) / self.std
        logits = self.model(torch.from_numpy(x.transpose(2, 0, 1)[None]))
        logits = torch.nn.functional.interpolate(logits, size=(height, width), mode="bilinear", align_corners=False)
        return logits[0].argmax(0).to(torch.uint8).numpy()


def evaluate(predictor: Predictor, split: Split, every: int = 1) -> Confusion:
    confusion = Confusion(split.merges)
    began = time.monotonic()
    pairs = split.pairs[::every]
    for index, pair in enumerate(pairs):
        confusion.add(datasets.read_label(pair.label), predictor.classes(datasets.read_image(pair.image)))
        if index % 100 == 99:
            print(f"{index + 1} of {len(pairs)} images, {(time.monotonic() - began) / (index + 1):.2f} s each", flush=True)
    return confusion


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", type=Path, required=True, help="description, NAME.yaml, beside the exported model")
    parser.add_argument("--dataset", choices=DATASETS, required=True, help="which held out images")
    parser.add_argument("--town", type=Path, help="folder that semmap town collect wrote")
    parser.add_argument("--segmentation-data", type=Path, help="folder with carla_town_409 and camvid11")
    parser.add_argument("--json", type=Path, help="also write the figures there")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--every", type=int, default=1, help="only every N-th image")
    parser.add_argument("--grey", action="store_true", help="as a camera without colour would see it")
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    try:
        split = held_out(options.dataset, options.town, options.segmentation_data)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    confusion = evaluate(Predictor(options.model, options.grey), split, options.every)
    print(f"{split.name}, {len(split.pairs[::options.every])} images{', grey' if options.grey else ''}")
    print(confusion.table())
    if options.json:
        images = len(split.pairs[::options.every])
        options.json.write_text(json.dumps({"dataset": split.name, "images": images, "grey": options.grey, **confusion.summary()}, indent=1))


if __name__ == "__main__":
    main()
