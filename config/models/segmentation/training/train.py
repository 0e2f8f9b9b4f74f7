#!/usr/bin/python3
"""Trains a segmentation model: see README.md beside this file. SIGTERM stops it with a checkpoint to resume from."""

from __future__ import annotations

import argparse
import copy
import json
import math
import signal
import time
from pathlib import Path

import torch
from torch import Tensor, nn

import datasets
from classes import CLASS_COUNT
from datasets import Pixels, Split
from deeplab import DeepLabV3Plus
from layers import count_parameters
from losses import dice_loss, focal_loss, upsample_phase
from metrics import Confusion
from recipes import RECIPES, Recipe
from sampling import MEAN, STD, Batch, Sampler, class_weights
from warm_start import load_exported, restore_normalizations

WARM_UP = 0.03  # part of the run
LAST_RATE = 0.01  # of the learning rate, at the end of the cycle
STATISTICS_BATCHES = 20  # for the normalizations of an exported model


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", choices=sorted(RECIPES), default="paper")
    parser.add_argument("--town", type=Path, required=True, help="folder that semmap town collect wrote")
    parser.add_argument("--segmentation-data", type=Path, help="folder with carla_town_409, camvid11 and camvid32")
    start = parser.add_mutually_exclusive_group()
    start.add_argument("--encoder-weights", type=Path, help="published weights that the encoder starts from")
    start.add_argument("--start-from", type=Path, help="an exported model of the same architecture to go on from")
    parser.add_argument("--cache", type=Path, required=True, help="folder for resized pixels (some gigabytes)")
    parser.add_argument("--output", type=Path, required=True, help="folder for checkpoint.pt and log.jsonl")
    length = parser.add_mutually_exclusive_group(required=True)
    length.add_argument("--minutes", type=float, help="length of the run; the schedule is fitted to it")
    length.add_argument("--steps", type=int, help="length of the run")
    parser.add_argument("--resume", action="store_true", help="go on from the checkpoint in --output")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--bf16", action="store_true", help="convolutions in bfloat16: faster for the paper's model where the CPU has it")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--report-every", type=int, default=20, help="steps between lines of progress")
    parser.add_argument("--evaluate-every", type=float, default=8, help="minutes between evaluations and checkpoints")
    parser.add_argument("--evaluate-images", type=int, default=40, help="images of each held out set")
    return parser.parse_args()


def training_splits(recipe: Recipe, town: Path, data: Path | None) -> tuple[dict[str, Split], list[Split]]:
    """Splits to train on by the recipe's names, and held out ones."""
    train = {"town": datasets.town(town, "train")}
    held_out = [datasets.town(town, "val")]
    if data is not None:
        camvid_val = datasets.camvid11(data / "camvid11", "val")
        train["carla"] = datasets.carla(data / "carla_town_409", "train")
        train["camvid11"] = datasets.camvid11(data / "camvid11", "train")
        train["camvid32"] = datasets.camvid32(data / "camvid32", camvid_val)
        held_out += [datasets.carla(data / "carla_town_409", "val"), camvid_val]
    return {name: train[name] for name in recipe.shares if name in train}, held_out


class Schedule:
    """Part of the run that is over, by steps or by time, and the learning rate there."""

    def __init__(self, recipe: Recipe, steps: int | None, minutes: float | None):
        self.recipe, self.steps, self.seconds = recipe, steps, 60 * minutes if minutes else None

    def done(self, step: int, elapsed: float) -> float:
        return step / self.steps if self.steps else elapsed / self.seconds

    def factor(self, done: float) -> float:
        if not self.recipe.one_cycle:
            return 1.0
        if done < WARM_UP:
            return max(done, 1e-3) / WARM_UP
        angle = math.pi * min(1.0, (done - WARM_UP) / (1 - WARM_UP))
        return LAST_RATE + (1 - LAST_RATE) * 0.5 * (1 + math.cos(angle))


class Average:
    """Exponential moving average of weights and of the statistics of normalizations."""

    def __init__(self, model: nn.Module, decay: float):
        self.model = copy.deepcopy(model).eval()
        self.decay = decay

    @torch.no_grad()
    def update(self, model: nn.Module, step: int) -> None:
        decay = min(self.decay, (1 + step) / (10 + step))
        for ours, theirs in zip(self.model.state_dict().values(), model.state_dict().values()):
            if ours.dtype.is_floating_point:
                ours.lerp_(theirs, 1 - decay)
            else:
                ours.copy_(theirs)


