# SPDX-License-Identifier: BSD-3-Clause
"""7-Scenes / 3DMatch: frame-N.{color.jpg|png, depth.png|pgm, pose.txt} in one folder.

3RScan and ScanNet's C++ exporter write the same names, and `_info.txt` with both cameras. Depth in
millimetres. Intrinsics: `_info.txt`, else those that 7-Scenes names (585, 585, 320, 240), which
hold for 640x480 only. Lost tracking is written as NaN, -inf or zero poses: those frames are left
out.
"""
from . import sens_info
from .frames import Camera, Sequence
from .numbered import (COLOR_SUFFIXES, DEPTH_SUFFIXES, NumberedFiles, build_frames, list_numbered,
                       read_poses)

NAME = "3dmatch"
LOOKS_FOR = "frame-N.color.jpg, frame-N.depth.png, frame-N.pose.txt"
SEVEN_SCENES = Camera(585.0, 585.0, 320.0, 240.0, "7-Scenes' published values", (640, 480))
UNITS_PER_M = 1000.0


def find_absent(folder, has_trajectory):
    """What of the layout the folder lacks; empty: it has it."""
    colors, depths, poses = list_files(folder)
    absent = [name for name, files in (("frame-N.color.jpg|png", colors),
                                       ("frame-N.depth.png|pgm", depths),
                                       ("frame-N.pose.txt", poses or has_trajectory)) if not files]
    return absent or ([] if set(colors) & set(depths) else ["colour and depth of the same number"])


def list_files(folder):
    return (list_numbered(folder, "frame-", [".color" + suffix for suffix in COLOR_SUFFIXES]),
            list_numbered(folder, "frame-", [".depth" + suffix for suffix in DEPTH_SUFFIXES]),
            list_numbered(folder, "frame-", [".pose.txt"]))


def read(folder, settings):
    colors, depths, poses = list_files(folder)
    files = NumberedFiles(colors, depths,
                          {} if settings.trajectory else read_poses(poses, settings.broken),
                          list_numbered(folder, "frame-", [".labels.png"]))
    frames, num_total, left_out, stamps = build_frames(folder, files, settings)
    info = sens_info.find_info(folder)
    return Sequence(NAME, info.color if info else SEVEN_SCENES, info.depth if info else None,
                    info.depth_units_per_m if info else UNITS_PER_M, frames, num_total, left_out,
                    stamps)
