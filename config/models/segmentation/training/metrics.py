"""Confusion of classes, and the paper's Table 1 from it."""

from __future__ import annotations

import numpy as np

from classes import CLASS_COUNT, IGNORE, NAMES, UNLABELED, Merges, merge_table


class Confusion:
    """Counts pixels by true and predicted class; predictions count as what the data set calls them."""

    def __init__(self, merges: Merges | None = None):
        self.merge = merge_table(merges or {})
        self.counts = np.zeros((CLASS_COUNT, CLASS_COUNT), np.int64)

    def add(self, label: np.ndarray, prediction: np.ndarray) -> None:
        """Unlabeled and IGNORE pixels of the label are left out."""
        valid = (label != IGNORE) & (label != UNLABELED)
        index = label[valid].astype(np.int64) * CLASS_COUNT + self.merge[prediction[valid]]
        self.counts += np.bincount(index, minlength=CLASS_COUNT * CLASS_COUNT).reshape(CLASS_COUNT, CLASS_COUNT)

    def present(self) -> np.ndarray:
        return self.counts.sum(1) > 0

    def iou(self) -> np.ndarray:
        """NaN for classes that the label does not have."""
        hit = np.diag(self.counts)
        union = self.counts.sum(0) + self.counts.sum(1) - hit
        return np.where(self.present(), hit / np.maximum(union, 1), np.nan)

    def accuracy(self) -> np.ndarray:
        return np.where(self.present(), np.diag(self.counts) / np.maximum(self.counts.sum(1), 1), np.nan)

    def mean_iou(self) -> float:
        """Over the classes present."""
        return float(np.nanmean(self.iou())) if self.present().any() else 0.0

    def pixel_accuracy(self) -> float:
        return float(np.diag(self.counts).sum() / max(self.counts.sum(), 1))

    def rows(self) -> list[dict]:
        iou, accuracy, present = self.iou(), self.accuracy(), self.present()
        rows = []
        for index, name in enumerate(NAMES):
            note = "SKIP" if index == UNLABELED else None if present[index] else "MISSING"
            rows.append({"id": index, "class": name, "iou": note or float(iou[index]), "accuracy": note or float(accuracy[index])})
        return rows

    def summary(self) -> dict:
        return {"mean_iou": self.mean_iou(), "pixel_accuracy": self.pixel_accuracy(),
                "classes_present": int(self.present().sum()), "pixels": int(self.counts.sum()), "classes": self.rows()}

    def table(self) -> str:
        def cell(value: float | str) -> str:
            return value if isinstance(value, str) else f"{100 * value:.2f}%"

        lines = [f"{'ID':>2}  {'Class label':<13} {'IoU':>8} {'Accuracy':>9}"]
        lines += [f"{row['id']:>2}  {row['class']:<13} {cell(row['iou']):>8} {cell(row['accuracy']):>9}" for row in self.rows()]
        lines.append(f"mean IoU over {self.present().sum()} classes present {self.mean_iou():.4f}, "
                     f"pixel accuracy {self.pixel_accuracy():.4f}")
        return "\n".join(lines)
