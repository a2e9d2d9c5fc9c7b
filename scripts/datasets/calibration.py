# SPDX-License-Identifier: BSD-3-Clause
"""Intrinsics in YAML or JSON: ROS' camera_info files, OpenCV's, ORB-SLAM's, Open3D's."""
import re

import yaml

from .frames import Camera, DatasetError

DISTORTION_KEYS = ("k1", "k2", "p1", "p2", "k3")


def find_calibration(text, path):
    """The camera; None where the text holds none. Raises DatasetError for what cannot be used."""
    try:
        values = yaml.safe_load(re.sub(r"^%YAML.*|!!opencv-matrix", "", text))
    except yaml.YAMLError:
        return None
    if not isinstance(values, dict):
        return None
    values = flatten(values)
    try:
        numbers = find_numbers(values)
        return numbers and Camera(*map(float, numbers), path, find_size(values),
                                  find_distortion(values, path))
    except (TypeError, ValueError, KeyError, IndexError) as error:
        raise DatasetError(f"{path}: {error!r}, expected numbers for the intrinsics")


def flatten(values):
    """Keys in lower case, without a leading `Camera.` and without the level `camera:`."""
    flat = {}
    for key, value in values.items():
        if str(key).lower() == "camera" and isinstance(value, dict):
            flat.update(flatten(value))
        else:
            flat[re.sub(r"^camera\d*\.", "", str(key).lower())] = value
    return flat


def find_numbers(values):
    """(fx, fy, cx, cy) or None."""
    if all(key in values for key in ("fx", "fy", "cx", "cy")):
        return [values[key] for key in ("fx", "fy", "cx", "cy")]
    if "intrinsic_matrix" in values:  # Open3D: column by column
        K = to_list(values["intrinsic_matrix"])
        return K[0], K[4], K[6], K[7]
    for key in ("camera_matrix", "k"):
        if key in values:
            K = to_list(values[key])
            return K[0], K[4], K[2], K[5]
    return None


def to_list(value):
    """Numbers of a list, of rows or of {rows, cols, data}."""
    value = value["data"] if isinstance(value, dict) else value
    return [v for row in value for v in (row if isinstance(row, list) else [row])]


def find_size(values):
    for width, height in (("image_width", "image_height"), ("width", "height"), ("w", "h")):
        if width in values and height in values:
            return int(values[width]), int(values[height])
    return None


def find_distortion(values, path):
    """plumb_bob's coefficients, () for none."""
    numbers = [float(values.get(key, 0.0)) for key in DISTORTION_KEYS]
    for key in ("distortion_coefficients", "d"):
        if key in values:
            numbers = [float(v) for v in to_list(values[key])]
    if not any(numbers):
        return ()
    model = values.get("distortion_model", values.get("camera_model", "plumb_bob"))
    if model not in ("plumb_bob", "radtan", "pinhole") or len(numbers) not in (4, 5):
        raise DatasetError(f"{path}: distortion {model} with {len(numbers)} coefficients, expected "
                           "plumb_bob with 4 or 5 (rectify the images and leave it out)")
    return tuple(numbers)
