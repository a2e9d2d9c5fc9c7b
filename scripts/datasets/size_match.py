# SPDX-License-Identifier: BSD-3-Clause
"""Colour and depth of different sizes, brought to one grid of pixels.

Both images are taken to look from the same point in the same direction, as a registered pair does;
pixel u of the output then lies at fx_in (u - cx_out) / fx_out + cx_in of the input. Without a
second set of intrinsics the sizes' ratio s gives them, which makes that (u + 0.5) s - 0.5: pixel
centres lie at whole numbers. Depth and labels take the nearest pixel; colour is averaged over the
pixel's area.
"""
import math
from typing import NamedTuple, Optional, Tuple

import numpy as np
from PIL import Image

from . import intrinsics
from .frames import Camera, DatasetError

MODES = ("color-to-depth", "depth-to-color")
MAX_CORNER_OFFSET_PX = 0.5


class Axis(NamedTuple):
    """One direction of an image: output pixel u lies at scale u + offset of the input."""
    scale: float
    offset: float
    length_in: int
    length_out: int

    def nearest(self):
        """(input index, whether there is one) for each output pixel."""
        index = np.floor(self.scale * np.arange(self.length_out) + self.offset + 0.5).astype(int)
        inside = (index >= 0) & (index < self.length_in)
        return np.where(inside, index, 0), inside

    def span(self):
        """Input interval under the whole output; edges of pixels lie at whole numbers here."""
        begin = self.offset - 0.5 * self.scale + 0.5
        return begin, begin + self.scale * self.length_out

    def padding(self):
        begin, end = self.span()
        return max(0, math.ceil(-begin)), max(0, math.ceil(end - self.length_in))


class Grid(NamedTuple):
    x: Axis
    y: Axis

    def is_inside(self):
        """H x W: output pixels whose centre lies in the input."""
        return self.y.nearest()[1][:, None] & self.x.nearest()[1][None, :]

    def take_nearest(self, pixels):
        """Never mixes two pixels; 0 outside."""
        taken = pixels[np.ix_(self.y.nearest()[0], self.x.nearest()[0])]
        return np.where(self.is_inside(), taken, 0).astype(pixels.dtype)

    def average(self, color):
        """H x W x 3: averaged where output pixels are larger, linear where smaller; 0 outside."""
        (left, right), (top, bottom) = self.x.padding(), self.y.padding()
        padded = np.pad(color, ((top, bottom), (left, right), (0, 0)), mode="edge")
        (x0, x1), (y0, y1) = self.x.span(), self.y.span()
        image = Image.fromarray(padded).resize(
            (self.x.length_out, self.y.length_out), Image.BILINEAR,
            box=(x0 + left, y0 + top, x1 + left, y1 + top))
        return np.where(self.is_inside()[..., None], np.asarray(image), 0).astype(np.uint8)


class SizeMatch(NamedTuple):
    camera: Camera  # of the output
    size: Tuple[int, int]  # (width, height) of the output
    color: Optional[Grid]  # None: colour stays as it is
    depth: Optional[Grid]
    note: str


def make_grid(camera_in, size_in, camera_out, size_out):
    def axis(f_in, c_in, f_out, c_out, k):
        return Axis(f_in / f_out, c_in - f_in / f_out * c_out, size_in[k], size_out[k])
    return Grid(axis(camera_in.fx_px, camera_in.cx_px, camera_out.fx_px, camera_out.cx_px, 0),
                axis(camera_in.fy_px, camera_in.cy_px, camera_out.fy_px, camera_out.cy_px, 1))


def match_sizes(cameras, sizes, mode, default_mode):
    """How colour and depth get one size and one camera. Raises DatasetError where it is unknown."""
    if sizes.color == sizes.depth and not (cameras.is_both and differ(cameras, sizes)):
        camera = cameras.color or cameras.depth
        return SizeMatch(camera, sizes.color, None, None, cameras.note)
    mode = mode or ("color-to-depth" if cameras.is_both else default_mode)
    if mode is None:
        raise DatasetError(
            f"{sizes.color_path}: {to_text(sizes.color)} pixels, {sizes.depth_path}: "
            f"{to_text(sizes.depth)}, expected one size; --match-size color-to-depth brings colour "
            f"to {to_text(sizes.depth)}, --match-size depth-to-color brings depth to "
            f"{to_text(sizes.color)}")
    color, depth = complete(cameras, sizes)
    way = "by their intrinsics" if cameras.is_both else "by the ratio of the sizes"
    if mode == "color-to-depth":
        grid = make_grid(color, sizes.color, depth, sizes.depth)
        note = f"colour {to_text(sizes.color)} brought to depth's {to_text(sizes.depth)} {way}"
        note += describe_outside(grid, "depth readings", "colour")
        return SizeMatch(depth, sizes.depth, grid, None, note)
    grid = make_grid(depth, sizes.depth, color, sizes.color)
    note = f"depth {to_text(sizes.depth)} brought to colour's {to_text(sizes.color)} {way}"
    note += describe_outside(grid, "colour pixels", "depth")
    return SizeMatch(color, sizes.color, None, grid, note)


def differ(cameras, sizes):
    """True where a corner of the images would move by more than half a pixel."""
    grid = make_grid(cameras.color, sizes.color, cameras.depth, sizes.depth)
    return any(abs(axis.scale * u + axis.offset - u) > MAX_CORNER_OFFSET_PX
               for axis in grid for u in (0, axis.length_out - 1))


def complete(cameras, sizes):
    """Both cameras, the unknown one by the ratio of the sizes."""
    if not cameras.is_both and not intrinsics.is_same_shape(sizes.color, sizes.depth):
        raise DatasetError(
            f"{sizes.color_path}: {to_text(sizes.color)} pixels, {sizes.depth_path}: "
            f"{to_text(sizes.depth)}, expected the same ratio of width and height within 1 %, or "
            "both cameras' intrinsics: --intrinsics for colour and --depth-intrinsics for depth")
    color = cameras.color or intrinsics.scale(cameras.depth, sizes.depth, sizes.color)
    depth = cameras.depth or intrinsics.scale(cameras.color, sizes.color, sizes.depth)
    return color, depth


def describe_outside(grid, what, other):
    share = 1.0 - float(grid.is_inside().mean())
    if share < 0.005:
        return ""
    return f"; {share:.0%} of the {what} lie outside the {other} image: no depth there"


def to_text(size):
    return f"{size[0]}x{size[1]}"
