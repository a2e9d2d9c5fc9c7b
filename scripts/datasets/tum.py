# SPDX-License-Identifier: BSD-3-Clause
"""TUM RGB-D: rgb.txt and depth.txt, or associations.txt; groundtruth.txt; the images they name.

Colour and depth are paired by nearest stamp (--sync-tolerance), each image used once; both get the
colour image's stamp, and the pose is interpolated to it. Depth: 5000 per metre. Intrinsics hold for
640x480: freiburg3's own (its images are rectified), else ROS's default (525, 525, 319.5, 239.5), as
the benchmark recommends for its pre-registered images.
"""
import bisect
import os
import re

import numpy as np

from .conventions import find_fault
from .frames import RATE, BrokenFile, Camera, DatasetError, Frame, LeftOut, Sequence
from .text import data_lines, parse_seconds_ns
from .trajectory import read_trajectory

NAME = "tum"
LOOKS_FOR = "rgb.txt and depth.txt (or associations.txt), groundtruth.txt (or --trajectory)"
ROS_DEFAULT = Camera(525.0, 525.0, 319.5, 239.5, "ROS's default, as the benchmark recommends",
                     (640, 480))
FREIBURG3 = Camera(535.4, 539.2, 320.1, 247.6, "the benchmark's calibration of freiburg3",
                   (640, 480))
ASSOCIATIONS = ("associations.txt", "association.txt", "associate.txt", "associated.txt",
                "assoc.txt")
UNITS_PER_M = 5000.0
# Stamps that are all whole, below the first and mostly no further apart than the second are frame
# numbers.
MAX_FRAME_NUMBER = 1000000
MAX_NUMBER_STEP = 10


def find_absent(folder, has_trajectory):
    """What of the layout the folder lacks; empty: it has it."""
    associations = find_associations(folder)
    lists = [(name, 2) for name in ("rgb.txt", "depth.txt")]
    if associations and not all(os.path.exists(os.path.join(folder, name)) for name, _ in lists):
        lists = [(os.path.basename(associations), 4)]
    absent = [f"{name} with stamps and file names" for name, words in lists
              if not is_list(os.path.join(folder, name), words)]
    if not has_trajectory and not os.path.exists(os.path.join(folder, "groundtruth.txt")):
        absent.append("groundtruth.txt")
    return absent


def is_list(path, num_words):
    """True where one of the first lines is a stamp with a name, `num_words` words in all."""
    try:
        lines = [line.replace(",", " ").split() for _, line in data_lines(path)[:5]]
    except BrokenFile:
        return False
    return any(len(words) >= num_words and re.fullmatch(r"[\d.eE+-]+", words[0]) for words in lines)


def find_associations(folder):
    paths = (os.path.join(folder, name) for name in ASSOCIATIONS)
    return next(filter(os.path.exists, paths), None)


def read(folder, settings):
    pairs, left_out, source = read_pairs(folder, settings)
    trajectory = settings.trajectory or read_trajectory(os.path.join(folder, "groundtruth.txt"),
                                                        settings.broken)
    frames, faults = [], {}
    for index, (stamp_ns, color, depth) in enumerate(pairs):
        T = trajectory.pose_at(stamp_ns)
        fault = (f"no valid pose within {os.path.basename(trajectory.path)}'s time" if T is None
                 else find_fault(T))
        if fault:
            faults[fault] = faults.get(fault, 0) + 1
        else:
            frames.append(Frame(index, stamp_ns, color, depth, T))
    if not frames:
        trajectory.require_overlap([pair[0] for pair in pairs])
    left_out += [LeftOut(count, "frames", fault) for fault, count in faults.items()]
    return spread_frame_numbers(
        Sequence(NAME, find_camera(folder), None, UNITS_PER_M, frames, len(pairs), left_out,
                 source), settings.rate_hz)


def find_camera(folder):
    name = os.path.basename(os.path.abspath(folder))
    return FREIBURG3 if re.search(r"(freiburg|fr)3(?!\d)", name) else ROS_DEFAULT


def read_pairs(folder, settings):
    """([(colour's stamp in ns, colour, depth)] ascending, what was left out, the stamps' file)."""
    lists = [os.path.join(folder, name) for name in ("rgb.txt", "depth.txt")]
    if not all(map(os.path.exists, lists)) and find_associations(folder):
        path = find_associations(folder)
        return read_associations(path, settings.broken), [], path
    colors, depths = (read_list(path, settings.broken) for path in lists)
    max_gap_ns = round(settings.sync_tolerance_s * 1e9)
    pairs = associate([c[0] for c in colors], [d[0] for d in depths], max_gap_ns)
    used = [{pair[k] for pair in pairs} for k in (0, 1)]
    alone = [[entry[0] for k, entry in enumerate(entries) if k not in used[side]]
             for side, entries in enumerate((colors, depths))]
    why = describe_gap(alone[0], [d[0] for d in depths], settings.sync_tolerance_s)
    if not pairs:
        raise DatasetError(f"{lists[0]}, {lists[1]}: no pair of stamps within "
                           f"{settings.sync_tolerance_s:g} s{why}, expected pairs")
    left_out = [LeftOut(len(alone[0]), "colour images", f"no depth image of their own within "
                        f"{settings.sync_tolerance_s:g} s{why}"),
                LeftOut(len(alone[1]), "depth images", "no colour image of their own within "
                        f"{settings.sync_tolerance_s:g} s")]
    return ([(colors[i][0], colors[i][1], depths[j][1]) for i, j in pairs],
            [entry for entry in left_out if entry.count], lists[0])


