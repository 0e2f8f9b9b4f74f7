"""ResNeXt-50 32x4d as an encoder of output stride 16 (architecture and initialization of torchvision)."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torchvision.models import resnext50_32x4d


class ResNeXt50(nn.Module):
    """Features at 1/2, 1/4, 1/8 and 1/16 of the input; the last stage is dilated instead of strided."""

    channels = (64, 256, 512, 2048)

    def __init__(self) -> None:
        super().__init__()
        self.frozen: tuple[str, ...] = ()
        net = resnext50_32x4d(weights=None, replace_stride_with_dilation=[False, False, True])
        self.stem = nn.Sequential(net.conv1, net.bn1, net.relu)
        self.pool = net.maxpool
        self.layer1, self.layer2, self.layer3, self.layer4 = net.layer1, net.layer2, net.layer3, net.layer4

    def forward(self, x: Tensor) -> list[Tensor]:
        half = self.stem(x)
        quarter = self.layer1(self.pool(half))
        eighth = self.layer2(quarter)
        return [half, quarter, eighth, self.layer4(self.layer3(eighth))]

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
        """Loads torchvision's ImageNet weights from a file (the paper starts from them); the classifier is left out."""
        state = torch.load(path, map_location="cpu")
        stem = {"conv1.": "stem.0.", "bn1.": "stem.1."}
        renamed = {}
        for key, value in state.items():
            if key.startswith("fc."):
                continue
            for old, new in stem.items():
                if key.startswith(old):
                    key = new + key[len(old):]
            renamed[key] = value
        self.load_state_dict(renamed)
