from __future__ import annotations

import unittest

from tests import support  # noqa: F401

import torch
from torch.nn import functional

from classes import CAMVID11, ID, IGNORE, TOWN, member_table
from losses import dice_loss, focal_loss, upsample_phase


def members(merges: dict) -> torch.Tensor:
    return torch.from_numpy(member_table(merges)).unsqueeze(0)


class Losses(unittest.TestCase):
    def setUp(self) -> None:
        torch.manual_seed(1)
        self.log_p = torch.log_softmax(torch.randn(1, 23, 4, 5), 1)
        self.weights = torch.ones(23)

    def test_without_gamma_and_sets_it_is_cross_entropy(self) -> None:
        labels = torch.randint(0, 23, (1, 4, 5))
        ours = focal_loss(self.log_p, labels, members(TOWN), self.weights, 0.0)
        self.assertAlmostEqual(float(ours), float(functional.nll_loss(self.log_p, labels)), places=5)

    def test_a_set_counts_the_sum_of_its_probabilities(self) -> None:
        labels = torch.full((1, 4, 5), ID["Road"])
        probability = self.log_p.exp()[:, ID["Road"]] + self.log_p.exp()[:, ID["RoadLine"]]
        ours = focal_loss(self.log_p, labels, members(CAMVID11), self.weights, 0.0)
        self.assertAlmostEqual(float(ours), float(-probability.log().mean()), places=5)

    def test_ignored_pixels_have_no_gradient(self) -> None:
        logits = torch.randn(1, 23, 2, 2, requires_grad=True)
        labels = torch.tensor([[[IGNORE, 7], [7, 7]]])
        log_p = torch.log_softmax(logits, 1)
        (focal_loss(log_p, labels, members(TOWN), self.weights, 2.0) + dice_loss(log_p, labels)).backward()
        self.assertEqual(float(logits.grad[0, :, 0, 0].abs().max()), 0.0)
        self.assertGreater(float(logits.grad[0, :, 0, 1].abs().max()), 0.0)

    def test_gamma_weighs_easy_pixels_less(self) -> None:
        labels = self.log_p.argmax(1)
        easy = [float(focal_loss(self.log_p, labels, members(TOWN), self.weights, gamma)) for gamma in (0.0, 2.0)]
        self.assertLess(easy[1], easy[0])

    def test_dice_of_a_perfect_answer_is_zero(self) -> None:
        labels = torch.randint(0, 23, (1, 16, 16))
        logits = 50.0 * functional.one_hot(labels, 23).permute(0, 3, 1, 2).float()
        self.assertAlmostEqual(float(dice_loss(torch.log_softmax(logits, 1), labels)), 0.0, places=4)

    def test_phases_make_up_the_bilinear_enlargement(self) -> None:
        logits = torch.randn(2, 3, 5, 6)
        for factor in (1, 2, 4):
            whole = functional.interpolate(logits, scale_factor=factor, mode="bilinear", align_corners=False)
            for row in range(factor):
                for column in range(factor):
                    part = upsample_phase(logits, factor, row, column)
                    torch.testing.assert_close(part, whole[..., row::factor, column::factor])


if __name__ == "__main__":
    unittest.main()
