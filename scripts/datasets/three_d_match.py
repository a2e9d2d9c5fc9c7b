# SPDX-License-Identifier: BSD-3-Clause
"""7-Scenes / 3DMatch: frame-%06d.{color.jpg|png, depth.png, pose.txt} in one folder.

Depth in millimetres. `camera-intrinsics.txt` (3x3) in the folder or the one above it, else the
values that 7-Scenes names (585, 585, 320, 240). `timestamps.txt` (one line per frame, seconds) if
there is one, else --rate. Lost tracking is written as NaN or -inf poses: those frames are skipped.
"""
import glob
import os

import numpy as np

from .frames import Camera, DatasetError, Frame, Sequence, is_rigid, parse_seconds_ns, read_matrix

SEVEN_SCENES = Camera(585.0, 585.0, 320.0, 240.0, "7-Scenes' published values")


def matches(folder):
    return bool(glob.glob(os.path.join(folder, "frame-*.pose.txt")))


def read(folder, rate_hz):
    poses = sorted(glob.glob(os.path.join(folder, "frame-*.pose.txt")))
    stems = [path[: -len(".pose.txt")] for path in poses]
    if not stems:
        raise DatasetError(f"{folder}: no frame-*.pose.txt, expected the 7-Scenes/3DMatch layout")
    stamps_ns = read_stamps(folder, len(stems), rate_hz)
    frames = []
    for index, stem in enumerate(stems):
        T = read_matrix(stem + ".pose.txt", 4, 4)
        if is_rigid(T):
            labels = stem + ".labels.png"
            frames.append(Frame(index, stamps_ns[index], find_color(stem), stem + ".depth.png", T,
                                labels if os.path.exists(labels) else None))
    return Sequence("3dmatch", read_camera(folder), 1000.0, frames, len(stems),
                    len(stems) - len(frames))


def read_stamps(folder, count, rate_hz):
    path = os.path.join(folder, "timestamps.txt")
    if not os.path.exists(path):
        return [round(index * 1e9 / rate_hz) for index in range(count)]
    with open(path) as file:
        lines = [line.strip() for line in file if line.strip()]
    if len(lines) != count:
        raise DatasetError(f"{path}: {len(lines)} lines, expected one per frame, {count}")
    return [parse_seconds_ns(line, path, number) for number, line in enumerate(lines, 1)]


def find_color(stem):
    for ending in (".color.jpg", ".color.png"):
        if os.path.exists(stem + ending):
            return stem + ending
    raise DatasetError(f"{stem}.color.jpg: absent, expected it (or .color.png) beside the pose")


def read_camera(folder):
    for place in (folder, os.path.dirname(os.path.abspath(folder))):
        path = os.path.join(place, "camera-intrinsics.txt")
        if os.path.exists(path):
            return camera_from_matrix(read_matrix(path, 3, 3), path)
    return SEVEN_SCENES


def camera_from_matrix(K, path):
    if not np.all(np.isfinite(K)) or K[0, 0] <= 0.0 or K[1, 1] <= 0.0:
        raise DatasetError(f"{path}: fx {K[0, 0]}, fy {K[1, 1]}, expected positive pixels")
    return Camera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], path)
