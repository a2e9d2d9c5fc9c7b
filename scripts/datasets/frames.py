# SPDX-License-Identifier: BSD-3-Clause
"""The values that readers hand to the bag writer, and the errors that all modules raise."""
from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np


RATE = "--rate"  # where stamps come from if the folder has none


class DatasetError(Exception):
    """Says which file is wrong, what it holds and what was expected."""


class BrokenFile(DatasetError):
    """One file or line cannot be used; the rest of the folder can."""


class BrokenFiles:
    """Collects broken files; raises at the first one where none may be left out."""

    def __init__(self, skip):
        self.skip = skip
        self.errors: List[str] = []

    def add(self, error):
        if not self.skip:
            raise DatasetError(f"{error}; --skip-broken leaves such frames out") from error
        self.errors.append(str(error))


class Camera(NamedTuple):
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    source: str  # where the numbers come from, for the user to see
    size: Optional[Tuple[int, int]] = None  # (width, height) they hold for; None: any that fits
    distortion: Tuple[float, ...] = ()  # plumb_bob: k1 k2 p1 p2 [k3]


class Frame(NamedTuple):
    index: int  # position in the whole sequence; row of per-frame tables
    stamp_ns: int
    color_path: str
    depth_path: str
    T_world_camera: np.ndarray  # 4x4
    labels_path: Optional[str] = None


class LeftOut(NamedTuple):
    count: int
    what: str  # "frames", "depth images", ...
    why: str


class Sequence(NamedTuple):
    layout: str
    color_camera: Optional[Camera]  # None: the folder does not say
    depth_camera: Optional[Camera]  # only where depth has intrinsics of its own
    depth_units_per_m: float
    frames: List[Frame]
    num_total: int  # frames in the folder, before any was left out
    left_out: List[LeftOut]
    stamps_source: str
    notes: Tuple[str, ...] = ()  # what the user should know of how the folder was read


class Settings(NamedTuple):
    """What readers are told by the command line."""
    rate_hz: float
    sync_tolerance_s: float
    trajectory: Any  # a trajectory.Trajectory in place of the folder's poses, or None
    broken: BrokenFiles
