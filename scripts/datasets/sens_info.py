# SPDX-License-Identifier: BSD-3-Clause
"""`_info.txt` (.sens exporters, 3RScan) and ScanNet's `<scene>.txt`: lines of `key = values`."""
import os
from typing import NamedTuple, Optional

from .frames import BrokenFile, Camera, DatasetError
from .intrinsics import camera_from_numbers, require_finite
from .text import data_lines, parse_floats


class SensInfo(NamedTuple):
    color: Optional[Camera]
    depth: Optional[Camera]
    depth_units_per_m: float


def find_info(folder):
    """Of the folder, else of the scene's own text file beside or above it; None without one."""
    path = os.path.join(folder, "_info.txt")
    if os.path.exists(path):
        return parse_info(path)
    for place in (os.path.abspath(folder), os.path.dirname(os.path.abspath(folder))):
        info = parse_scene(os.path.join(place, os.path.basename(place) + ".txt"))
        if info:
            return info
    return None


def parse_info(path):
    """Keys m_calibration{Color,Depth}Intrinsic (4x4), m_{color,depth}{Width,Height},
    m_depthShift."""
    values = read_values(path)
    cameras = []
    for name in ("Color", "Depth"):
        numbers = values.get(f"m_calibration{name}Intrinsic")
        if not numbers:
            raise DatasetError(f"{path}: no m_calibration{name}Intrinsic, expected a 4x4 matrix")
        cameras.append(camera_from_numbers(numbers, path)._replace(
            size=find_size(values, f"m_{name.lower()}Width", f"m_{name.lower()}Height")))
    shift = values.get("m_depthShift", [1000.0])
    if len(shift) != 1 or not shift[0] > 0.0:
        raise DatasetError(f"{path}: m_depthShift {shift}, expected units per metre")
    return SensInfo(cameras[0], cameras[1], shift[0])


def parse_scene(path):
    """Keys {fx,fy,mx,my}_{color,depth}, {color,depth}{Width,Height}; None for any other file."""
    try:
        values = read_values(path)
    except BrokenFile:
        return None
    cameras = []
    for name in ("color", "depth"):
        numbers = [values.get(f"{key}_{name}", [])[:1] for key in ("fx", "fy", "mx", "my")]
        size = find_size(values, f"{name}Width", f"{name}Height")
        cameras.append(require_finite(Camera(*(n[0] for n in numbers), path, size))
                       if all(numbers) else None)
    return SensInfo(cameras[0], cameras[1], 1000.0) if any(cameras) else None


def read_values(path):
    """{key: numbers}; keys whose values are no numbers are left out."""
    values = {}
    for number, line in data_lines(path):
        key, _, rest = line.partition("=")
        try:
            values[key.strip()] = parse_floats(rest, f"{path}:{number}")
        except BrokenFile:
            continue
    return values


def find_size(values, width, height):
    if values.get(width) and values.get(height):
        return int(values[width][0]), int(values[height][0])
    return None
