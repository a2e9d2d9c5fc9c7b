# SPDX-License-Identifier: BSD-3-Clause
"""Steps of the training, in the order in which they run; each can be run alone."""
import argparse
import multiprocessing
import os
import subprocess
from pathlib import Path

import cv2
import torch

from . import data, encoder_training, segmenter_training

ROOT = Path(__file__).resolve().parent.parent.parent
STEPS = ("render", "cache", "train", "export", "evaluate")
# folder: first seed of the apartments (disjoint), number of them, views of each, surfaces
RENDERED = {
    "train": ((10001, 240, 20, "training"), (20001, 60, 20, "own")),
    "validation": ((5001, 12, 10, "training"),),
    "test_held_out": ((901, 20, 10, "held_out"),),
    "test_own": ((1, 20, 10, "own"),)}


def parse(description):
    parser = argparse.ArgumentParser(
        "train_demo_models", description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, required=True,
                        help="folder for renders, caches and checkpoints (8 GB)")
    parser.add_argument("--output", type=Path, default=ROOT / "models" / "demo")
    parser.add_argument("--reference", type=Path,
                        default=ROOT / "test" / "data" / "demo_models_reference.json",
                        help="outputs for the tests to compare with")
    parser.add_argument("--programs", type=Path,
                        default=ROOT / "build" / "devel" / "lib" / "task_scene_graph")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--segmenter-steps", type=int, default=2400)
    parser.add_argument("--encoder-steps", type=int, default=1600)
    parser.add_argument("--step", action="append", choices=STEPS, help="only this one; repeatable")
    return parser.parse_args()


def render(arguments):
    for folder, parts in RENDERED.items():
        for first, count, views, surfaces in parts:
            subprocess.run([
                arguments.programs / "render_apartments", "--output",
                arguments.work / "data" / folder, "--first-seed", str(first), "--apartments",
                str(count), "--views", str(views), "--surfaces", surfaces], check=True)


def load_training_data(arguments):
    return data.load(arguments.work / "data" / "train", arguments.work / "cache" / "train",
                     disturb=True, processes=os.cpu_count())


def train_one(kind, arguments):
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    views, crops = load_training_data(arguments)
    if kind == "segmenter":
        segmenter_training.train(views, arguments.work / "segmenter.pt", arguments.segmenter_steps,
                                 arguments.seed)
    else:
        encoder_training.train(crops, arguments.work / "encoder.pt", arguments.encoder_steps,
                               arguments.seed)


def train(arguments):
    """Both networks at once, one thread each: results do not depend on what else runs."""
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=train_one, args=(kind, arguments))
                 for kind in ("segmenter", "encoder")]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    if any(process.exitcode != 0 for process in processes):
        raise RuntimeError("training failed, see above")


def main(description):
    arguments = parse(description)
    arguments.work.mkdir(parents=True, exist_ok=True)
    from . import evaluate, export
    actions = {"render": render, "cache": load_training_data, "train": train,
               "export": export.export_all, "evaluate": evaluate.evaluate_all}
    for step in arguments.step or STEPS:
        print(f"[train_demo_models] {step}", flush=True)
        actions[step](arguments)
    return 0
