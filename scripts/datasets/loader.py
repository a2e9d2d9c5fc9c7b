# SPDX-License-Identifier: BSD-3-Clause
"""The images of a frame, checked, on one grid."""
from typing import NamedTuple, Optional

import numpy as np

from .frames import BrokenFile
from .images import read_color, read_depth, read_labels


class Images(NamedTuple):
    color: np.ndarray  # H x W x 3, uint8
    depth: np.ndarray  # H x W, in the file's unit: uint16 or float32
    labels: Optional[np.ndarray]  # H x W, uint16: instance ids


class FrameLoader:
    """Raises BrokenFile for an image that cannot be read or differs from the others."""

    def __init__(self, match, sizes, scale, scale_is_given):
        self.match = match
        self.sizes = sizes
        self.scale = scale
        self.scale_is_given = scale_is_given
        self.depth_type = None

    def load(self, frame, with_labels):
        color = read_color(frame.color_path)
        require_size(color, self.sizes.color, frame.color_path, "colour")
        depth = self.load_depth(frame)
        if self.match.color:
            color = self.match.color.average(color)
        labels = self.load_labels(frame.labels_path) if with_labels and frame.labels_path else None
        return Images(color, depth, labels)

    def load_depth(self, frame):
        """On the output's grid; 0 where colour does not reach."""
        raw = read_depth(frame.depth_path)
        require_size(raw, self.sizes.depth, frame.depth_path, "depth")
        if self.depth_type is None:
            self.scale.require_type(raw, frame.depth_path, self.scale_is_given)
            self.depth_type = raw.dtype
        if raw.dtype != self.depth_type:
            raise BrokenFile(f"{frame.depth_path}: {raw.dtype} image, expected {self.depth_type} "
                             "like the others")
        if self.match.depth:
            return self.match.depth.take_nearest(raw)
        return np.where(self.match.color.is_inside(), raw, 0) if self.match.color else raw

    def load_labels(self, path):
        """Label images have the size of colour or of depth, and go where that goes."""
        labels = read_labels(path)
        size = labels.shape[::-1]
        for expected, grid in ((self.sizes.color, self.match.color),
                               (self.sizes.depth, self.match.depth)):
            if size == tuple(expected):
                return grid.take_nearest(labels) if grid else labels
        raise BrokenFile(f"{path}: {size[0]}x{size[1]} pixels, expected the colour images' "
                         f"{self.sizes.color[0]}x{self.sizes.color[1]} or the depth images' "
                         f"{self.sizes.depth[0]}x{self.sizes.depth[1]}")


def require_size(pixels, size, path, what):
    if (pixels.shape[1], pixels.shape[0]) != tuple(size):
        raise BrokenFile(f"{path}: {pixels.shape[1]}x{pixels.shape[0]} pixels, expected "
                         f"{size[0]}x{size[1]} like the other {what} images")
