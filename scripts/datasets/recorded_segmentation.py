# SPDX-License-Identifier: BSD-3-Clause
"""Label images with ready embeddings, beside a sequence of any layout that has label images.

embeddings.npz: instance_ids (I), embeddings (I x D), task_names (T), task_embeddings (T x D).
image_embeddings.npz (optional): frame_embeddings (one row per frame of the folder, in order),
room_names (R), room_embeddings (R x D).
"""
import json
import os
import zipfile

import numpy as np

from .frames import DatasetError


class RecordedSegmentation:
    """Segments 1..S of a frame = the instance ids in its label image, ascending."""

    def __init__(self, folder, num_frames):
        tables = load_tables(os.path.join(folder, "embeddings.npz"), INSTANCE_KEYS)
        self.rows = {int(i): row for i, row in zip(tables["instance_ids"], tables["embeddings"])}
        self.size = tables["embeddings"].shape[1]
        self.tasks = list(zip(tables["task_names"].tolist(), tables["task_embeddings"]))
        self.rooms, self.frame_embeddings = [], None
        path = os.path.join(folder, "image_embeddings.npz")
        if os.path.exists(path):
            images = load_tables(path, IMAGE_KEYS)
            self.rooms = list(zip(images["room_names"].tolist(), images["room_embeddings"]))
            self.frame_embeddings = images["frame_embeddings"]
            require_shape(path, "frame_embeddings", self.frame_embeddings, (num_frames, self.size))

    def segment(self, instances, index):
        """(labels renumbered 1..S, S x D embeddings: zeros for ids without one, image's D or 0) of
        an H x W image of instance ids; index: the frame's position in the whole sequence."""
        ids, inverse = np.unique(instances, return_inverse=True)
        labels = inverse.reshape(instances.shape) + (ids[0] != 0)
        zeros = np.zeros(self.size, np.float32)
        embeddings = [self.rows.get(int(i), zeros) for i in ids if i != 0]
        image = [] if self.frame_embeddings is None else self.frame_embeddings[index]
        return (labels.astype(np.uint16),
                np.array(embeddings, np.float32).reshape(-1, self.size), np.float32(image))


INSTANCE_KEYS = ("instance_ids", "embeddings", "task_names", "task_embeddings")
IMAGE_KEYS = ("frame_embeddings", "room_names", "room_embeddings")


def is_present(folder):
    return os.path.exists(os.path.join(folder, "embeddings.npz"))


def load_tables(path, keys):
    """Arrays of an .npz; names and rows in pairs (keys 0-1, 2-3 or 1-2) have the same length."""
    try:
        with np.load(path, allow_pickle=False) as file:
            tables = {key: file[key] for key in keys}
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise DatasetError(f"{path}: {error}, expected an .npz with the arrays {', '.join(keys)}")
    for name in ("instance_ids", "task_names", "room_names"):
        if name in tables:
            rows = {"instance_ids": "embeddings", "task_names": "task_embeddings",
                    "room_names": "room_embeddings"}[name]
            require_shape(path, rows, tables[rows], (len(tables[name]), None))
    return tables


def require_shape(path, name, array, expected):
    fits = array.ndim == len(expected) and all(
        want is None or have == want for have, want in zip(array.shape, expected))
    if not fits or not np.all(np.isfinite(array)):
        raise DatasetError(f"{path}: {name} has shape {array.shape}, expected finite {expected}")


def write_task_files(files, output, segmentation):
    """Adds OUTPUT.object_tasks.yaml and OUTPUT.place_tasks.yaml (without .bag) to the files."""
    stem = output[: -len(".bag")] if output.endswith(".bag") else output
    for kind, tasks in (("object", segmentation.tasks), ("place", segmentation.rooms)):
        if tasks:
            write_tasks(files.add(f"{stem}.{kind}_tasks.yaml"), tasks)


def write_tasks(path, tasks):
    """`tasks: [{name, embedding}]`."""
    with open(path, "w") as file:
        file.write("tasks:\n")
        for name, embedding in tasks:
            numbers = ", ".join(f"{value:.8g}" for value in embedding)
            file.write(f"  - name: {json.dumps(name)}\n    embedding: [{numbers}]\n")
