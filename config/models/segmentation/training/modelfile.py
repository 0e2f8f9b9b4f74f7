"""The description that lies beside an exported model: what the service has to know about it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

# The sides of what goes into a network are multiples of this.
STRIDE = 32


@dataclass(frozen=True)
class ModelFile:
    file: Path
    input_width: int
    input_height: int
    mean: tuple[float, ...]
    std: tuple[float, ...]
    classes: str

    def network_size(self, width: int, height: int) -> tuple[int, int]:
        """Width and height that the network sees of an image: the area of the default, the aspect ratio of the image."""
        area, aspect = self.input_width * self.input_height, width / height
        wide, high = (area * aspect) ** 0.5, (area / aspect) ** 0.5
        return max(1, round(wide / STRIDE)) * STRIDE, max(1, round(high / STRIDE)) * STRIDE


def write(path: Path, model: ModelFile, comment: str) -> None:
    path.write_text(
        f"# {comment}\n"
        f"file: {model.file.name}\n"
        f"# Of a 4:3 image; for others the area stays and sides are rounded to multiples of {STRIDE}.\n"
        f"input_width: {model.input_width}\n"
        f"input_height: {model.input_height}\n"
        f"# Of RGB in 0..1.\n"
        f"mean: {json.dumps(list(model.mean))}\n"
        f"std: {json.dumps(list(model.std))}\n"
        f"classes: {model.classes}\n"
    )


def read(path: Path) -> ModelFile:
    """Reads what `write` wrote; not a reader of YAML."""
    values: dict[str, str] = {}
    for line in path.read_text().splitlines():
        text = line.split("#")[0].strip()
        if text:
            key, _, value = text.partition(":")
            values[key.strip()] = value.strip()
    return ModelFile(path.parent / values["file"], int(values["input_width"]), int(values["input_height"]),
                     tuple(json.loads(values["mean"])), tuple(json.loads(values["std"])), values["classes"])
