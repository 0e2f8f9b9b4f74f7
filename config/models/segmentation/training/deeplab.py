"""DeepLabV3+ (Chen et al., "Encoder-Decoder with Atrous Separable Convolution for Semantic Image Segmentation",
ECCV 2018): atrous spatial pyramid pooling over the encoder's last feature, then a decoder that joins it with early ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from classes import CLASS_COUNT
from espnetv2 import EspNetV2
from layers import ConvNormRelu, SeparableConv, prefer_onednn, resize_like
from resnext import ResNeXt50


class Aspp(nn.Module):
    def __init__(self, inputs: int, outputs: int, rates: Sequence[int], dropout: float):
        super().__init__()
        self.point = ConvNormRelu(inputs, outputs)
        self.atrous = nn.ModuleList(SeparableConv(inputs, outputs, rate) for rate in rates)
        # No normalization here: it would be of one value for each image.
        self.pooled = nn.Sequential(nn.AdaptiveAvgPool2d(1), nn.Conv2d(inputs, outputs, 1), nn.ReLU(inplace=True))
        self.project = nn.Sequential(ConvNormRelu(outputs * (len(rates) + 2), outputs), nn.Dropout(dropout))

    def forward(self, x: Tensor) -> Tensor:
        branches = [self.point(x)]
        for branch in self.atrous:
            branches.append(branch(x))
        branches.append(self.pooled(x).expand(-1, -1, x.shape[2], x.shape[3]))
        return self.project(torch.cat(branches, 1))


class Join(nn.Module):
    """One step of the decoder: what is known so far, enlarged, beside an early feature, narrowed."""

    def __init__(self, coarse: int, early: int, narrowed: int, outputs: int, convolutions: int):
        super().__init__()
        self.narrow = ConvNormRelu(early, narrowed)
        widths = [coarse + narrowed] + [outputs] * convolutions
        self.mix = nn.Sequential(*(SeparableConv(a, b) for a, b in zip(widths, widths[1:])))

    def forward(self, coarse: Tensor, early: Tensor) -> Tensor:
        narrowed = self.narrow(early)
        return self.mix(torch.cat((resize_like(coarse, narrowed), narrowed), 1))


@dataclass(frozen=True)
class DecoderStep:
    feature: int  # index into the encoder's list of features
    narrowed: int
    outputs: int
    convolutions: int = 1


@dataclass(frozen=True)
class Architecture:
    encoder: Callable[[], nn.Module]
    aspp_channels: int
    aspp_rates: tuple[int, ...]
    decoder: tuple[DecoderStep, ...]
    dropout: float


ARCHITECTURES: dict[str, Architecture] = {
    # The paper's: one early feature at 1/4, two convolutions, 256 channels.
    "resnext50_32x4d": Architecture(ResNeXt50, 256, (6, 12, 18), (DecoderStep(1, 48, 256, 2),), 0.5),
    # For a CPU in real time: narrow, and joined at 1/8, 1/4 and 1/2, because poles and lines are one or two pixels wide.
    "espnetv2": Architecture(
        EspNetV2, 96, (2, 4, 8), (DecoderStep(2, 48, 96), DecoderStep(1, 32, 40), DecoderStep(0, 16, 32)), 0.1
    ),
}


class DeepLabV3Plus(nn.Module):
    """Logits at the resolution of the decoder's last early feature; the caller enlarges them where it needs to."""

    def __init__(self, name: str, classes: int = CLASS_COUNT):
        super().__init__()
        plan = ARCHITECTURES[name]
        self.encoder = plan.encoder()
        channels = self.encoder.channels
        self.aspp = Aspp(channels[-1], plan.aspp_channels, plan.aspp_rates, plan.dropout)
        self.early = [step.feature for step in plan.decoder]
        widths = [plan.aspp_channels] + [step.outputs for step in plan.decoder]
        self.joins = nn.ModuleList(
            Join(coarse, channels[step.feature], step.narrowed, step.outputs, step.convolutions)
            for coarse, step in zip(widths, plan.decoder)
        )
        self.classify = nn.Conv2d(widths[-1], classes, 1)
        prefer_onednn(self)

    def forward(self, x: Tensor) -> Tensor:
        features = self.encoder(x)
        y = self.aspp(features[-1])
        for index, join in zip(self.early, self.joins):
            y = join(y, features[index])
        return self.classify(y)
