"""Which image comes next: a fixed share of each data set, and more often those with rare classes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from augment import Augmentation, augment
from classes import CLASS_COUNT, UNLABELED, member_table
from datasets import Pixels

MEAN = (0.485, 0.456, 0.406)
STD = (0.229, 0.224, 0.225)


def repeat_factors(present: np.ndarray, common: float) -> np.ndarray:
    """How often each image should come (Gupta et al., LVIS, 2019): the square root of how much rarer than `common` its
    rarest class is, at least 1."""
    share = present.mean(0)
    share[UNLABELED] = 0  # no one needs to learn it
    factor = np.where(share > 0, np.sqrt(common / np.maximum(share, 1e-9)), 1.0)
    return np.maximum(1.0, (present * factor).max(1))


def class_weights(sets: list[Pixels], shares: list[float], power: float, limit: float) -> np.ndarray:
    """Weights of classes in the loss: their frequency to the power, mean 1 over what is seen, at most the limit."""
    frequency = np.zeros(CLASS_COUNT)
    for pixels, share in zip(sets, shares):
        counts = pixels.counts[:, :CLASS_COUNT].sum(0).astype(float)
        frequency += share * counts / counts.sum()
    weights = np.power(np.maximum(frequency, 1e-5), -power)
    weights /= (weights * frequency).sum()
    weights[UNLABELED] = min(weights[UNLABELED], 1.0)
    return np.minimum(weights, limit)


@dataclass
class Batch:
    images: Tensor  # N x 3 x H x W, normalized
    labels: Tensor  # N x H x W
    members: Tensor  # N x CLASS_COUNT x MAX_MEMBERS
    exact: Tensor  # N: labels stand for one class each


class Sampler:
    def __init__(self, sets: list[Pixels], shares: list[float], options: Augmentation, common: float, seed: int):
        self.sets = sets
        self.shares = np.array(shares) / sum(shares)
        self.options = options
        self.random = np.random.default_rng(seed)
        weights = [repeat_factors(pixels.present(), common) if common > 0 else np.ones(len(pixels.labels))
                   for pixels in sets]
        self.weights = [values / values.sum() for values in weights]
        self.members = [torch.from_numpy(member_table(pixels.split.merges)) for pixels in sets]
        self.debt = np.zeros(len(sets))

    def next_set(self) -> int:
        """Sets take turns so that shares hold over every few images, not only on average."""
        self.debt += self.shares
        chosen = int(self.debt.argmax())
        self.debt[chosen] -= 1
        return chosen

    def next(self, count: int) -> Batch:
        images = np.empty((count, 3, self.options.height, self.options.width), np.float32)
        labels = np.empty((count, self.options.height, self.options.width), np.int64)
        members, exact = [], []
        for slot in range(count):
            chosen = self.next_set()
            pixels = self.sets[chosen]
            index = int(self.random.choice(len(self.weights[chosen]), p=self.weights[chosen]))
            image, label = augment(pixels.images[index], pixels.labels[index], self.options, self.random)
            images[slot] = ((image / 255 - MEAN) / STD).transpose(2, 0, 1)
            labels[slot] = label
            members.append(self.members[chosen])
            exact.append(not pixels.split.merges)
        return Batch(torch.from_numpy(images), torch.from_numpy(labels), torch.stack(members), torch.tensor(exact))

    def state(self) -> dict:
        return {"random": self.random.bit_generator.state, "debt": self.debt.tolist()}

    def restore(self, state: dict) -> None:
        self.random.bit_generator.state = state["random"]
        self.debt = np.array(state["debt"])
