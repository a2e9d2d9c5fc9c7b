# SPDX-License-Identifier: BSD-3-Clause
"""Unit quaternions (x, y, z, w) and rotation matrices."""
import numpy as np


def from_quaternion(q):
    """Rotation matrix; NaN for a zero or non-finite quaternion."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y, z, w = np.asarray(q, dtype=float) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def to_quaternion(R):
    """Of the rotation nearest to R, w >= 0: the eigenvector of Bar-Itzhack's symmetric matrix."""
    K = np.array([
        [R[0, 0] - R[1, 1] - R[2, 2], 0.0, 0.0, 0.0],
        [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0.0, 0.0],
        [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0.0],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]]])
    q = np.linalg.eigh(K, UPLO="L")[1][:, -1]
    return q if q[3] >= 0.0 else -q


def slerp(q0, q1, share):
    """The rotation `share` of the shorter way from q0 to q1; NaN where one is 0 or not finite."""
    with np.errstate(invalid="ignore"):
        q0, q1 = q0 / np.linalg.norm(q0), q1 / np.linalg.norm(q1)
    cosine = float(np.dot(q0, q1))
    if cosine < 0.0:
        q1, cosine = -q1, -cosine
    if cosine > 0.9995:
        return (1.0 - share) * q0 + share * q1
    angle_rad = np.arccos(cosine)
    weights = np.sin([(1.0 - share) * angle_rad, share * angle_rad]) / np.sin(angle_rad)
    return weights[0] * q0 + weights[1] * q1
