"""Takes the weights of an exported model back into a network that can be trained on: an export has no optimizer and no
normalizations any more, but everything that was learnt."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Callable, Iterable

import torch
from torch import Tensor, nn

Constants = dict[str, deque[list[Tensor | None]]]

# Kinds of nodes that have weights, and which of their inputs these are.
NODES = {"aten::_convolution": (1, 2), "aten::batch_norm": (1, 2, 3, 4), "aten::prelu": (1,)}


def constants(exported: torch.jit.ScriptModule) -> Constants:
    """Weights of a frozen model by kind of node, in the order in which they are applied."""
    found: Constants = {kind: deque() for kind in NODES}
    for node in exported.graph.nodes():
        if node.kind() in NODES:
            found[node.kind()].append([node.inputsAt(index).toIValue() for index in NODES[node.kind()]])
    return found


def application_order(net: nn.Module) -> list[nn.Module]:
    """Modules with weights, in the order in which one image meets them."""
    order: list[nn.Module] = []
    kinds = (nn.Conv2d, nn.BatchNorm2d, nn.PReLU)
    hooks = [part.register_forward_hook(lambda module, *_: order.append(module))
             for part in net.modules() if isinstance(part, kinds)]
    with torch.no_grad():
        net.eval()(torch.zeros(1, 3, 64, 96))
    for hook in hooks:
        hook.remove()
    return order


def copy_into(target: Tensor, value: Tensor | None) -> None:
    if value is None or value.shape != target.shape:
        raise ValueError(f"expected weights of {tuple(target.shape)}, the exported model has "
                         f"{None if value is None else tuple(value.shape)}")
    target.copy_(value)


def take(found: Constants, kind: str) -> list[Tensor | None]:
    if not found[kind]:
        raise ValueError(f"the exported model has too few nodes {kind}")
    return found[kind].popleft()


@torch.no_grad()
def load_exported(net: nn.Module, path: Path) -> list[nn.BatchNorm2d]:
    """Returns the normalizations that the export had made part of the convolution before them; they pass on what they get, plus a
    bias, until `restore_normalizations` gives them statistics. Raises ValueError for a model of another architecture."""
    found = constants(torch.jit.load(str(path), map_location="cpu"))
    folded, bias = [], None
    for module in application_order(net):
        if isinstance(module, nn.Conv2d):
            weight, bias = take(found, "aten::_convolution")
            copy_into(module.weight, weight)
            if module.bias is not None:
                copy_into(module.bias, bias)
                bias = None
        elif isinstance(module, nn.PReLU):
            copy_into(module.weight, take(found, "aten::prelu")[0])
        elif bias is not None:
            copy_into(module.bias, bias)
            module.weight.fill_(1)
            module.running_mean.zero_()
            module.running_var.fill_(1 - module.eps)
            folded.append(module)
            bias = None
        else:
            values = take(found, "aten::batch_norm")
            for target, value in zip((module.weight, module.bias, module.running_mean, module.running_var), values):
                copy_into(target, value)
    left = sum(len(nodes) for nodes in found.values())
    if left:
        raise ValueError(f"{path} has {left} nodes with weights that the network has not")
    return folded


@torch.no_grad()
def restore_normalizations(net: nn.Module, folded: list[nn.BatchNorm2d], batches: Iterable[Tensor]) -> None:
    """Gives normalizations the mean and variance of what they see in these images, and weights that undo them: the network
    computes the same, and training, which normalizes by each batch, starts from there."""
    sums = {module: [0, 0.0, 0.0] for module in folded}

    def observer(module: nn.BatchNorm2d) -> Callable:
        def observe(_module: nn.Module, inputs: tuple[Tensor, ...], _output: Tensor) -> None:
            x = inputs[0].double()
            seen = sums[module]
            seen[0] += x.numel() // x.shape[1]
            seen[1] = seen[1] + x.sum((0, 2, 3))
            seen[2] = seen[2] + x.square().sum((0, 2, 3))
        return observe

    hooks = [module.register_forward_hook(observer(module)) for module in folded]
    net.eval()
    for images in batches:
        net(images)
    for hook in hooks:
        hook.remove()
    for module, (count, total, squares) in sums.items():
        mean = total / count
        variance = (squares / count - mean.square()).clamp_min(0)
        module.running_mean.copy_(mean)
        module.running_var.copy_(variance)
        module.weight.copy_((variance + module.eps).sqrt())
        module.bias.add_(mean.to(module.bias.dtype))
