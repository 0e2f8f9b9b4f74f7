from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

from tests import support  # noqa: F401

import torch
from torch import nn

import export
import modelfile
from deeplab import ARCHITECTURES, DeepLabV3Plus
from espnetv2 import FixedSlope, dilations
from layers import Depthwise, prefer_onednn


class Model(unittest.TestCase):
    def test_logits_have_the_resolution_of_the_decoder(self) -> None:
        for name, factor in (("espnetv2", 2), ("resnext50_32x4d", 4)):
            net = DeepLabV3Plus(name).eval()
            with torch.no_grad():
                logits = net(torch.zeros(1, 3, 64, 96))
            self.assertEqual(tuple(logits.shape), (1, 23, 64 // factor, 96 // factor), name)
        self.assertEqual(sorted(ARCHITECTURES), ["espnetv2", "resnext50_32x4d"])

    def test_dilation_of_a_point_changes_nothing(self) -> None:
        plain = nn.Conv2d(16, 8, 1)
        other = nn.Conv2d(16, 8, 1)
        other.load_state_dict(plain.state_dict())
        prefer_onednn(other)
        x = torch.randn(1, 16, 40, 40)
        torch.testing.assert_close(plain(x), other(x))

    def test_dilations_fall_back_beyond_the_reach(self) -> None:
        self.assertEqual(dilations(13), [1, 2, 3, 4])
        self.assertEqual(dilations(7), [1, 1, 2, 3])

    def test_fixed_slope_has_the_gradient_of_prelu(self) -> None:
        slope = torch.tensor([0.2, -0.5])
        x = torch.randn(2, 2, 3, 3, requires_grad=True)
        ours, = torch.autograd.grad(FixedSlope.apply(x, slope).pow(2).sum(), x)
        theirs, = torch.autograd.grad(torch.prelu(x, slope).pow(2).sum(), x)
        torch.testing.assert_close(ours, theirs)

    def test_dilated_depthwise_has_the_gradients_of_pytorch(self) -> None:
        for stride, dilation in ((1, 2), (1, 4), (2, 2), (2, 3)):
            layer = Depthwise(4, stride, dilation).train().double()
            x = torch.randn(2, 4, 12, 14, dtype=torch.float64, requires_grad=True)
            ours = layer(x)
            layer.eval()
            theirs = layer(x)
            torch.testing.assert_close(ours, theirs)
            outer = torch.randn_like(ours)
            for mine, reference in zip(*(torch.autograd.grad(y, (x, layer.weight), outer) for y in (ours, theirs))):
                torch.testing.assert_close(mine, reference)

    def test_frozen_parts_stay(self) -> None:
        net = DeepLabV3Plus("espnetv2")
        net.encoder.freeze(("level1", "level2_0"))
        net.train()
        net.encoder.keep_frozen()
        before = {name: value.clone() for name, value in net.encoder.level2_0.state_dict().items()}
        net(torch.randn(2, 3, 64, 64)).sum().backward()
        self.assertTrue(all(parameter.grad is None for parameter in net.encoder.level1.parameters()))
        self.assertTrue(all(bool((before[name] == value).all()) for name, value in net.encoder.level2_0.state_dict().items()))

    def test_exported_model_agrees_at_any_size(self) -> None:
        torch.manual_seed(1)
        net = DeepLabV3Plus("espnetv2").eval().to(memory_format=torch.channels_last)
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "model.pt")
            export.torchscript(net, 64, 96).save(path)
            loaded = torch.jit.load(path)
        self.assertLess(export.check(loaded, net), export.TOLERANCE)
        self.assertTrue(loaded(torch.zeros(1, 3, 64, 96)).is_contiguous())


class Description(unittest.TestCase):
    def test_written_and_read(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "street.yaml"
            written = modelfile.ModelFile(Path(folder) / "street.pt", 512, 384, (0.485, 0.456, 0.406), (0.2, 0.2, 0.2), "carla23")
            modelfile.write(path, written, "A model.")
            self.assertEqual(modelfile.read(path), written)

    def test_size_keeps_area_and_aspect(self) -> None:
        model = modelfile.ModelFile(Path("x"), 512, 384, (), (), "carla23")
        self.assertEqual(model.network_size(800, 600), (512, 384))
        width, height = model.network_size(1241, 376)
        self.assertEqual((width % 32, height % 32), (0, 0))
        self.assertLess(abs(width * height / (512 * 384) - 1), 0.15)


if __name__ == "__main__":
    unittest.main()
