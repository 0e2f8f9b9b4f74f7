"""Convolutions that decoder and encoders share."""

from __future__ import annotations

from torch import Tensor, nn

# Below this many inputs PyTorch's own kernel wins.
MIN_CHANNELS_FOR_ONEDNN = 8


def prefer_onednn(module: nn.Module) -> nn.Module:
    """Gives 1x1 convolutions a dilation, which changes nothing that they compute.

    PyTorch 1.13 sends undilated 1x1 convolutions of one image on one thread to a kernel of its own that, without a
    tuned BLAS, is many times slower than oneDNN's; a dilation makes it choose oneDNN. Measured here: 92 to 38 ms for
    the light encoder.
    """
    for part in module.modules():
        if isinstance(part, nn.Conv2d) and part.kernel_size == (1, 1) and part.in_channels >= MIN_CHANNELS_FOR_ONEDNN:
            part.dilation = (2, 2)
    return module


class ConvNormRelu(nn.Sequential):
    def __init__(self, inputs: int, outputs: int, kernel: int = 1, dilation: int = 1, groups: int = 1):
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, 1, dilation * (kernel // 2), dilation, groups, bias=False),
            nn.BatchNorm2d(outputs),
            nn.ReLU(inplace=True),
        )


class SeparableConv(nn.Sequential):
    """3x3 of each channel alone, then 1x1 across channels (the paper on DeepLabV3+ calls it atrous separable)."""

    def __init__(self, inputs: int, outputs: int, dilation: int = 1):
        super().__init__(
            nn.Conv2d(inputs, inputs, 3, 1, dilation, dilation, inputs, bias=False),
            ConvNormRelu(inputs, outputs),
        )


def count_parameters(module: nn.Module) -> int:
    return sum(parameter.numel() for parameter in module.parameters())


def resize_like(x: Tensor, other: Tensor) -> Tensor:
    return nn.functional.interpolate(x, size=other.shape[-2:], mode="bilinear", align_corners=False)