class Trainer:
    def __init__(self, recipe: Recipe, sampler: Sampler, weights: Tensor, schedule: Schedule,
                 encoder_weights: Path | None, start_from: Path | None = None):
        self.recipe, self.sampler, self.weights, self.schedule = recipe, sampler, weights, schedule
        self.model = DeepLabV3Plus(recipe.architecture)
        if encoder_weights is not None:
            self.model.encoder.load_published_weights(str(encoder_weights))
        if start_from is not None:
            folded = load_exported(self.model, start_from)
            restore_normalizations(self.model, folded, (sampler.next(recipe.batch).images for _ in range(STATISTICS_BATCHES)))
        self.model.encoder.freeze(recipe.frozen)
        self.model.to(memory_format=torch.channels_last)
        encoder = [p for p in self.model.encoder.parameters() if p.requires_grad]
        others = [p for name, p in self.model.named_parameters() if not name.startswith("encoder.")]
        self.optimizer = torch.optim.AdamW(
            [{"params": encoder, "part": recipe.encoder_rate}, {"params": others, "part": 1.0}],
            lr=recipe.learning_rate, weight_decay=recipe.weight_decay)
        self.average = Average(self.model, recipe.ema) if recipe.ema > 0 else None
        self.step, self.elapsed = 0, 0.0
        self.bf16 = False

    def best_model(self) -> nn.Module:
        return self.average.model if self.average else self.model

    def loss(self, batch: Batch) -> Tensor:
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=self.bf16):
            logits = self.model(batch.images.contiguous(memory_format=torch.channels_last))
        logits = logits.float()
        factor = batch.images.shape[3] // logits.shape[3]
        if self.recipe.loss_phases:
            row, column = (int(value) for value in self.sampler.random.integers(factor, size=2))
            logits = upsample_phase(logits, factor, row, column)
            labels = batch.labels[:, row::factor, column::factor]
        else:
            logits = nn.functional.interpolate(logits, scale_factor=factor, mode="bilinear", align_corners=False)
            labels = batch.labels
        log_probability = torch.log_softmax(logits, 1)
        loss = focal_loss(log_probability, labels, batch.members, self.weights, self.recipe.gamma)
        if self.recipe.dice > 0 and bool(batch.exact.any()):
            loss = loss + self.recipe.dice * dice_loss(log_probability[batch.exact], labels[batch.exact])
        return loss

    def train_step(self) -> float:
        factor = self.schedule.factor(self.schedule.done(self.step, self.elapsed))
        for group in self.optimizer.param_groups:
            group["lr"] = self.recipe.learning_rate * group["part"] * factor
        self.model.train()
        self.model.encoder.keep_frozen()
        loss = self.loss(self.sampler.next(self.recipe.batch))
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.model.parameters(), 5.0)
        self.optimizer.step()
        self.step += 1
        if self.average:
            self.average.update(self.model, self.step)
        return float(loss)

    def save(self, path: Path) -> None:
        state = {
            "architecture": self.recipe.architecture, "step": self.step, "elapsed": self.elapsed,
            "model": self.model.state_dict(), "optimizer": self.optimizer.state_dict(),
            "average": self.average.model.state_dict() if self.average else None,
            "sampler": self.sampler.state(), "torch_random": torch.get_rng_state(),
        }
        part = path.with_suffix(".part")
        torch.save(state, part)
        part.replace(path)

    def restore(self, path: Path) -> None:
        state = torch.load(path, map_location="cpu")
        self.step, self.elapsed = state["step"], state["elapsed"]
        self.model.load_state_dict(state["model"])
        self.optimizer.load_state_dict(state["optimizer"])
        if self.average:
            self.average.model.load_state_dict(state["average"])
        self.sampler.restore(state["sampler"])
        torch.set_rng_state(state["torch_random"])


