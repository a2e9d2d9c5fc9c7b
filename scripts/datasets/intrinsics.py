# SPDX-License-Identifier: BSD-3-Clause
"""Intrinsics from numbers, and whether they can belong to images of a size.

Pixel centres lie at whole numbers: an image scaled by s has fx s, (cx + 0.5) s - 0.5.
"""
import os
import re

import numpy as np

from .calibration import find_calibration
from .frames import BrokenFile, Camera, DatasetError
from .text import parse_floats, read_text

HALF_ANGLES_DEG = (5.0, 80.0)
MAX_CENTRE_SHARE = 0.15
MAX_SIZE_RATIO_ERROR = 0.01
FORMS = ("expected fx fy cx cy [k1 k2 p1 p2 [k3]], a 3x3, 3x4 or 4x4 matrix, or a calibration in "
         "YAML or JSON")
ADVICE = "--intrinsics FILE or fx,fy,cx,cy gives them"


def parse_option(text):
    """--intrinsics: fx,fy,cx,cy or a file. Raises DatasetError."""
    try:
        values = [float(word) for word in text.replace(",", " ").split()]
    except ValueError:
        return read_camera(os.path.expanduser(text))
    return camera_from_numbers(values, f"--intrinsics {text}")


def read_camera(path):
    """The camera in a file of any of FORMS."""
    text = read_text(path)
    bare = re.sub(r"[\[\](){};]", " ", re.sub(r"#.*", " ", text))
    try:
        values = parse_floats(bare, path)
    except BrokenFile:
        camera = find_calibration(text, path)
        if camera is None:
            raise DatasetError(f"{path}: '{text.strip()[:60]}', {FORMS}")
        return require_finite(camera)
    return camera_from_numbers(values, path)


def camera_from_numbers(values, source):
    """Raises DatasetError for a count or a shape that is none of FORMS."""
    if len(values) in (9, 12, 16) and not looks_like_line(values):
        return camera_from_matrix(np.reshape(values, (4 if len(values) == 16 else 3, -1)), source)
    if len(values) in (4, 8, 9):
        return require_finite(Camera(*values[:4], source, None, tuple(values[4:])))
    raise DatasetError(f"{source}: {len(values)} numbers, {FORMS}")


def looks_like_line(values):
    """True for fx fy cx cy k1 k2 p1 p2 k3, which are nine numbers like a 3x3 matrix."""
    return len(values) == 9 and values[1] > 1.0 and values[2] > 1.0 and values[3] > 1.0


def camera_from_matrix(K, source):
    """Raises DatasetError for anything but fx 0 cx / 0 fy cy / 0 0 1, extended by 0 0 0 (1)."""
    expected = np.zeros(K.shape)
    for place in ((0, 0), (1, 1), (0, 2), (1, 2)):
        expected[place] = K[place]
    expected[2, 2] = 1.0
    if K.shape[0] == 4:
        expected[3, 3] = 1.0
    if not np.allclose(K, expected, atol=1e-3):
        hint = " (transposed?)" if abs(K[2, 0]) > 1.0 else ""
        raise DatasetError(f"{source}: rows {K.tolist()}{hint}, expected fx 0 cx, 0 fy cy, 0 0 1")
    return require_finite(Camera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], source))


def require_finite(camera):
    values = camera[:4] + camera.distortion
    if not np.all(np.isfinite(values)) or camera.fx_px <= 0.0 or camera.fy_px <= 0.0:
        raise DatasetError(f"{camera.source}: fx {camera.fx_px}, fy {camera.fy_px}, cx "
                           f"{camera.cx_px}, cy {camera.cy_px}, expected numbers, fx and fy "
                           "positive")
    return camera


def find_beside(folder):
    """`camera-intrinsics.txt` in the folder or the one above it; None without one."""
    for place in (folder, os.path.dirname(os.path.abspath(folder))):
        path = os.path.join(place, "camera-intrinsics.txt")
        if os.path.exists(path):
            return read_camera(path)
    return None


def scale(camera, old_size, new_size, source=None):
    """Intrinsics of the same images resized."""
    x, y = new_size[0] / old_size[0], new_size[1] / old_size[1]
    return Camera(camera.fx_px * x, camera.fy_px * y, (camera.cx_px + 0.5) * x - 0.5,
                  (camera.cy_px + 0.5) * y - 0.5, source or camera.source, new_size,
                  camera.distortion)


def is_same_shape(first_size, second_size):
    """True for widths and heights in the same ratio within 1 %."""
    ratio = (first_size[0] * second_size[1]) / (first_size[1] * second_size[0])
    return abs(ratio - 1.0) <= MAX_SIZE_RATIO_ERROR


def find_misfit(camera, size):
    """Why the intrinsics cannot be those of images of a size; None where they can."""
    if camera.size and tuple(camera.size) != tuple(size):
        return f"they hold for {camera.size[0]}x{camera.size[1]} images"
    for name, focal, centre, length in (("x", camera.fx_px, camera.cx_px, size[0]),
                                        ("y", camera.fy_px, camera.cy_px, size[1])):
        if not -0.5 <= centre <= length - 0.5:
            return f"c{name} {centre:g} lies outside the image"
        half_angle_deg = float(np.degrees(np.arctan(0.5 * length / focal)))
        if not HALF_ANGLES_DEG[0] <= half_angle_deg <= HALF_ANGLES_DEG[1]:
            return (f"f{name} {focal:g} makes a field of view of {2 * half_angle_deg:.1f} degrees "
                    f"(expected {2 * HALF_ANGLES_DEG[0]:g} to {2 * HALF_ANGLES_DEG[1]:g})")
    return None


def require_fit(camera, size, image_path, option="--intrinsics"):
    """Raises DatasetError, with scaled numbers where the images look resized."""
    misfit = find_misfit(camera, size)
    if misfit:
        raise DatasetError(
            f"{image_path}: {size[0]}x{size[1]} pixels do not fit the intrinsics {to_text(camera)} "
            f"({camera.source}): {misfit}; {option} FILE or fx,fy,cx,cy gives the right ones"
            + suggest_scaled(camera, size, option))


def suggest_scaled(camera, size, option):
    """An option that holds if the images were resized from the intrinsics' own size; else ''."""
    old = camera.size or (round(2 * camera.cx_px + 1), round(2 * camera.cy_px + 1))
    if min(old) < 2 or tuple(old) == tuple(size) or not is_same_shape(old, size):
        return ""
    return (f"; if the images were resized from {old[0]}x{old[1]}: {option} "
            + to_text(scale(camera, old, size)))


def find_doubt(camera, size):
    """A remark on intrinsics that fit but hardly can be meant; None otherwise."""
    for name, centre, length in (("x", camera.cx_px, size[0]), ("y", camera.cy_px, size[1])):
        share = abs(centre - 0.5 * (length - 1)) / length
        if share > MAX_CENTRE_SHARE:
            return (f"c{name} {centre:g} ({camera.source}) lies {share:.0%} of the image's "
                    f"{length} pixels off its centre: usually the intrinsics are those of another "
                    f"image size; {ADVICE}")
    return None


def to_text(camera):
    """fx,fy,cx,cy as the option takes them."""
    return ",".join(f"{value:.6g}" for value in camera[:4])
