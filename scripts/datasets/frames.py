# SPDX-License-Identifier: BSD-3-Clause
"""The values that readers hand to the bag writer, and the checks that all readers share."""
from decimal import Decimal, InvalidOperation
from typing import List, NamedTuple, Optional

import numpy as np
from PIL import Image


class DatasetError(Exception):
    """Says which file is wrong, what it holds and what was expected."""


class Camera(NamedTuple):
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    source: str  # where the numbers come from, for the user to see


class Frame(NamedTuple):
    index: int  # position in the whole sequence; row of per-frame tables
    stamp_ns: int
    color_path: str
    depth_path: str
    T_world_camera: np.ndarray  # 4x4
    labels_path: Optional[str] = None


class Sequence(NamedTuple):
    layout: str
    camera: Camera
    depth_units_per_m: float
    frames: List[Frame]
    num_total: int  # frames in the folder, before any was skipped
    num_without_pose: int  # frames left out: pose absent, not finite or not a rotation


def parse_seconds_ns(text, path, line):
    """Decimal seconds -> nanoseconds, exactly (a float has 0.2 us left at today's Unix time)."""
    try:
        return int((Decimal(text) * 1000000000).to_integral_value())
    except (InvalidOperation, ValueError, OverflowError):
        raise DatasetError(f"{path}:{line}: '{text}', expected seconds")


def parse_floats(text, path, line, count):
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        raise DatasetError(f"{path}:{line}: '{text.strip()[:60]}', expected {count} numbers")
    if len(values) != count:
        raise DatasetError(f"{path}:{line}: {len(values)} numbers, expected {count}")
    return values


def read_matrix(path, rows, cols):
    """Numbers separated by blanks or commas, `rows` x `cols`."""
    with open(path) as file:
        text = file.read().replace(",", " ")
    return np.array(parse_floats(text, path, 1, rows * cols)).reshape(rows, cols)


def is_rigid(T):
    """True for a finite pose whose upper left block is a rotation within 1 %."""
    if not np.all(np.isfinite(T)):
        return False
    R = T[:3, :3]
    return bool(np.allclose(R @ R.T, np.eye(3), atol=1e-2) and np.linalg.det(R) > 0.0)


def read_color(path):
    """H x W x 3, uint8, RGB."""
    with open_image(path) as image:
        return np.asarray(image.convert("RGB"))


def read_uint16(path):
    """H x W, uint16: depth in the layout's unit, or labels."""
    with open_image(path) as image:
        pixels = np.asarray(image)
    if pixels.ndim != 2 or pixels.min(initial=0) < 0 or pixels.max(initial=0) > 65535:
        raise DatasetError(f"{path}: {pixels.dtype} image of shape {pixels.shape}, "
                           "expected one channel of 16 bits")
    return pixels.astype(np.uint16)


def open_image(path):
    try:
        return Image.open(path)
    except OSError as error:
        raise DatasetError(f"{path}: {error}, expected a readable image")
