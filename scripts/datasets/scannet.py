# SPDX-License-Identifier: BSD-3-Clause
"""ScanNet as its SensReader exports it: color/N.jpg, depth/N.png, pose/N.txt, intrinsic/*.txt.

Poses and intrinsics are 4x4, poses camera to world; frames that lost tracking have -inf. Colour and
depth differ in size (1296x968, 640x480) and have intrinsics of their own: intrinsic_color.txt and
intrinsic_depth.txt in intrinsic/ or the folder itself, also as intrinsics_*; else `_info.txt` or
the scene's <scene>.txt. Depth in millimetres. The folders may be called rgb/ and poses/.
"""
import os

import numpy as np

from . import sens_info
from .frames import BrokenFile, Sequence
from .intrinsics import read_camera
from .numbered import (COLOR_SUFFIXES, DEPTH_SUFFIXES, NumberedFiles, build_frames, list_numbered,
                       read_poses)
from .text import read_pose

NAME = "scannet"
LOOKS_FOR = "color/N.jpg, depth/N.png, pose/N.txt (4x4), intrinsic/intrinsic_color.txt"
COLOR_FOLDERS = ("color", "rgb")
POSE_FOLDERS = ("pose", "poses")
LABEL_FOLDERS = ("labels", "instance-filt", "instance")
INTRINSIC_FOLDERS = ("intrinsic", "intrinsics", "")
UNITS_PER_M = 1000.0


def find_absent(folder, has_trajectory):
    """What of the layout the folder lacks; empty: it has it."""
    colors, depths, poses = list_files(folder)
    has_stamps = os.path.exists(os.path.join(folder, "timestamps.txt"))
    absent = [name for name, files in (("color/N.jpg|png", colors), ("depth/N.png", depths),
                                       ("pose/N.txt", poses or (has_trajectory and has_stamps)))
              if not files]
    if not absent and not set(colors) & set(depths):
        absent.append("colour and depth of the same number")
    if not absent and not has_trajectory and not any(map(is_pose, list(poses.values())[:5])):
        absent.append("pose/N.txt with 16 numbers")
    return absent


def is_pose(path):
    try:
        read_pose(path)
    except BrokenFile:
        return False
    return True


def list_files(folder):
    return (list_first(folder, COLOR_FOLDERS, COLOR_SUFFIXES),
            list_first(folder, ("depth",), DEPTH_SUFFIXES),
            list_first(folder, POSE_FOLDERS, (".txt",)))


def list_first(folder, names, suffixes):
    """Numbered files of the first of some folders that has any."""
    listed = (list_numbered(os.path.join(folder, name), "", suffixes) for name in names)
    return next(filter(None, listed), {})


def read(folder, settings):
    colors, depths, poses = list_files(folder)
    files = NumberedFiles(colors, depths,
                          {} if settings.trajectory else read_poses(poses, settings.broken),
                          list_first(folder, LABEL_FOLDERS, (".png",)))
    frames, num_total, left_out, stamps = build_frames(folder, files, settings)
    info = sens_info.find_info(folder) or sens_info.SensInfo(None, None, UNITS_PER_M)
    return Sequence(NAME, find_camera(folder, "color") or info.color,
                    find_camera(folder, "depth") or info.depth, info.depth_units_per_m, frames,
                    num_total, left_out, stamps, describe_extrinsics(folder))


def find_camera(folder, name):
    path = find_file(folder, f"intrinsic_{name}.txt", f"intrinsics_{name}.txt")
    return read_camera(path) if path else None


def find_file(folder, *names):
    for place in INTRINSIC_FOLDERS:
        for name in names:
            path = os.path.join(folder, place, name)
            if os.path.exists(path):
                return path
    return None


def describe_extrinsics(folder):
    """A note where colour and depth do not look from the same point: they are not registered."""
    paths = [find_file(folder, f"extrinsic_{name}.txt") for name in ("color", "depth")]
    if not all(paths):
        return ()
    T_color, T_depth = map(read_pose, paths)
    if not np.isfinite([T_color, T_depth]).all() or np.allclose(T_color, T_depth, atol=1e-3):
        return ()
    distance_m = np.linalg.norm(T_color[:3, 3] - T_depth[:3, 3])
    return (f"warning: {paths[0]} and {paths[1]} differ (by {distance_m:.3f} m): depth is taken as "
            "registered to colour all the same",)
