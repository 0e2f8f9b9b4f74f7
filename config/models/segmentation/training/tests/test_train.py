from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

from tests import support

import torch

import datasets
import plot
from augment import Augmentation
from recipes import RECIPES
from sampling import Sampler
from train import Schedule, Trainer

TRAINING = Path(__file__).resolve().parent.parent


class Training(unittest.TestCase):
    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)
        support.write_town(self.folder / "town")
        self.recipe = replace(RECIPES["light"], augmentation=Augmentation(64, 32, base_width=80), batch=2)

    def trainer(self) -> Trainer:
        torch.manual_seed(1)
        pixels = datasets.load(datasets.town(self.folder / "town", "train"), self.folder / "cache", 80, 60)
        sampler = Sampler([pixels], [1.0], self.recipe.augmentation, 0.0, 1)
        return Trainer(self.recipe, sampler, torch.ones(23), Schedule(self.recipe, 8, None), None)

    def test_it_learns(self) -> None:
        trainer = self.trainer()
        losses = [trainer.train_step() for _ in range(8)]
        self.assertLess(losses[-1], losses[0])

    def test_resumed_run_goes_the_same_way(self) -> None:
        one = self.trainer()
        for _ in range(2):
            one.train_step()
        one.save(self.folder / "checkpoint.pt")
        expected = one.train_step()
        other = self.trainer()
        other.restore(self.folder / "checkpoint.pt")
        self.assertAlmostEqual(other.train_step(), expected, places=5)
        self.assertEqual(other.step, 3)

    def test_schedule(self) -> None:
        schedule = Schedule(self.recipe, None, 10)
        self.assertAlmostEqual(schedule.done(5, 300), 0.5)
        self.assertLess(schedule.factor(0.0), 0.1)
        self.assertGreater(schedule.factor(0.05), 0.95)
        self.assertLess(schedule.factor(1.0), 0.02)
        self.assertEqual(Schedule(RECIPES["paper"], 10, None).factor(0.9), 1.0)

    def test_commands_train_export_evaluate_and_plot(self) -> None:
        def run(program: str, *options: object) -> str:
            command = [sys.executable, str(TRAINING / program), *map(str, options)]
            return subprocess.run(command, check=True, capture_output=True, text=True).stdout

        output = self.folder / "run"
        for steps in (1, 2):
            run("train.py", "--recipe", "light", "--town", self.folder / "town", "--cache", self.folder / "cache",
                "--output", output, "--steps", steps, "--resume", "--report-every", 1)
        events = plot.read(output / "log.jsonl")
        self.assertEqual([event["step"] for event in events if event["event"] == "step"], [1, 2])
        run("export.py", "--checkpoint", output / "checkpoint.pt", "--output", self.folder / "m.pt", "--width", 64, "--height", 64)
        table = run("evaluate.py", "--model", self.folder / "m.yaml", "--dataset", "town", "--town", self.folder / "town",
                    "--json", self.folder / "m.json")
        self.assertIn("mean IoU over 2 classes present", table)
        self.assertEqual(json.loads((self.folder / "m.json").read_text())["images"], 2)
        run("plot.py", "--log", output / "log.jsonl", "--output", self.folder / "m.png")
        self.assertTrue((self.folder / "m.png").stat().st_size > 1000)


if __name__ == "__main__":
    unittest.main()
