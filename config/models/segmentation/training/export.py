#!/usr/bin/python3
"""Writes a checkpoint as TorchScript with the description that the service reads beside it."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import torch
from torch import Tensor, nn

import modelfile
from deeplab import DeepLabV3Plus
from sampling import MEAN, STD

# Sizes at which the exported model has to agree with the trained one: height and width.
CHECKED_SIZES = ((384, 512), (320, 416), (192, 640), (64, 96))
TOLERANCE = 1e-2


class Exported(nn.Module):
    """Fixes the layouts: any in, channels last within (faster), plain NCHW out."""

    def __init__(self, net: nn.Module):
        super().__init__()
        self.net = net

    def forward(self, x: Tensor) -> Tensor:
        return self.net(x.contiguous(memory_format=torch.channels_last)).contiguous()


def trained(checkpoint: Path) -> tuple[nn.Module, dict]:
    state = torch.load(checkpoint, map_location="cpu")
    net = DeepLabV3Plus(state["architecture"])
    net.load_state_dict(state["average"] or state["model"])
    return net.eval().to(memory_format=torch.channels_last), state


def torchscript(net: nn.Module, height: int, width: int) -> torch.jit.ScriptModule:
    """Frozen: weights are constants and normalizations are part of the convolutions before them."""
    module = Exported(net).eval()
    with torch.no_grad():
        return torch.jit.freeze(torch.jit.trace(module, torch.rand(1, 3, height, width), check_trace=False))


@torch.no_grad()
def check(exported: torch.jit.ScriptModule, net: nn.Module) -> float:
    """The largest difference of logits; raises where sizes disagree or it is more than rounding."""
    worst = 0.0
    for batch, (height, width) in enumerate(CHECKED_SIZES, 1):
        x = torch.randn(min(batch, 2), 3, height, width)
        ours, theirs = exported(x), net(x)
        if ours.shape != theirs.shape or height % ours.shape[2] or height // ours.shape[2] not in (1, 2, 4):
            raise ValueError(f"{width}x{height}: logits of {tuple(ours.shape)}, trained model {tuple(theirs.shape)}")
        worst = max(worst, float((ours - theirs).abs().max()))
    if worst > TOLERANCE:
        raise ValueError(f"exported model differs from the trained one by {worst}")
    return worst


@torch.no_grad()
def milliseconds(model: nn.Module, height: int, width: int, runs: int = 15) -> float:
    """Median CPU time of one image, so that other programs count less."""
    x = torch.rand(1, 3, height, width)
    for _ in range(3):
        model(x)
    times = []
    for _ in range(runs):
        begin = time.process_time()
        model(x)
        times.append(time.process_time() - begin)
    return 1e3 * sorted(times)[runs // 2]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True, help="the model, NAME.pt; NAME.yaml is written beside it")
    parser.add_argument("--width", type=int, default=512, help="default input size of a 4:3 image")
    parser.add_argument("--height", type=int, default=384)
    options = parser.parse_args()
    torch.set_num_threads(1)
    if options.width % modelfile.STRIDE or options.height % modelfile.STRIDE:
        parser.error(f"sides have to be multiples of {modelfile.STRIDE}")
    net, state = trained(options.checkpoint)
    exported = torchscript(net, options.height, options.width)
    exported.save(str(options.output))
    loaded = torch.jit.load(str(options.output))
    difference = check(loaded, net)
    description = modelfile.ModelFile(options.output, options.width, options.height, MEAN, STD, "carla23")
    modelfile.write(options.output.with_suffix(".yaml"), description,
                    f"DeepLabV3+, encoder {state['architecture']}, step {state['step']}; see MODEL_CARD.md.")
    print(f"{options.output}: {options.output.stat().st_size / 1e6:.1f} MB, step {state['step']}, largest difference of logits "
          f"{difference:.1e}, {milliseconds(loaded, options.height, options.width):.1f} ms of one core for "
          f"{options.width}x{options.height}")


if __name__ == "__main__":
    main()
