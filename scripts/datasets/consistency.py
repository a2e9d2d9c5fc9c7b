# SPDX-License-Identifier: BSD-3-Clause
"""Whether neighbouring frames agree: depth of one, carried over by the poses, against the other's.

The cost of a reading is |ln(predicted / measured)|, cut at 5 %; that of a whole setting is the
mean, as a share of the cut. A wrong convention or unit leaves most readings at the cut; the right
one has a half at worst (with noise of 2 % on each pixel). Other conventions, units and focal
lengths are tried, and one is named only where it is better by far: motions that look alike under
two conventions tell nothing.
"""
import itertools
from typing import List, NamedTuple

import numpy as np

from .conventions import DIRECTIONS, T_AXES_OPTICAL, PoseConvention
from .frames import BrokenFile

MAX_ANCHORS = 16
GAPS = (1, 2, 3, 5, 8, 13, 20, 30)
MAX_TURN_DEG = 15.0
MAX_READINGS = 1000  # of each frame
CUT = 0.05
MIN_MARGIN = 0.15  # by which another setting must be better to be named
# Cost above which frames are said not to agree, and a lower one where at least a share of the
# readings falls into the other image.
HOPELESS = 0.85
HOPELESS_IN_VIEW = (0.7, 0.4)
MIN_IN_VIEW = 0.1  # share of the readings that must fall into the other image
MIN_COMPARED = 200  # readings, over all pairs
COMMON_UNITS_PER_M = (1000.0, 4000.0, 5000.0, 6553.5, 10000.0)
FOCAL_FACTORS = (0.5, 0.7, 0.8, 1.25, 1.4, 2.0)
FACTORS = (1.0, 0.2, 5.0, 0.25, 4.0, 0.1, 10.0, 0.01, 100.0, 1e-3, 1e3)


class View(NamedTuple):
    T_given: np.ndarray  # 4x4 as the folder gives it
    depth_m: np.ndarray  # H x W, 0: no reading
    sample: np.ndarray  # N x 3: u, v, depth of a regular sample of the readings


class Setting(NamedTuple):
    convention: PoseConvention
    depth_factor: float = 1.0  # on depth in metres
    focal_factor: float = 1.0

    def change(self, camera):
        return camera._replace(fx_px=camera.fx_px * self.focal_factor,
                               fy_px=camera.fy_px * self.focal_factor)


class Agreement(NamedTuple):
    cost: float  # 0 to 1; 1 where too few readings can be compared
    median_error: float  # relative
    num_compared: int
    in_view: float  # share of the readings that fall into the other image

    @property
    def is_hopeless(self):
        cost, in_view = HOPELESS_IN_VIEW
        return self.cost > (cost if self.in_view >= in_view else HOPELESS)


def pick_pairs(T_given):
    """Indices (a, b) of frames with as much motion between them as leaves them overlapping. The
    angle between two poses is the same in every convention."""
    pairs = []
    for a in np.unique(np.linspace(0, len(T_given) - 2, MAX_ANCHORS).astype(int)):
        later = [a + gap for gap in GAPS if a + gap < len(T_given)]
        near = [b for b in later if turn_deg(T_given[a], T_given[b]) <= MAX_TURN_DEG]
        if near:
            pairs.append((a, near[-1]))
    return pairs


def turn_deg(T_a, T_b):
    cosine = 0.5 * (np.trace(T_a[:3, :3].T @ T_b[:3, :3]) - 1.0)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def load_views(loader, frames, T_given, pairs):
    """{index: View}; frames whose depth cannot be read are left out."""
    views = {}
    for index in sorted(set(itertools.chain(*pairs))):
        try:
            depth_m = loader.scale.to_metres(loader.load_depth(frames[index]))
            views[index] = View(T_given[index], depth_m, take_sample(depth_m))
        except BrokenFile:
            continue
    return views


