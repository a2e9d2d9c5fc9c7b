# SPDX-License-Identifier: BSD-3-Clause
"""Turns a recording's world so that its z axis points up, as places on floors need it."""
import numpy as np

from .frames import DatasetError

# Least mean squared component of the cameras' x axes along the second of their two horizontal axes:
# about 6 degrees of turning. With less, up and the viewing direction cannot be told apart.
MIN_SPREAD = 0.01


def find_level_up(poses):
    """The direction to which the x axes of all cameras are most nearly perpendicular: up, for a camera
    held level (pitch is free, roll averages out). poses: N 4x4 matrices, camera to world."""
    x_axes = np.array([T[:3, 0] for T in poses])
    spread, directions = np.linalg.eigh(x_axes.T @ x_axes / len(x_axes))
    if spread[1] < MIN_SPREAD:
        raise DatasetError(f"--world-up level: the camera turns too little ({spread[1]:.2g}, expected "
                           f"at least {MIN_SPREAD}) to tell what is up; give the direction as X,Y,Z")
    up = directions[:, 0]
    cameras_up = -np.mean([T[:3, 1] for T in poses], axis=0)
    return up if up @ cameras_up > 0.0 else -up


def parse_up(text):
    """'level' or three numbers; raises ValueError."""
    if text == "level":
        return text
    up = np.array([float(word) for word in text.split(",")])
    if up.shape != (3,) or not np.isfinite(up).all() or np.linalg.norm(up) < 1e-9:
        raise ValueError(f"'{text}', expected 'level' or a direction X,Y,Z that is not zero")
    return up / np.linalg.norm(up)


def find_rotation(up):
    """The smallest rotation that takes the unit vector `up` to z."""
    z = np.array([0.0, 0.0, 1.0])
    if up @ z < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.cross(up, z)  # of length sin; Rodrigues' formula without the angle
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + up @ z)


def turn_world(sequence, up):
    """The sequence with all poses in a world whose z axis is `up` ('level': find it)."""
    if isinstance(up, str):
        up = find_level_up([frame.T_world_camera for frame in sequence.frames])
    T_level_world = np.eye(4)
    T_level_world[:3, :3] = find_rotation(up)
    return sequence._replace(frames=[
        frame._replace(T_world_camera=T_level_world @ frame.T_world_camera)
        for frame in sequence.frames])
