# SPDX-License-Identifier: BSD-3-Clause
"""Steps of the training, in the order in which they run; each can be run alone."""
import argparse
import multiprocessing
import os
import subprocess
from pathlib import Path

import cv2
import torch
from torch import distributed

from . import data, encoder_training, segmenter_training

ROOT = Path(__file__).resolve().parent.parent.parent
STEPS = ("render", "cache", "train_encoder", "train_segmenter", "export", "evaluate")
NUM_PROCESSES = 2  # of each training; results depend on it
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
    parser.add_argument("--segmenter-steps", type=int, default=6600)
    parser.add_argument("--encoder-steps", type=int, default=4500)
    parser.add_argument("--limit-minutes", type=float,
                        help="of each training; it then ends early, no longer the same for every run")
    parser.add_argument("--resume", action="store_true", help="begin with the checkpoints in --work")
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


def train_one(kind, rank, arguments):
    """One of the two processes that train a network; each has one thread and batches of its own."""
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    distributed.init_process_group("gloo", init_method=f"file://{meeting_point(arguments)}", rank=rank,
                                   world_size=NUM_PROCESSES)
    views, crops = load_training_data(arguments)
    if kind == "segmenter":
        schedule = segmenter_training.Schedule(arguments.segmenter_steps, arguments.limit_minutes)
        segmenter_training.train(views, arguments.work / "segmenter.pt", schedule, arguments.seed,
                                 resume=arguments.resume)
    else:
        schedule = segmenter_training.Schedule(arguments.encoder_steps, arguments.limit_minutes)
        encoder_training.train(crops, arguments.work / "encoder.pt", schedule, arguments.seed,
                               resume=arguments.resume)
    distributed.destroy_process_group()


def meeting_point(arguments):
    return (arguments.work / "processes").resolve()


def train(kind, arguments):
    meeting_point(arguments).unlink(missing_ok=True)
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=train_one, args=(kind, rank, arguments))
                 for rank in range(NUM_PROCESSES)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()
    if any(process.exitcode != 0 for process in processes):
        raise RuntimeError(f"training of the {kind} failed, see above")


def main(description):
    arguments = parse(description)
    arguments.work.mkdir(parents=True, exist_ok=True)
    from . import evaluate, export
    actions = {"render": render, "cache": load_training_data,
               "train_encoder": lambda a: train("encoder", a),
               "train_segmenter": lambda a: train("segmenter", a),
               "export": export.export_all, "evaluate": evaluate.evaluate_all}
    for step in arguments.step or STEPS:
        print(f"[train_demo_models] {step}", flush=True)
        actions[step](arguments)
    return 0
