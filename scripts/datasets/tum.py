# SPDX-License-Identifier: BSD-3-Clause
"""TUM RGB-D: rgb.txt, depth.txt, groundtruth.txt (stamp tx ty tz qx qy qz qw) and the images.

Colour and depth are paired by nearest stamp, at most 0.02 s apart, each image used once; both get
the colour image's stamp, and the pose is interpolated to it. Depth: 5000 per metre. The benchmark
recommends ROS's default intrinsics (525, 525, 319.5, 239.5) for its pre-registered images;
`camera-intrinsics.txt` in the folder overrides them.
"""
import bisect
import os

import numpy as np

from .frames import DatasetError, Frame, Camera, Sequence, is_rigid, parse_floats, parse_seconds_ns
from .frames import read_matrix
from .rotation import from_quaternion, slerp
from .three_d_match import camera_from_matrix

ROS_DEFAULT = Camera(525.0, 525.0, 319.5, 239.5, "ROS's default, as the benchmark recommends")
MAX_PAIR_GAP_NS = 20000000
MAX_POSE_GAP_NS = 500000000


def matches(folder):
    return all(os.path.exists(os.path.join(folder, name))
               for name in ("rgb.txt", "depth.txt", "groundtruth.txt"))


def read(folder, rate_hz):
    del rate_hz  # images carry their own stamps
    colors = read_list(folder, "rgb.txt")
    depths = read_list(folder, "depth.txt")
    stamps_ns, poses = read_ground_truth(os.path.join(folder, "groundtruth.txt"))
    pairs = associate([c[0] for c in colors], [d[0] for d in depths], MAX_PAIR_GAP_NS)
    if not pairs:
        raise DatasetError(f"{folder}: no colour and depth stamps within 0.02 s, expected pairs")
    frames = []
    for index, (i, j) in enumerate(pairs):
        T = interpolate(stamps_ns, poses, colors[i][0])
        if T is not None and is_rigid(T):
            frames.append(Frame(index, colors[i][0], colors[i][1], depths[j][1], T))
    return Sequence("tum", read_camera(folder), 5000.0, frames, len(pairs),
                    len(pairs) - len(frames))


def data_lines(path):
    if not os.path.exists(path):
        raise DatasetError(f"{path}: absent, expected it in the TUM RGB-D layout")
    with open(path) as file:
        for number, line in enumerate(file, 1):
            if line.strip() and not line.startswith("#"):
                yield number, line.strip()


def read_list(folder, name):
    """[(stamp in ns, path)], ascending."""
    path = os.path.join(folder, name)
    entries = []
    for number, line in data_lines(path):
        words = line.split(maxsplit=1)
        if len(words) != 2:
            raise DatasetError(f"{path}:{number}: '{line}', expected a stamp and a file name")
        entries.append((parse_seconds_ns(words[0], path, number), os.path.join(folder, words[1])))
    return sorted(entries)


def read_ground_truth(path):
    """Ascending stamps and their (translation, quaternion xyzw)."""
    rows = []
    for number, line in data_lines(path):
        stamp, _, rest = line.partition(" ")
        values = np.array(parse_floats(rest, path, number, 7))
        rows.append((parse_seconds_ns(stamp, path, number), values[:3], values[3:]))
    rows.sort(key=lambda row: row[0])
    return [row[0] for row in rows], [row[1:] for row in rows]


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


def interpolate(stamps_ns, poses, stamp_ns):
    """Pose at a stamp; None outside the ground truth or in a gap of more than 0.5 s."""
    after = bisect.bisect_left(stamps_ns, stamp_ns)
    if after < len(stamps_ns) and stamps_ns[after] == stamp_ns:
        return to_matrix(*poses[after])
    if after == 0 or after == len(stamps_ns):
        return None
    gap_ns = stamps_ns[after] - stamps_ns[after - 1]
    if gap_ns > MAX_POSE_GAP_NS:
        return None
    share = (stamp_ns - stamps_ns[after - 1]) / gap_ns
    (t0, q0), (t1, q1) = poses[after - 1], poses[after]
    return to_matrix((1.0 - share) * t0 + share * t1, slerp(q0, q1, share))


def to_matrix(translation_m, quaternion):
    T = np.eye(4)
    T[:3, :3] = from_quaternion(quaternion)
    T[:3, 3] = translation_m
    return T


def read_camera(folder):
    path = os.path.join(folder, "camera-intrinsics.txt")
    if os.path.exists(path):
        return camera_from_matrix(read_matrix(path, 3, 3), path)
    return ROS_DEFAULT
