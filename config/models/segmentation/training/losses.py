"""Focal loss (Lin et al. 2017) on labels that may stand for several classes, and soft Dice for rare classes."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from classes import IGNORE


def upsample_phase(logits: Tensor, factor: int, row: int, column: int) -> Tensor:
    """Every factor-th pixel, from (row, column) on, of the logits bilinearly enlarged by the factor.

    Equal to `interpolate(logits, scale_factor=factor)[..., row::factor, column::factor]`, at 1 / factor^2 of its cost:
    over steps with random phases the loss sees every pixel of the label.
    """
    if factor == 1:
        return logits
    kernel = torch.ones(1, 1)
    padding = []
    for phase in (column, row):
        shift = (phase + 0.5) / factor - 0.5
        taps = [-shift, 1 + shift] if shift < 0 else [1 - shift, shift]
        padding += [1, 0] if shift < 0 else [0, 1]
        kernel = torch.outer(torch.tensor(taps), kernel.flatten())
    channels = logits.shape[1]
    padded = functional.pad(logits, padding, mode="replicate")
    # `kernel` is rows x columns: the last axis that was multiplied in, the rows, comes first.
    return functional.conv2d(padded, kernel.to(logits).expand(channels, 1, 2, 2), groups=channels)


def set_log_probability(log_probability: Tensor, labels: Tensor, members: Tensor) -> Tensor:
    """Log of the summed probability of the classes that each pixel's label stands for.

    log_probability: N x C x H x W; labels: N x H x W, no IGNORE in it; members: N x C x M, -1 where there is none.
    """
    count = members.shape[2]
    rows = torch.arange(labels.shape[0]).view(-1, 1, 1)
    each = []
    for member in range(count):
        index = members[:, :, member][rows, labels]
        value = log_probability.gather(1, index.clamp_min(0).unsqueeze(1)).squeeze(1)
        if member == 0:
            each.append(value)
        elif bool((index >= 0).any()):
            each.append(value.masked_fill(index < 0, -1e4))
    return each[0] if len(each) == 1 else torch.logsumexp(torch.stack(each), 0)


def focal_loss(log_probability: Tensor, labels: Tensor, members: Tensor, class_weights: Tensor, gamma: float) -> Tensor:
    valid = labels != IGNORE
    known = labels.masked_fill(~valid, 0)
    log_p = set_log_probability(log_probability, known, members)
    weights = class_weights[known] * valid
    loss = -log_p
    if gamma > 0:
        loss = loss * (1 - log_p.detach().exp()).clamp_min(0).pow(gamma)
    return (loss * weights).sum() / weights.sum().clamp_min(1e-6)


def dice_loss(log_probability: Tensor, labels: Tensor) -> Tensor:
    """One minus the soft Dice coefficient, mean over the classes that are present; all pixels counted as one image.

    Labels stand for one class each.
    """
    classes = log_probability.shape[1]
    valid = labels != IGNORE
    known = labels.masked_fill(~valid, 0)
    probability = log_probability.exp()
    hit = probability.gather(1, known.unsqueeze(1)).squeeze(1) * valid
    overlap = torch.zeros(classes).index_add(0, known.flatten(), hit.flatten())
    truth = torch.bincount(known[valid], minlength=classes)
    size = torch.einsum("nchw,nhw->c", probability, valid.to(probability.dtype)) + truth
    present = truth > 0
    if not bool(present.any()):
        return probability.sum() * 0
    return (1 - (2 * overlap + 1) / (size + 1))[present].mean()
