# SPDX-License-Identifier: BSD-3-Clause
"""Which intrinsics hold for the colour and the depth images of a folder."""
from typing import NamedTuple, Optional, Tuple

from . import intrinsics
from .frames import Camera, DatasetError


class ImageSizes(NamedTuple):
    """(width, height) and a file that has it, of colour and of depth."""
    color: Tuple[int, int]
    color_path: str
    depth: Tuple[int, int]
    depth_path: str


class Cameras(NamedTuple):
    color: Optional[Camera]
    depth: Optional[Camera]  # None: the colour camera's, brought to depth's size
    note: str = ""

    @property
    def is_both(self):
        return self.color is not None and self.depth is not None


def find_cameras(folder, sequence, sizes, given_color, given_depth):
    """Options first, then camera-intrinsics.txt, then what the layout says. Raises DatasetError
    where there are none, or those there are cannot belong to the images."""
    named = given_color or intrinsics.find_beside(folder)
    color, depth = named or sequence.color_camera, given_depth or sequence.depth_camera
    if color is None and depth is None:
        raise DatasetError(f"{folder}: no intrinsics for its {sizes.color[0]}x{sizes.color[1]} "
                           f"images, expected camera-intrinsics.txt there; {intrinsics.ADVICE}")
    if depth:
        intrinsics.require_fit(depth, sizes.depth, sizes.depth_path, "--depth-intrinsics")
    if not named and depth and sizes.color == sizes.depth and (
            color is None or intrinsics.find_misfit(color, sizes.color)):
        return Cameras(depth, None, describe_resized(color))
    if color:
        intrinsics.require_fit(color, sizes.color, sizes.color_path)
    return Cameras(color, depth)


def describe_resized(color):
    """Exporters can resize colour to depth's size and leave its intrinsics as they were."""
    if color is None:
        return ""
    return (f"{color.source} ({intrinsics.to_text(color)}) is for larger images; colour has "
            "depth's size, so depth's intrinsics are taken for both")
