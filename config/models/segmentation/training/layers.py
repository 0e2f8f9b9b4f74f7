"""Convolutions that decoder and encoders share."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

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


class DilatedDepthwiseFunction(torch.autograd.Function):
    """A dilated 3x3 convolution of each channel alone, "same" padding, with gradients in a few large operations:
    PyTorch 1.13's own backward pass takes two to four times as long on a CPU."""

    @staticmethod
    def forward(ctx, x: Tensor, weight: Tensor, stride: int, dilation: int) -> Tensor:
        ctx.save_for_backward(x, weight)
        ctx.stride, ctx.dilation = stride, dilation
        return functional.conv2d(x, weight, None, stride, dilation, dilation, x.shape[1])

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor, Tensor, None, None]:
        x, weight = ctx.saved_tensors
        stride, reach = ctx.stride, ctx.dilation
        spread = gradient
        if stride > 1:
            spread = torch.zeros_like(x, memory_format=torch.channels_last)
            spread[:, :, ::stride, ::stride] = gradient
        of_x = functional.conv2d(spread, weight.flip(2, 3), None, 1, reach, reach, x.shape[1])
        outer = gradient.permute(0, 2, 3, 1)  # channels innermost, as they lie in memory
        padded = functional.pad(x.permute(0, 2, 3, 1), (0, 0, reach, reach, reach, reach))
        rows, columns = (stride * (size - 1) + 1 for size in gradient.shape[2:])
        of_weight = torch.empty_like(weight)
        for row in range(3):
            for column in range(3):
                top, left = row * reach, column * reach
                moved = padded[:, top:top + rows:stride, left:left + columns:stride]
                of_weight[:, 0, row, column] = (outer * moved).sum((0, 1, 2))
        return of_x, of_weight, None, None


class Depthwise(nn.Conv2d):
    """3x3 of each channel alone."""

    def __init__(self, channels: int, stride: int = 1, dilation: int = 1):
        super().__init__(channels, channels, 3, stride, dilation, dilation, channels, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        if self.training and self.dilation[0] > 1:
            return DilatedDepthwiseFunction.apply(x, self.weight, self.stride[0], self.dilation[0])
        return super().forward(x)


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
            Depthwise(inputs, 1, dilation),
            ConvNormRelu(inputs, outputs),
        )


def count_parameters(module: nn.Module) -> int:
    return sum(parameter.numel() for parameter in module.parameters())


def resize_like(x: Tensor, other: Tensor) -> Tensor:
    return nn.functional.interpolate(x, size=other.shape[-2:], mode="bilinear", align_corners=False)