def describe_gap(colors_ns, depths_ns, tolerance_s):
    """The smallest distance of an unpaired colour stamp to any depth stamp beyond the tolerance."""
    gaps_s = [min((abs(stamp - depths_ns[k]) for k in near(depths_ns, stamp)), default=0) / 1e9
              for stamp in colors_ns]
    gaps_s = [gap for gap in gaps_s if gap > tolerance_s]
    if not gaps_s:
        return ""
    advice = (f", --sync-tolerance {float(f'{min(gaps_s) * 1.05:.2g}'):g} pairs them"
              if min(gaps_s) < 0.2 else ": the lists are of different times or clocks")
    return f" (smallest distance found: {min(gaps_s):.6g} s{advice})"


def near(stamps_ns, stamp):
    """Indices of the neighbours of a stamp in an ascending list."""
    after = bisect.bisect_left(stamps_ns, stamp)
    return [k for k in (after - 1, after) if 0 <= k < len(stamps_ns)]


def read_list(path, broken):
    """[(stamp in ns, path)], ascending."""
    entries = []
    for number, line in data_lines(path):
        try:
            words = line.replace(",", " ").split(maxsplit=1)
            if len(words) != 2:
                raise BrokenFile(f"{path}:{number}: '{line}', expected a stamp and a file name")
            entries.append((parse_seconds_ns(words[0], f"{path}:{number}"),
                            resolve(path, words[1])))
        except BrokenFile as error:
            broken.add(error)
    return sorted(entries)


def read_associations(path, broken):
    """[(colour's stamp in ns, colour, depth)] of lines `stamp name stamp name`, either order."""
    pairs = []
    for number, line in data_lines(path):
        try:
            pairs.append(parse_association(path, number, line.replace(",", " ").split()))
        except BrokenFile as error:
            broken.add(error)
    if not pairs:
        raise DatasetError(f"{path}: no pair, expected lines of stamp, colour, stamp, depth")
    return sorted(pairs)


def parse_association(path, number, words):
    place = f"{path}:{number}"
    if len(words) != 4:
        raise BrokenFile(f"{place}: {len(words)} words, expected 4: stamp, colour, stamp, depth")
    is_depth = [bool(re.search("depth", name, re.IGNORECASE)) for name in (words[1], words[3])]
    if is_depth[0] == is_depth[1]:
        raise BrokenFile(f"{place}: '{words[1]}' and '{words[3]}', expected one of the two names "
                         "to hold 'depth'")
    color, depth = (2, 0) if is_depth[0] else (0, 2)
    return (parse_seconds_ns(words[color], place), resolve(path, words[color + 1]),
            resolve(path, words[depth + 1]))


def resolve(path, name):
    """A file named in a list, relative to the list's folder."""
    return os.path.join(os.path.dirname(path), name.strip().replace("\\", "/"))


def spread_frame_numbers(sequence, rate_hz):
    """ICL-NUIM's lists have frame numbers in place of seconds: such frames follow --rate."""
    stamps_s = np.array([frame.stamp_ns for frame in sequence.frames]) / 1e9
    if (len(stamps_s) < 3 or np.any(stamps_s % 1.0) or stamps_s[-1] > MAX_FRAME_NUMBER
            or np.median(np.diff(stamps_s)) > MAX_NUMBER_STEP):
        return sequence
    frames = [frame._replace(stamp_ns=round(frame.stamp_ns / rate_hz)) for frame in sequence.frames]
    note = f"stamps are small whole numbers: taken as frame numbers at {rate_hz:g} Hz (--rate)"
    return sequence._replace(frames=frames, stamps_source=RATE, notes=(note,))


def associate(first_ns, second_ns, max_gap_ns):
    """Greedy pairs (i, j) of nearest stamps, every index at most once, ascending by i."""
    candidates = []
    for i, stamp in enumerate(first_ns):
        low = bisect.bisect_left(second_ns, stamp - max_gap_ns)
        high = bisect.bisect_right(second_ns, stamp + max_gap_ns)
        candidates += [(abs(second_ns[j] - stamp), i, j) for j in range(low, high)]
    used_first, used_second, pairs = set(), set(), []
    for _, i, j in sorted(candidates):
        if i not in used_first and j not in used_second:
            used_first.add(i)
            used_second.add(j)
            pairs.append((i, j))
    return sorted(pairs)
