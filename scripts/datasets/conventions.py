# SPDX-License-Identifier: BSD-3-Clause
"""What poses mean: the axes of the camera, the direction of the transform, the unit of length."""
from typing import NamedTuple

import numpy as np

# T_axes_optical: coordinates in the optical frame (x right, y down, z forward) -> in these axes;
# opengl: x right, y up, z backward; body: x forward, y left, z up. The names, and the others that
# they go by, are those of the parameter input/camera_axes.
T_AXES_OPTICAL = {
    "optical": np.eye(4),
    "opengl": np.diag([1.0, -1.0, -1.0, 1.0]),
    "body": np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]),
}
AXES_NAMES = {"optical": "optical", "opengl": "opengl", "body": "body", "opencv": "optical",
              "flu": "body", "ros": "body"}
DIRECTIONS = ("camera-to-world", "world-to-camera")


class PoseConvention(NamedTuple):
    axes: str = "optical"
    direction: str = "camera-to-world"
    scale_m: float = 1.0  # metres per unit of the translations

    def to_camera_to_world(self, T):
        """T_world_camera (optical frame, metres) of a pose as the folder gives it."""
        T = np.array(T, dtype=float)
        T[:3, 3] *= self.scale_m
        if self.direction == "world-to-camera":
            T = np.linalg.inv(T)
        return T @ T_AXES_OPTICAL[self.axes]


def find_fault(T):
    """Why a 4x4 is no pose; None for one whose upper left block is a rotation within 1 %."""
    if not np.all(np.isfinite(T)) or not np.any(T[:3, :3]):
        return "no valid pose (NaN, infinite or zero: tracking was lost)"
    R = T[:3, :3]
    if not np.allclose(R @ R.T, np.eye(3), atol=1e-2):
        return "the pose's upper left 3x3 block is not a rotation (scaled or sheared)"
    if np.linalg.det(R) < 0.0:
        return "the pose mirrors (determinant -1: left-handed axes)"
    return None


def is_rigid(T):
    return find_fault(T) is None
