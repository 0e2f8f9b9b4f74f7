from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

from tests import support

import numpy as np

import datasets
from augment import Augmentation, augment, shade
from classes import IGNORE, TOWN
from datasets import Split
from sampling import Sampler, class_weights, repeat_factors


class Data(unittest.TestCase):
    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)

    def test_carla_holds_out_the_end_and_leaves_a_gap(self) -> None:
        names = [f"{index:04d}" for index in range(130)]
        support.write_pairs(self.folder / "images", self.folder / "labels_carla23", names, (8, 6))
        train = [int(pair.image.stem) for pair in datasets.carla(self.folder, "train").pairs]
        val = [int(pair.image.stem) for pair in datasets.carla(self.folder, "val").pairs]
        self.assertEqual(val, list(range(50, 130)))
        self.assertEqual(train, list(range(0, 30)))

    def test_camvid32_drops_names_that_are_held_out(self) -> None:
        support.write_pairs(self.folder / "a/val/images", self.folder / "a/val/labels_carla23", ["x"], (8, 6))
        support.write_pairs(self.folder / "b/images", self.folder / "b/labels_carla23", ["x", "y"], (8, 6))
        val = datasets.camvid11(self.folder / "a", "val")
        self.assertEqual([pair.image.stem for pair in datasets.camvid32(self.folder / "b", val).pairs], ["y"])

    def test_cache_keeps_pixels_and_counts(self) -> None:
        support.write_town(self.folder / "town")
        split = datasets.town(self.folder / "town", "train")
        for _ in range(2):  # made, then read
            pixels = datasets.load(split, self.folder / "cache", 40, 32)
            self.assertEqual(pixels.images.shape, (6, 32, 40, 3))
            self.assertEqual(pixels.counts[0, 13] + pixels.counts[0, 7], 40 * 32)
            self.assertEqual(sorted(np.flatnonzero(pixels.present()[0])), [7, 13])

    def sampler(self, options: Augmentation, seed: int) -> Sampler:
        support.write_town(self.folder / "town")
        pixels = datasets.load(datasets.town(self.folder / "town", "train"), self.folder / "cache", 80, 60)
        return Sampler([pixels, pixels], [0.75, 0.25], options, 0.4, seed)

    def test_sampler_is_repeatable_and_restores(self) -> None:
        options = Augmentation(64, 32, base_width=80, scale=(0.8, 1.2), rotation=5, colour=1, rare=1)
        first, second = self.sampler(options, 3), self.sampler(options, 3)
        self.assertTrue(bool((first.next(2).images == second.next(2).images).all()))
        state = first.state()
        expected = first.next(2)
        second.restore(state)
        again = second.next(2)
        self.assertTrue(bool((expected.images == again.images).all() and (expected.labels == again.labels).all()))

    def test_shares_hold(self) -> None:
        sampler = self.sampler(Augmentation(32, 32), 1)
        turns = [sampler.next_set() for _ in range(40)]
        self.assertEqual(turns.count(0), 30)

    def test_rare_classes_come_more_often_and_weigh_more(self) -> None:
        present = np.zeros((100, 23), bool)
        present[:, 7] = True
        present[0, 21] = True
        factors = repeat_factors(present, 0.25)
        self.assertAlmostEqual(factors[0], 5.0)
        self.assertEqual(factors[1], 1.0)
        counts = np.zeros((1, 256), np.int64)
        counts[0, [7, 21]] = (10000, 10)
        pixels = datasets.Pixels(Split("x", [], TOWN), np.zeros(0), np.zeros(0), counts)
        weights = class_weights([pixels], [1.0], 0.35, 6.0)
        self.assertGreater(weights[21], weights[7])
        self.assertLessEqual(weights.max(), 6.0)


class Augmenting(unittest.TestCase):
    def setUp(self) -> None:
        self.label = np.full((60, 80), 13, np.uint8)
        self.label[30:, :] = 7
        self.label[:, 60:] = 1
        self.image = np.stack([self.label * 15] * 3, 2).astype(np.uint8)

    def test_image_and_label_move_together(self) -> None:
        options = Augmentation(64, 48, base_width=80, scale=(0.7, 1.4), rotation=10, perspective=1.0, noise=0.0)
        random = np.random.default_rng(5)
        for _ in range(10):
            image, label = augment(self.image, self.label, options, random)
            self.assertEqual((image.shape, label.shape), ((48, 64, 3), (48, 64)))
            seen = label != IGNORE
            agree = np.abs(image[..., 0] - label * 15.0)[seen] < 1
            self.assertGreater(agree.mean(), 0.8)  # all but the edges

    def test_whole_image_without_changes_stays(self) -> None:
        options = Augmentation(80, 60, flip=0, noise=0, perspective=0)
        image, label = augment(self.image, self.label, options, np.random.default_rng(1))
        self.assertTrue((label == self.label).all())
        self.assertLess(np.abs(image - self.image).max(), 1.0)

    def test_grey(self) -> None:
        options = Augmentation(80, 60, noise=0, grey=1.0)
        self.image[..., 0] //= 2
        image, _ = augment(self.image, self.label, options, np.random.default_rng(1))
        self.assertTrue((image[..., 0] == image[..., 2]).all())

    def test_shadow_darkens_one_side_of_a_line(self) -> None:
        plain = np.full((60, 80, 3), 200.0)
        for seed in range(5):
            dark = shade(plain, np.random.default_rng(seed))
            self.assertLessEqual(dark.max(), 200.0)
            self.assertGreaterEqual(dark.min(), 0.35 * 200 - 1e-6)
            self.assertGreater((dark > 199).mean() + (dark <= 0.85 * 200 + 1e-6).mean(), 0.5)  # both sides, and the edge between

    def test_flip(self) -> None:
        options = Augmentation(80, 60, flip=1, noise=0, perspective=0)
        _, label = augment(self.image, self.label, options, np.random.default_rng(1))
        self.assertTrue((label == self.label[:, ::-1]).all())


if __name__ == "__main__":
    unittest.main()
