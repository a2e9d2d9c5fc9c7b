# SPDX-License-Identifier: BSD-3-Clause
"""Replica as NICE-SLAM renders it: results/frameN.jpg, results/depthN.png, traj.txt.

traj.txt: one row-major 4x4 camera-to-world matrix per line, optical frame; line 1 is frame 0.
`cam_params.json` in the folder or the one above it ({"camera": {w, h, fx, fy, cx, cy, scale}}),
else the values NICE-SLAM renders with: 600, 600, 599.5, 339.5 for 1200x680 and 6553.5 units per
metre.
"""
import json
import os

from .calibration import find_calibration
from .frames import BrokenFile, Camera, DatasetError, Sequence
from .intrinsics import require_finite
from .numbered import (COLOR_SUFFIXES, DEPTH_SUFFIXES, NumberedFiles, build_frames, list_numbered)
from .text import data_lines, parse_pose, read_text

NAME = "replica"
LOOKS_FOR = "results/frameN.jpg, results/depthN.png, traj.txt (16 numbers a line)"
NICE_SLAM = Camera(600.0, 600.0, 599.5, 339.5, "NICE-SLAM's published values", (1200, 680))
UNITS_PER_M = 6553.5


def find_absent(folder, has_trajectory):
    """What of the layout the folder lacks; empty: it has it."""
    colors, depths = list_images(folder)
    absent = [name for name, files in (("results/frameN.jpg|png", colors),
                                       ("results/depthN.png", depths)) if not files]
    path = os.path.join(folder, "traj.txt")
    if not has_trajectory and not os.path.exists(path):
        absent.append("traj.txt")
    return absent


def list_images(folder):
    results = os.path.join(folder, "results")
    return (list_numbered(results, "frame", COLOR_SUFFIXES),
            list_numbered(results, "depth", DEPTH_SUFFIXES))


def read(folder, settings):
    colors, depths = list_images(folder)
    numbers = sorted(set(colors) | set(depths))
    poses = {} if settings.trajectory else read_trajectory(os.path.join(folder, "traj.txt"),
                                                           numbers, settings.broken)
    labels = list_numbered(os.path.join(folder, "results"), "labels", (".png",))
    files = NumberedFiles(colors, depths, poses, labels)
    frames, num_total, left_out, stamps = build_frames(folder, files, settings)
    camera, units_per_m = read_camera(folder)
    return Sequence(NAME, camera, None, units_per_m, frames, num_total, left_out,
                    stamps)


def read_trajectory(path, numbers, broken):
    """{frame number: 4x4, None where the line is broken}."""
    poses = []
    for line_number, line in data_lines(path):
        try:
            poses.append(parse_pose(line, f"{path}:{line_number}"))
        except BrokenFile as error:
            broken.add(error)
            poses.append(None)
    return assign_lines(path, poses, numbers)


def assign_lines(path, poses, numbers):
    """Line k is frame k - 1, as it was rendered; a folder whose numbers go further, but that has a
    line for each image (numbered from 1, or thinned out), is taken in order."""
    if numbers and numbers[-1] < len(poses):
        return dict(enumerate(poses))
    if len(poses) == len(numbers):
        return dict(zip(numbers, poses))
    raise DatasetError(f"{path}: {len(poses)} poses for {len(numbers)} frames with numbers from "
                       f"{numbers[0]} to {numbers[-1]}, expected a line for every number from 0 or "
                       "one for each frame")


def read_camera(folder):
    for place in (folder, os.path.dirname(os.path.abspath(folder))):
        path = os.path.join(place, "cam_params.json")
        if os.path.exists(path):
            return parse_camera(path)
    return NICE_SLAM, UNITS_PER_M


def parse_camera(path):
    text = read_text(path)
    camera = find_calibration(text, path)
    try:
        units_per_m = float(json.loads(text)["camera"]["scale"])
    except (ValueError, KeyError, TypeError) as error:
        raise DatasetError(f"{path}: {error!r}, expected camera: fx, fy, cx, cy, scale")
    if camera is None or not units_per_m > 0.0:
        raise DatasetError(f"{path}: camera {camera}, scale {units_per_m}, expected camera: fx, "
                           "fy, cx, cy, scale")
    return require_finite(camera), units_per_m
