from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

from tests import support  # noqa: F401

import torch
from torch import nn

import export
from deeplab import DeepLabV3Plus
from warm_start import load_exported, restore_normalizations


def with_lively_normalizations(net: nn.Module) -> nn.Module:
    """Statistics and weights as training leaves them, not 0 and 1."""
    for part in net.modules():
        if isinstance(part, nn.BatchNorm2d):
            nn.init.uniform_(part.weight, 0.5, 1.5)
            nn.init.normal_(part.bias, 0, 0.2)
            nn.init.normal_(part.running_mean, 0, 0.2)
            nn.init.uniform_(part.running_var, 0.5, 2.0)
    return net


class WarmStart(unittest.TestCase):
    def setUp(self) -> None:
        torch.manual_seed(1)
        self.images = torch.randn(4, 3, 64, 96)

    def exported(self, name: str, folder: str) -> tuple[nn.Module, Path]:
        net = with_lively_normalizations(DeepLabV3Plus(name)).eval().to(memory_format=torch.channels_last)
        path = Path(folder) / f"{name}.pt"
        export.torchscript(net, 64, 96).save(str(path))
        return net, path

    def test_network_computes_what_the_export_did(self) -> None:
        for name in ("espnetv2", "resnext50_32x4d"):
            with tempfile.TemporaryDirectory() as folder, torch.no_grad():
                trained, path = self.exported(name, folder)
                net = DeepLabV3Plus(name)
                folded = load_exported(net, path)
                expected = trained(self.images)
                scale = float(expected.abs().max())
                self.assertLess(float((net.eval()(self.images) - expected).abs().max()), 1e-4 * scale, name)
                restore_normalizations(net, folded, [self.images])
                self.assertLess(float((net.eval()(self.images) - expected).abs().max()), 1e-4 * scale, name)

    def test_training_starts_from_there(self) -> None:
        """In training, normalizations take the batch's statistics: on the images measured the network is the same."""
        with tempfile.TemporaryDirectory() as folder, torch.no_grad():
            trained, path = self.exported("resnext50_32x4d", folder)
            net = DeepLabV3Plus("resnext50_32x4d")
            folded = load_exported(net, path)
            expected = trained(self.images)

            def worst() -> float:
                net.train()
                for part in net.modules():
                    if isinstance(part, nn.Dropout):
                        part.eval()
                return float((net(self.images) - expected).abs().max() / expected.abs().max())

            before = worst()
            load_exported(net, path)
            restore_normalizations(net, folded, [self.images])
            self.assertLess(worst(), 0.01)
            self.assertGreater(before, 0.1)

    def test_other_architecture_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            _, path = self.exported("espnetv2", folder)
            with self.assertRaises(ValueError):
                load_exported(DeepLabV3Plus("resnext50_32x4d"), path)


if __name__ == "__main__":
    unittest.main()
