#!/usr/bin/python3
"""Draws loss and mean IoU over steps from the logs of one or more runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

MARGIN_LEFT, MARGIN_RIGHT, MARGIN_TOP, MARGIN_BOTTOM = 70, 20, 40, 45
PANEL = (900, 330)
# Blue, green, red.
COLOURS = ((160, 90, 20), (30, 120, 220), (60, 150, 40), (140, 60, 150))
INK, GRID = (40, 40, 40), (225, 225, 225)


@dataclass
class Curve:
    name: str
    x: list[float]
    y: list[float]


def read(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines() if line.strip()]


def loss_curve(events: list[dict]) -> Curve:
    steps = [event for event in events if event["event"] == "step"]
    return Curve("training loss", [event["step"] for event in steps], [event["loss"] for event in steps])


def iou_curves(events: list[dict]) -> list[Curve]:
    evaluations = [event for event in events if event["event"] == "evaluation"]
    names = evaluations[0]["mean_iou"].keys() if evaluations else []
    return [Curve(f"mean IoU {name}", [event["step"] for event in evaluations],
                  [event["mean_iou"][name] for event in evaluations]) for name in names]


def nice_step(span: float, parts: int = 5) -> float:
    """1, 2 or 5 times a power of ten, about span / parts."""
    raw = max(span, 1e-9) / parts
    power = 10.0 ** np.floor(np.log10(raw))
    return float(power * min((1, 2, 5, 10), key=lambda factor: abs(factor * power - raw)))


def text(canvas: np.ndarray, words: str, x: int, y: int, colour: tuple[int, int, int] = INK) -> None:
    cv2.putText(canvas, words, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)


def panel(title: str, curves: list[Curve]) -> np.ndarray:
    width, height = PANEL
    canvas = np.full((height, width, 3), 255, np.uint8)
    xs = np.concatenate([np.array(curve.x, float) for curve in curves if curve.x] or [np.array([0.0, 1.0])])
    ys = np.concatenate([np.array(curve.y, float) for curve in curves if curve.y] or [np.array([0.0, 1.0])])
    x_high, y_high = max(xs.max(), 1.0), max(ys.max(), 1e-3) * 1.05
    plot_width, plot_height = width - MARGIN_LEFT - MARGIN_RIGHT, height - MARGIN_TOP - MARGIN_BOTTOM

    def place(x: float, y: float) -> tuple[int, int]:
        return round(MARGIN_LEFT + plot_width * x / x_high), round(height - MARGIN_BOTTOM - plot_height * y / y_high)

    for value in np.arange(0, y_high, nice_step(y_high)):
        cv2.line(canvas, place(0, value), place(x_high, value), GRID, 1)
        text(canvas, f"{value:.3g}", 20, place(0, value)[1] + 4)
    for value in np.arange(0, x_high * 1.001, nice_step(x_high)):
        cv2.line(canvas, place(value, 0), place(value, y_high), GRID, 1)
        text(canvas, f"{value:g}", place(value, 0)[0] - 12, height - MARGIN_BOTTOM + 18)
    text(canvas, title, MARGIN_LEFT, 22)
    text(canvas, "step", width - 60, height - 10)
    for index, curve in enumerate(curves):
        colour = COLOURS[index % len(COLOURS)]
        points = np.array([place(x, y) for x, y in zip(curve.x, curve.y)], np.int32).reshape(-1, 1, 2)
        if len(points):
            cv2.polylines(canvas, [points], False, colour, 2, cv2.LINE_AA)
        for point in points if len(points) < 40 else []:
            cv2.circle(canvas, point[0].tolist(), 3, colour, -1, cv2.LINE_AA)
        text(canvas, curve.name, MARGIN_LEFT + 190 + 220 * index, 22, colour)
    return canvas


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--log", type=Path, required=True, help="log.jsonl of a run")
    parser.add_argument("--output", type=Path, required=True, help="PNG")
    options = parser.parse_args()
    events = read(options.log)
    picture = np.concatenate([panel("loss", [loss_curve(events)]), panel("mean IoU", iou_curves(events))])
    if not cv2.imwrite(str(options.output), picture):
        raise SystemExit(f"{options.output}: cannot write")


if __name__ == "__main__":
    main()