def take_sample(depth_m):
    step = max(1, round((depth_m.size / MAX_READINGS) ** 0.5))
    v, u = np.mgrid[step // 2:depth_m.shape[0]:step, step // 2:depth_m.shape[1]:step]
    sample = np.stack([u, v, depth_m[v, u]], axis=-1).reshape(-1, 3).astype(float)
    return sample[sample[:, 2] > 0.0]


def to_points(sample, camera):
    """N x 3 in the camera's optical frame, metres."""
    u, v, z = sample.T
    return np.column_stack([(u - camera.cx_px) / camera.fx_px * z,
                            (v - camera.cy_px) / camera.fy_px * z, z])


def compare(points, depth_m, camera):
    """(relative errors of the points that fall on a reading, how many fall into the image)."""
    points = points[points[:, 2] > 1e-9]
    u = points[:, 0] / points[:, 2] * camera.fx_px + camera.cx_px
    v = points[:, 1] / points[:, 2] * camera.fy_px + camera.cy_px
    height, width = depth_m.shape
    inside = (u > -0.5) & (u < width - 0.5) & (v > -0.5) & (v < height - 0.5)
    measured = depth_m[np.rint(v[inside]).astype(int), np.rint(u[inside]).astype(int)]
    known = measured > 0.0
    return np.abs(np.log(points[inside, 2][known] / measured[known])), int(inside.sum())


def measure(setting, views, pairs, camera):
    errors: List[np.ndarray] = []
    num_inside = num_points = 0
    camera = setting.change(camera)
    poses = {i: setting.convention.to_camera_to_world(view.T_given) for i, view in views.items()}
    for a, b in pairs:
        T_b_a = np.linalg.inv(poses[b]) @ poses[a]
        points = to_points(views[a].sample, camera) * setting.depth_factor
        found, inside = compare(points @ T_b_a[:3, :3].T + T_b_a[:3, 3],
                                views[b].depth_m * setting.depth_factor, camera)
        errors.append(found)
        num_inside += inside
        num_points += len(points)
    merged = np.concatenate(errors) if errors else np.zeros(0)
    in_view = num_inside / max(num_points, 1)
    if len(merged) < MIN_COMPARED or in_view < MIN_IN_VIEW:
        return Agreement(1.0, float("nan"), len(merged), in_view)
    cost = float(np.minimum(merged / CUT, 1.0).mean())
    return Agreement(cost, float(np.median(merged)), len(merged), in_view)


def list_settings(assumed, units_per_m):
    """The assumed setting first, then every other convention and unit, and other focal lengths."""
    factors = list(FACTORS) + [units_per_m / unit for unit in COMMON_UNITS_PER_M]
    factors = [f for k, f in enumerate(factors) if not any(np.isclose(f, g) for g in factors[:k])]
    conventions = [assumed] + [assumed._replace(axes=axes, direction=direction)
                               for direction in DIRECTIONS for axes in T_AXES_OPTICAL]
    settings = [Setting(convention, factor) for factor in factors
                for convention in dict.fromkeys(conventions)]
    return settings + [Setting(assumed, 1.0, factor) for factor in FOCAL_FACTORS]


class Report(NamedTuple):
    assumed: Agreement
    best: Agreement
    setting: Setting  # the best one; the assumed one unless another is better by far
    num_pairs: int

    @property
    def is_better_known(self):
        return self.best.cost <= self.assumed.cost - MIN_MARGIN

    @property
    def is_checked(self):
        return max(self.assumed.num_compared, self.best.num_compared) >= MIN_COMPARED


def check_frames(loader, frames, T_given, assumed):
    """Report on a sample of frames. T_given: their poses as the folder gives them; assumed: the
    convention in which they are read."""
    pairs = pick_pairs(T_given) if len(frames) > 1 else []
    views = load_views(loader, frames, T_given, pairs)
    pairs = [pair for pair in pairs if pair[0] in views and pair[1] in views]
    settings = list_settings(assumed, loader.scale.units_per_m)
    first = measure(settings[0], views, pairs, loader.match.camera)
    if first.cost < MIN_MARGIN:
        return Report(first, first, settings[0], len(pairs))
    agreements = [measure(s, views, pairs, loader.match.camera) for s in settings]
    best = min(range(len(settings)), key=lambda k: agreements[k].cost)
    if agreements[best].cost > first.cost - MIN_MARGIN:
        best = 0
    return Report(first, agreements[best], settings[best], len(pairs))
