"""Recipes: everything that decides how a model turns out, apart from the data's place and the time it gets."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from augment import Augmentation


@dataclass(frozen=True)
class Recipe:
    architecture: str
    augmentation: Augmentation
    shares: dict[str, float]  # part of each batch by data set
    cache_size: tuple[int, int]  # width and height at which 4:3 images are kept
    batch: int
    learning_rate: float
    encoder_rate: float = 1.0  # of the learning rate
    weight_decay: float = 0.01
    gamma: float = 2.0  # of the focal loss
    dice: float = 0.0  # weight of the Dice loss
    class_power: float = 0.0  # of the classes' inverse frequency in the focal loss; 0 weighs all alike
    class_limit: float = 10.0
    common: float = 0.0  # images of classes rarer than this share of images come more often; 0: all alike
    one_cycle: bool = False  # otherwise the learning rate stays
    ema: float = 0.0  # 0: no average of weights
    frozen: tuple[str, ...] = field(default_factory=tuple)  # parts of the encoder that keep their first weights
    loss_phases: bool = False  # loss at one pixel of each k x k, the phase drawn anew each step


RECIPES: dict[str, Recipe] = {
    # Section 3 of the paper.
    "paper": Recipe(
        architecture="resnext50_32x4d",
        augmentation=Augmentation(512, 512, flip=0.5, noise=0.2, perspective=0.5),
        shares={"town": 1.0},
        cache_size=(800, 600),
        batch=6,
        learning_rate=1e-4,
    ),
    # One CPU core and an hour or two.
    "light": Recipe(
        architecture="espnetv2",
        augmentation=Augmentation(
            384, 288, base_width=512, scale=(0.75, 1.5), rotation=3.0, flip=0.5, noise=0.15, noise_sigma=8.0,
            perspective=0.2, perspective_shift=0.05, colour=0.6, grey=0.25, rare=0.6,
        ),
        shares={"town": 0.68, "carla": 0.13, "camvid11": 0.14, "camvid32": 0.05},
        cache_size=(640, 480),
        batch=6,
        learning_rate=2e-3,
        encoder_rate=0.4,
        gamma=1.0,
        dice=1.0,
        class_power=0.35,
        class_limit=6.0,
        common=0.4,
        one_cycle=True,
        ema=0.995,
        frozen=("level1", "level2_0"),
        loss_phases=True,
    ),
}

# Goes on from a trained light model (`--start-from`): lower rates, and images nearer to the camera's own size.
RECIPES["light-on"] = replace(
    RECIPES["light"],
    augmentation=replace(RECIPES["light"].augmentation, width=416, height=320, base_width=608, scale=(0.7, 1.4), shadow=0.25),
    shares={"town": 0.66, "carla": 0.17, "camvid11": 0.13, "camvid32": 0.04},
    learning_rate=1e-3,
)