@torch.no_grad()
def quick_evaluation(model: nn.Module, pixels: Pixels, width: int, height: int, images: int) -> Confusion:
    """Evenly spread images at the network's size; evaluate.py has the figures that count."""
    model.eval()
    confusion = Confusion(pixels.split.merges)
    count = len(pixels.labels)
    mean, std = torch.tensor(MEAN).view(1, 3, 1, 1), torch.tensor(STD).view(1, 3, 1, 1)
    for index in range(0, count, max(1, count // images)):
        image = torch.from_numpy(pixels.images[index].copy()).permute(2, 0, 1).unsqueeze(0).float() / 255
        image = nn.functional.interpolate(image, size=(height, width), mode="bilinear", align_corners=False)
        logits = model(((image - mean) / std).contiguous(memory_format=torch.channels_last))
        label = pixels.labels[index]
        logits = nn.functional.interpolate(logits, size=label.shape, mode="bilinear", align_corners=False)
        confusion.add(label, logits.argmax(1)[0].numpy())
    return confusion


class Log:
    """A line of JSON for each event, and a line for people."""

    def __init__(self, path: Path):
        self.file = path.open("a")

    def write(self, text: str, **values: object) -> None:
        print(time.strftime("%H:%M:%S"), text, flush=True)
        self.file.write(json.dumps(values) + "\n")
        self.file.flush()


def run(trainer: Trainer, held_out: list[Pixels], output: Path, options: argparse.Namespace) -> None:
    log = Log(output / "log.jsonl")
    checkpoint = output / "checkpoint.pt"
    size = trainer.recipe.augmentation
    width = size.base_width or held_out[0].images.shape[2] // 32 * 32
    height = round(width * 0.75 / 32) * 32
    last_evaluation, losses, began = trainer.elapsed, [], time.monotonic()
    before = trainer.elapsed
    reported_step, reported_at = trainer.step, trainer.elapsed

    def evaluate() -> None:
        model = trainer.best_model()
        scores = {}
        for pixels in held_out:
            scores[pixels.split.name] = quick_evaluation(model, pixels, width, height, options.evaluate_images).mean_iou()
        trainer.save(checkpoint)
        log.write("evaluation  " + "  ".join(f"{name} mIoU {value:.4f}" for name, value in scores.items()),
                  event="evaluation", step=trainer.step, elapsed=trainer.elapsed, mean_iou=scores)

    stopped = []
    signal.signal(signal.SIGTERM, lambda *_: stopped.append(True))
    while trainer.schedule.done(trainer.step, trainer.elapsed) < 1:
        if stopped:
            trainer.save(checkpoint)
            return
        losses.append(trainer.train_step())
        trainer.elapsed = before + time.monotonic() - began
        if trainer.step % options.report_every == 0:
            done = trainer.schedule.done(trainer.step, trainer.elapsed)
            rate = trainer.recipe.batch * (trainer.step - reported_step) / max(trainer.elapsed - reported_at, 1e-6)
            reported_step, reported_at = trainer.step, trainer.elapsed
            loss, left = sum(losses) / len(losses), trainer.elapsed * (1 - done) / max(done, 1e-6)
            learning_rate = trainer.optimizer.param_groups[-1]["lr"]
            losses.clear()
            log.write(f"step {trainer.step}  loss {loss:.4f}  lr {learning_rate:.2e}  {rate:.2f} images/s  "
                      f"{100 * done:.1f} %  ETA {left / 60:.1f} min",
                      event="step", step=trainer.step, loss=loss, lr=learning_rate, images_per_second=rate,
                      elapsed=trainer.elapsed)
        if trainer.elapsed - last_evaluation > 60 * options.evaluate_every:
            evaluate()
            trainer.elapsed = before + time.monotonic() - began
            reported_step, reported_at = trainer.step, trainer.elapsed
            last_evaluation = trainer.elapsed
    evaluate()


def main() -> None:
    options = arguments()
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    recipe = RECIPES[options.recipe]
    options.output.mkdir(parents=True, exist_ok=True)
    train_splits, held_out_splits = training_splits(recipe, options.town, options.segmentation_data)
    width, height = recipe.cache_size
    sets = [datasets.load(split, options.cache, width, height) for split in train_splits.values()]
    held_out = [datasets.load(split, options.cache, width, height) for split in held_out_splits]
    shares = [recipe.shares[name] for name in train_splits]
    sampler = Sampler(sets, shares, recipe.augmentation, recipe.common, options.seed)
    weights = torch.from_numpy(class_weights(sets, shares, recipe.class_power, recipe.class_limit)).float()
    checkpoint = options.output / "checkpoint.pt"
    resumes = options.resume and checkpoint.exists()
    # A checkpoint has all weights: those of an export, and the batches that measure its statistics, would be for nothing.
    trainer = Trainer(recipe, sampler, weights, Schedule(recipe, options.steps, options.minutes), options.encoder_weights,
                      None if resumes else options.start_from)
    trainer.bf16 = options.bf16
    if resumes:
        trainer.restore(checkpoint)
    print(f"{recipe.architecture}: {count_parameters(trainer.model):,} parameters;",
          ", ".join(f"{pixels.split.name} {len(pixels.labels)}" for pixels in sets + held_out), flush=True)
    run(trainer, held_out, options.output, options)


if __name__ == "__main__":
    main()
