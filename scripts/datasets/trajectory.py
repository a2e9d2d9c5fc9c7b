# SPDX-License-Identifier: BSD-3-Clause
"""TUM trajectories: lines of `stamp tx ty tz qx qy qz qw`, seconds and metres."""
import bisect
from typing import List, NamedTuple, Tuple

import numpy as np

from .frames import BrokenFile, DatasetError
from .rotation import from_quaternion, slerp
from .text import data_lines, parse_floats, parse_seconds_ns

MAX_POSE_GAP_NS = 500000000
MAX_QUATERNION_ERROR = 0.05


class Trajectory(NamedTuple):
    path: str
    stamps_ns: List[int]  # ascending
    poses: List[Tuple[np.ndarray, np.ndarray]]  # translation, quaternion xyzw

    def pose_at(self, stamp_ns):
        """4x4, as the file gives it (not checked); None outside the file or in a gap of it."""
        return interpolate(self.stamps_ns, self.poses, stamp_ns)

    def require_overlap(self, stamps_ns):
        """Raises where no stamp lies within the trajectory: other clocks, other recordings."""
        if any(self.stamps_ns[0] <= stamp <= self.stamps_ns[-1] for stamp in stamps_ns):
            return
        raise DatasetError(
            f"{self.path}: poses from {self.stamps_ns[0] / 1e9:.3f} s to "
            f"{self.stamps_ns[-1] / 1e9:.3f} s, images from {min(stamps_ns) / 1e9:.3f} s to "
            f"{max(stamps_ns) / 1e9:.3f} s, expected a trajectory over the images' time")


def read_trajectory(path, broken):
    rows = []
    for number, line in data_lines(path):
        try:
            rows.append(parse_line(line, f"{path}:{number}"))
        except BrokenFile as error:
            broken.add(error)
    if not rows:
        raise DatasetError(f"{path}: no pose, expected lines of stamp tx ty tz qx qy qz qw")
    rows.sort(key=lambda row: row[0])
    return Trajectory(path, [row[0] for row in rows], [row[1:] for row in rows])


def parse_line(line, place):
    words = line.replace(",", " ").split()
    if len(words) != 8:
        raise BrokenFile(f"{place}: {len(words)} numbers, expected 8: stamp tx ty tz qx qy qz qw")
    stamp_ns = parse_seconds_ns(words[0], place)
    values = np.array(parse_floats(" ".join(words[1:]), place))
    length = np.linalg.norm(values[3:])
    if abs(length - 1.0) > MAX_QUATERNION_ERROR and length > 0.0:
        raise BrokenFile(f"{place}: quaternion of length {length:.3g}, expected 1 (columns: stamp "
                         "tx ty tz qx qy qz qw)")
    return stamp_ns, values[:3], values[3:]


def interpolate(stamps_ns, poses, stamp_ns):
    """Pose at a stamp; None outside the trajectory or in a gap of more than 0.5 s."""
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


def to_matrix(translation, quaternion):
    T = np.eye(4)
    T[:3, :3] = from_quaternion(quaternion)
    T[:3, 3] = translation
    return T
