# SPDX-License-Identifier: BSD-3-Clause
"""Recordings with a known truth. Each is a bag with true segments, made once and kept."""
import collections
import os

# tasks: file with an embedding per task. truth: what evaluate_scene_graph takes.
# world: heading in the report; two lists of one world have two. rooms: the true ones. labels: points
# with the number of a task each. mesh: the true surfaces. Rooms, labels and mesh need not exist.
TaskList = collections.namedtuple("TaskList", "world tasks truth labels")
Recording = collections.namedtuple("Recording", "name bag place_tasks rooms mesh lists")

LEVELS = ("none", "clip_like", "hard")
KINDS = ("apartment", "cubicle", "office", "building")
CAMERA = ["--width", "320", "--height", "240", "--rate", "5"]


def prepare_world(run, folder, kind, seed, duration_s):
    """A generated world of its own for each seed. All but apartments have a second list of tasks,
    about groups of things."""
    name = f"{kind}_{seed}" if duration_s == 0.0 else f"{kind}_{seed}_{duration_s:g}s"
    stem = os.path.join(folder, name)
    if not os.path.exists(stem + ".bag"):
        run(["simulate_apartment", "--world", kind, "--output", stem + ".bag", "--seed", str(seed),
             "--duration", str(duration_s)] + CAMERA)
    truth = stem + ".ground_truth"
    lists = [TaskList(kind, stem + ".object_tasks.yaml", truth, os.path.join(truth, "labels.ply"))]
    if kind != "apartment":
        lists.append(TaskList(f"{kind} (coarse tasks)", stem + ".coarse_tasks.yaml",
                              os.path.join(truth, "coarse_tasks.yaml"),
                              os.path.join(truth, "coarse_labels.ply")))
    return Recording(name, stem + ".bag", stem + ".place_tasks.yaml",
                     os.path.join(truth, "rooms.json"), os.path.join(truth, "mesh.ply"), lists)


def prepare_house(run, folder, source):
    """A rendered house with labels and embeddings, as a folder that dataset_to_bag reads."""
    name = os.path.basename(os.path.normpath(source))
    stem = os.path.join(folder, name)
    if not os.path.exists(stem + ".bag"):
        run(["dataset_to_bag", "--input", source, "--output", stem + ".bag"])
    return Recording(name, stem + ".bag", stem + ".place_tasks.yaml",
                     os.path.join(source, "rooms.json"), os.path.join(source, "scene_mesh.ply"),
                     [TaskList(name, stem + ".object_tasks.yaml", source,
                               os.path.join(source, "labels.ply"))])


def degrade(run, recording, level, seed):
    """The same recording with segments as a network gives them."""
    if level == "none":
        return recording._replace(name=f"{recording.name}/none")
    bag = f"{recording.bag[:-len('.bag')]}.{level}_{seed}.bag"
    if not os.path.exists(bag):
        run(["degrade_segments", "--input", recording.bag, "--output", bag, "--level", level,
             "--seed", str(seed)])
    return recording._replace(name=f"{recording.name}/{level}_{seed}", bag=bag)
