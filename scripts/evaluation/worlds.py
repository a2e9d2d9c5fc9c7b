# SPDX-License-Identifier: BSD-3-Clause
"""Recordings with a known truth. Each is a bag with true segments, made once and kept."""
import collections
import os

# truth: what evaluate_scene_graph takes. tasks: file with an embedding per task.
Recording = collections.namedtuple("Recording", "name bag tasks place_tasks truth")

LEVELS = ("none", "clip_like", "hard")
APARTMENT = ["--width", "320", "--height", "240", "--rate", "5"]


def prepare_apartment(run, folder, seed, duration_s):
    """A generated apartment of its own for each seed."""
    name = f"apartment_{seed}" if duration_s == 0.0 else f"apartment_{seed}_{duration_s:g}s"
    stem = os.path.join(folder, name)
    if not os.path.exists(stem + ".bag"):
        run(["simulate_apartment", "--output", stem + ".bag", "--seed", str(seed), "--duration",
             str(duration_s)] + APARTMENT)
    return Recording(name, stem + ".bag", stem + ".object_tasks.yaml",
                     stem + ".place_tasks.yaml", stem + ".ground_truth")


def prepare_house(run, folder, source):
    """A rendered house with labels and embeddings, as a folder that dataset_to_bag reads."""
    name = os.path.basename(os.path.normpath(source))
    stem = os.path.join(folder, name)
    if not os.path.exists(stem + ".bag"):
        run(["dataset_to_bag", "--input", source, "--output", stem + ".bag"])
    return Recording(name, stem + ".bag", stem + ".object_tasks.yaml", stem + ".place_tasks.yaml",
                     source)


def degrade(run, recording, level, seed):
    """The same recording with segments as a network gives them."""
    if level == "none":
        return recording._replace(name=f"{recording.name}/none")
    bag = f"{recording.bag[:-len('.bag')]}.{level}_{seed}.bag"
    if not os.path.exists(bag):
        run(["degrade_segments", "--input", recording.bag, "--output", bag, "--level", level,
             "--seed", str(seed)])
    return recording._replace(name=f"{recording.name}/{level}_{seed}", bag=bag)
