from __future__ import annotations

import unittest

from tests import support  # noqa: F401

import numpy as np

from classes import CAMVID11, ID, IGNORE
from metrics import Confusion


class Metrics(unittest.TestCase):
    def test_by_hand(self) -> None:
        confusion = Confusion()
        label = np.array([[7, 7, 7, 13], [13, 13, IGNORE, 0]], np.uint8)
        prediction = np.array([[7, 7, 13, 13], [13, 13, 4, 4]], np.uint8)
        confusion.add(label, prediction)
        self.assertAlmostEqual(confusion.iou()[7], 2 / 3)
        self.assertAlmostEqual(confusion.iou()[13], 3 / 4)
        self.assertAlmostEqual(confusion.accuracy()[7], 2 / 3)
        self.assertAlmostEqual(confusion.mean_iou(), (2 / 3 + 3 / 4) / 2)
        self.assertAlmostEqual(confusion.pixel_accuracy(), 5 / 6)
        rows = confusion.rows()
        self.assertEqual((rows[0]["iou"], rows[4]["iou"]), ("SKIP", "MISSING"))
        self.assertIn("MISSING", confusion.table())

    def test_merged_classes_count_as_one(self) -> None:
        confusion = Confusion(CAMVID11)
        confusion.add(np.full((2, 2), ID["Road"], np.uint8), np.full((2, 2), ID["RoadLine"], np.uint8))
        self.assertEqual(confusion.mean_iou(), 1.0)


if __name__ == "__main__":
    unittest.main()
