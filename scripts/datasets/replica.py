# SPDX-License-Identifier: BSD-3-Clause
"""Replica as NICE-SLAM renders it: results/frame%06d.jpg, results/depth%06d.png, traj.txt.

traj.txt: one row-major 4x4 camera-to-world matrix per line, optical frame. `cam_params.json` in
the folder or the one above it ({"camera": {fx, fy, cx, cy, scale}}), else the values NICE-SLAM
renders with: 600, 600, 599.5, 339.5 and 6553.5 depth units per metre. Stamps follow --rate.
"""
import glob
import json
import os

import numpy as np

from .frames import Camera, DatasetError, Frame, Sequence, is_rigid, parse_floats

NICE_SLAM = (Camera(600.0, 600.0, 599.5, 339.5, "NICE-SLAM's published values"), 6553.5)


def matches(folder):
    return (os.path.exists(os.path.join(folder, "traj.txt"))
            and os.path.isdir(os.path.join(folder, "results")))


def read(folder, rate_hz):
    colors = sorted(glob.glob(os.path.join(folder, "results", "frame*.jpg"))
                    or glob.glob(os.path.join(folder, "results", "frame*.png")))
    path = os.path.join(folder, "traj.txt")
    poses = read_trajectory(path)
    if len(poses) != len(colors) or not colors:
        raise DatasetError(f"{path}: {len(poses)} poses, expected one per results/frame*.jpg, "
                           f"{len(colors)}")
    frames = []
    for index, (color, T) in enumerate(zip(colors, poses)):
        number = os.path.splitext(os.path.basename(color))[0][len("frame"):]
        depth = os.path.join(folder, "results", f"depth{number}.png")
        if is_rigid(T):
            frames.append(Frame(index, round(index * 1e9 / rate_hz), color, depth, T))
    camera, units_per_m = read_camera(folder)
    return Sequence("replica", camera, units_per_m, frames, len(poses), len(poses) - len(frames))


def read_trajectory(path):
    if not os.path.exists(path):
        raise DatasetError(f"{path}: absent, expected it in Replica's layout")
    with open(path) as file:
        return [np.array(parse_floats(line, path, number, 16)).reshape(4, 4)
                for number, line in enumerate(file, 1) if line.strip()]


def read_camera(folder):
    for place in (folder, os.path.dirname(os.path.abspath(folder))):
        path = os.path.join(place, "cam_params.json")
        if os.path.exists(path):
            return parse_camera(path)
    return NICE_SLAM


def parse_camera(path):
    with open(path) as file:
        try:
            values = json.load(file)["camera"]
            camera = Camera(*(float(values[key]) for key in ("fx", "fy", "cx", "cy")), path)
            units_per_m = float(values["scale"])
        except (ValueError, KeyError, TypeError) as error:
            raise DatasetError(f"{path}: {error!r}, expected camera: fx, fy, cx, cy, scale")
    if min(camera.fx_px, camera.fy_px, units_per_m) <= 0.0:
        raise DatasetError(f"{path}: fx {camera.fx_px}, fy {camera.fy_px}, scale {units_per_m}, "
                           "expected positive numbers")
    return camera, units_per_m
