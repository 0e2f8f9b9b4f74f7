"""ESPNetv2 encoder, written from the paper (Mehta et al., "ESPNetv2: A Light-weight, Power Efficient, and General
Purpose Convolutional Neural Network", CVPR 2019).

The names of parameters follow the published Cityscapes weights, so that `load_published_weights` needs no table of keys.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from layers import Depthwise

# Kernel reach of the dilated branches: no branch of a unit looks further than this many pixels of its level.
REACH = {"level2_0": 13, "level3_0": 11, "level3": 9, "level4_0": 9, "level4": 7}
BRANCHES = 4
# Units after the strided one at 1/8 and at 1/16 of the input.
REPEATS = {"level3": 3, "level4": 7}
# Channels at scale s = 2.0 for 1/2, 1/4, 1/8 and 1/16 of the input.
CHANNELS = (32, 128, 256, 512)


def dilations(reach: int, branches: int = BRANCHES) -> list[int]:
    """Dilation rate of each parallel branch, ascending; branches that would exceed the reach fall back to 1."""
    kernels = sorted(size if size <= reach else 3 for size in (3 + 2 * index for index in range(branches)))
    return [(size - 1) // 2 for size in kernels]


class FixedSlope(torch.autograd.Function):
    """PReLU whose slopes are not trained: PyTorch's own backward pass costs a sixth of a training step."""

    @staticmethod
    def forward(ctx, x: Tensor, slope: Tensor) -> Tensor:
        ctx.save_for_backward(x, slope)
        return torch.prelu(x, slope)

    @staticmethod
    def backward(ctx, gradient: Tensor) -> tuple[Tensor, None]:
        x, slope = ctx.saved_tensors
        slope = slope.view(1, -1, 1, 1)
        positive = torch.ops.aten.threshold_backward(gradient, x, 0)  # seven times as fast as torch.where
        return positive.mul_(1 - slope).addcmul_(gradient, slope), None


class PReLU(nn.PReLU):
    def __init__(self, channels: int):
        super().__init__(channels)
        self.weight.requires_grad_(False)

    def forward(self, x: Tensor) -> Tensor:
        if self.training:
            return FixedSlope.apply(x, self.weight)
        return torch.prelu(x, self.weight)


class ConvNormAct(nn.Module):
    def __init__(self, inputs: int, outputs: int, kernel: int, stride: int = 1, groups: int = 1, act: bool = True):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)
        self.bn = nn.BatchNorm2d(outputs)
        self.act = PReLU(outputs) if act else nn.Identity()

    def forward(self, x: Tensor) -> Tensor:
        return self.act(self.bn(self.conv(x)))


class NormAct(nn.Module):
    def __init__(self, channels: int):
        super().__init__()
        self.bn = nn.BatchNorm2d(channels)
        self.act = PReLU(channels)

    def forward(self, x: Tensor) -> Tensor:
        return self.act(self.bn(x))


class DilatedDepthwise(nn.Module):
    def __init__(self, channels: int, stride: int, dilation: int):
        super().__init__()
        self.conv = Depthwise(channels, stride, dilation)

    def forward(self, x: Tensor) -> Tensor:
        return self.conv(x)


class Eesp(nn.Module):
    """Extremely efficient spatial pyramid: grouped reduction, depthwise branches of growing dilation that are summed
    one onto the next (against gridding), grouped expansion."""

    def __init__(self, inputs: int, outputs: int, stride: int, reach: int):
        super().__init__()
        width = outputs // BRANCHES
        self.proj_1x1 = ConvNormAct(inputs, width, 1, groups=BRANCHES)
        self.spp_dw = nn.ModuleList(DilatedDepthwise(width, stride, rate) for rate in dilations(reach))
        self.br_after_cat = NormAct(outputs)
        self.conv_1x1_exp = ConvNormAct(outputs, outputs, 1, groups=BRANCHES, act=False)
        # The strided unit leaves its activation to the unit that joins it with the pooled input.
        self.module_act = PReLU(outputs)
        self.stride = stride

    def forward(self, x: Tensor) -> Tensor:
        reduced = self.proj_1x1(x)
        branches = [self.spp_dw[0](reduced)]
        for branch in list(self.spp_dw)[1:]:
            branches.append(branches[-1] + branch(reduced))
        expanded = self.conv_1x1_exp(self.br_after_cat(torch.cat(branches, 1)))
        if self.stride > 1:
            return expanded
        return self.module_act(expanded + x)


class StridedEesp(nn.Module):
    """Halves the resolution: pooled input beside a strided unit, plus the image itself, pooled to the same size."""

    def __init__(self, inputs: int, outputs: int, reach: int):
        super().__init__()
        self.eesp = Eesp(inputs, outputs - inputs, 2, reach)
        self.inp_reinf = nn.Sequential(ConvNormAct(3, 3, 3), ConvNormAct(3, outputs, 1, act=False))
        self.act = PReLU(outputs)

    def forward(self, x: Tensor, image: Tensor) -> Tensor:
        joined = torch.cat((functional.avg_pool2d(x, 3, 2, 1), self.eesp(x)), 1)
        return self.act(joined + self.inp_reinf(image))


class EspNetV2(nn.Module):
    """Features at 1/2, 1/4, 1/8 and 1/16 of the input."""

    channels = CHANNELS

    def __init__(self) -> None:
        super().__init__()
        self.frozen: tuple[str, ...] = ()
        half, quarter, eighth, sixteenth = CHANNELS
        self.level1 = ConvNormAct(3, half, 3, 2)
        self.level2_0 = StridedEesp(half, quarter, REACH["level2_0"])
        self.level3_0 = StridedEesp(quarter, eighth, REACH["level3_0"])
        self.level3 = nn.Sequential(*(Eesp(eighth, eighth, 1, REACH["level3"]) for _ in range(REPEATS["level3"])))
        self.level4_0 = StridedEesp(eighth, sixteenth, REACH["level4_0"])
        self.level4 = nn.Sequential(*(Eesp(sixteenth, sixteenth, 1, REACH["level4"]) for _ in range(REPEATS["level4"])))

    def forward(self, x: Tensor) -> list[Tensor]:
        image2 = functional.avg_pool2d(x, 3, 2, 1)
        image4 = functional.avg_pool2d(image2, 3, 2, 1)
        image8 = functional.avg_pool2d(image4, 3, 2, 1)
        image16 = functional.avg_pool2d(image8, 3, 2, 1)
        half = self.level1(x)
        quarter = self.level2_0(half, image4)
        eighth = self.level3(self.level3_0(quarter, image8))
        sixteenth = self.level4(self.level4_0(eighth, image16))
        return [half, quarter, eighth, sixteenth]

    def freeze(self, parts: tuple[str, ...]) -> None:
        """Keeps the weights and statistics of these parts as they are."""
        self.frozen = parts
        for part in parts:
            getattr(self, part).requires_grad_(False)

    def keep_frozen(self) -> None:
        """After `train()`, which also sets the frozen parts to training."""
        for part in self.frozen:
            getattr(self, part).eval()

    def load_published_weights(self, path: str) -> None:
        """Loads the encoder's part of a published state_dict; every parameter of ours has to be there."""
        state = torch.load(path, map_location="cpu")
        prefix = "base_net."
        ours = {key[len(prefix):]: value for key, value in state.items() if key.startswith(prefix)}
        known = self.state_dict()
        missing = sorted(set(known) - set(ours))
        if missing:
            raise ValueError(f"{path}: no {missing[0]} (and {len(missing) - 1} more)")
        self.load_state_dict({key: ours[key] for key in known})
