# SPDX-License-Identifier: BSD-3-Clause
"""Folders whose files carry frame numbers: what belongs together has the same number.

Numbers count as numbers (9 before 10, 7 is 000007), and time follows them: frame N lies N / rate
after frame 0, so that a folder with every tenth frame keeps its speed.
"""
import collections
import os
import re
from typing import Dict, NamedTuple, Optional

import numpy as np

from .conventions import find_fault
from .frames import RATE, BrokenFile, DatasetError, Frame, LeftOut
from .text import data_lines, parse_seconds_ns, read_pose

COLOR_SUFFIXES = (".jpg", ".jpeg", ".png")
# JPEG cannot hold depth: listed to be refused by its type.
DEPTH_SUFFIXES = (".png", ".pgm", ".tiff", ".tif", ".jpg", ".jpeg")
# Numbers that are further apart than this on average are stamps of some unit, not frame numbers.
MAX_MEAN_STEP = 1000


class NumberedFiles(NamedTuple):
    colors: Dict[int, str]
    depths: Dict[int, str]
    poses: Dict[int, Optional[np.ndarray]]  # 4x4 as the folder gives it; None: broken
    labels: Dict[int, str]


def list_numbered(folder, prefix, suffixes):
    """{number: path} of the files PREFIX digits SUFFIX; of two suffixes the first given wins."""
    pattern = re.compile(re.escape(prefix) + r"(\d+)("
                         + "|".join(re.escape(suffix) for suffix in suffixes) + ")", re.IGNORECASE)
    found = {}
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        match = pattern.fullmatch(name)
        if match:
            number, rank = int(match.group(1)), suffixes.index(match.group(2).lower())
            if number in found and found[number][0] == rank:
                raise DatasetError(f"{folder}: {os.path.basename(found[number][1])} and {name} "
                                   "have the same number, expected one file for each")
            if number not in found or rank < found[number][0]:
                found[number] = (rank, os.path.join(folder, name))
    return {number: path for number, (_, path) in sorted(found.items())}


def read_poses(paths, broken):
    """{number: 4x4, None where the file is broken}."""
    poses = {}
    for number, path in paths.items():
        try:
            poses[number] = read_pose(path)
        except BrokenFile as error:
            broken.add(error)
            poses[number] = None
    return poses


def build_frames(folder, files, settings):
    """(frames, their number before any was left out, what was left out, source of the stamps). A
    frame is a number that has an image."""
    numbers = sorted(set(files.colors) | set(files.depths))
    stamps_ns, stamps_source = read_stamps(folder, numbers, settings)
    frames, reasons = [], collections.Counter()
    for index, number in enumerate(numbers):
        T, reason = find_pose(files, number, stamps_ns[index], settings.trajectory)
        reason = find_absent(files, number) or reason
        if reason:
            reasons[reason] += 1
        else:
            frames.append(Frame(index, stamps_ns[index], files.colors[number],
                                files.depths[number], T, files.labels.get(number)))
    if not frames and settings.trajectory:
        settings.trajectory.require_overlap(stamps_ns)
    left_out = [LeftOut(count, "frames", why) for why, count in reasons.items()]
    spare = len(set(files.poses) - set(numbers))
    if spare:
        left_out.append(LeftOut(spare, "poses", "no image of their number"))
    return frames, len(numbers), left_out, stamps_source


def find_absent(files, number):
    """Which of a frame's images is absent; None for neither."""
    if number not in files.colors:
        return "no colour image of their number"
    return None if number in files.depths else "no depth image of their number"


def find_pose(files, number, stamp_ns, trajectory):
    """(4x4, None) or (None, why there is none)."""
    if trajectory:
        T = trajectory.pose_at(stamp_ns)
        missing = f"no pose at their stamp in {trajectory.path}"
    else:
        T = files.poses.get(number)
        missing = ("the pose is broken" if number in files.poses else "no pose of their number")
    if T is None:
        return None, missing
    fault = find_fault(T)
    return (None, fault) if fault else (T, None)


def read_stamps(folder, numbers, settings):
    """(one stamp for each frame, ns; their source: timestamps.txt, else number and --rate)."""
    path = os.path.join(folder, "timestamps.txt")
    if os.path.exists(path):
        return pick_stamps(path, numbers), path
    if settings.trajectory:
        raise DatasetError(f"--trajectory {settings.trajectory.path}: the images of {folder} have "
                           "no stamps, expected timestamps.txt beside them (one line per frame, "
                           "seconds)")
    steps = [number - numbers[0] for number in numbers]
    if steps and steps[-1] > MAX_MEAN_STEP * len(steps):
        steps = range(len(numbers))
    return [round(step * 1e9 / settings.rate_hz) for step in steps], RATE


def pick_stamps(path, numbers):
    """Lines are the folder's frames in order or, where there are more, frames 0, 1, ..."""
    lines = data_lines(path)
    if len(lines) != len(numbers):
        if not numbers or len(lines) <= numbers[-1]:
            raise DatasetError(f"{path}: {len(lines)} lines, expected one per frame, "
                               f"{len(numbers)}")
        lines = [lines[number] for number in numbers]
    return [parse_seconds_ns(line, f"{path}:{number}") for number, line in lines]


def keep_rising(frames):
    """(frames whose stamps rise, what was left out); raises where most do not."""
    kept = []
    for frame in frames:
        if not kept or frame.stamp_ns > kept[-1].stamp_ns:
            kept.append(frame)
    dropped = len(frames) - len(kept)
    if dropped > len(frames) // 2:
        raise DatasetError(f"{frames[0].color_path} and later: {dropped} of {len(frames)} frames "
                           "have a stamp that is not after the one before "
                           f"({frames[0].stamp_ns / 1e9:.3f} s, ...), expected rising stamps")
    return kept, [LeftOut(dropped, "frames", "stamp not after the one before")] if dropped else []
