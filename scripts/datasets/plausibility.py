# SPDX-License-Identifier: BSD-3-Clause
"""What the user should look at before using a bag: each line says what is seen, what it usually
means and which option to set. Nothing here stops a run."""
import numpy as np

from . import consistency
from .frames import BrokenFile

MAX_SAMPLED = 12  # frames
MEDIANS_M = (0.25, 15.0)
RANGE_M = (0.2, 20.0)
MIN_SHARE_IN_RANGE = 0.5
STEPS_S = (1e-3, 10.0)


def find_doubts(loader, frames, given_poses, convention):
    """(remarks, warnings) on frames in order; given_poses: their poses as the folder gives them."""
    median_m, in_range, num_sampled = measure_depth(loader, frames)
    report = consistency.check_frames(loader, frames, given_poses, convention)
    warnings = describe_steps(frames)
    if report.is_better_known:
        warnings.append(describe_better(report, convention, loader.scale, median_m))
    elif report.is_checked and report.assumed.is_hopeless:
        warnings.append(describe_disagreement(report))
    if not (report.is_better_known and report.setting.depth_factor != 1.0):
        warnings += describe_depth(loader.scale, median_m, in_range, num_sampled)
    return [describe_check(report)], warnings


def measure_depth(loader, frames):
    """(median of the readings in m, NaN without one; share of them within RANGE_M; frames read)."""
    readings = []
    for index in np.unique(np.linspace(0, len(frames) - 1, MAX_SAMPLED).astype(int)):
        try:
            depth_m = loader.scale.to_metres(loader.load_depth(frames[index]))
        except BrokenFile:
            continue
        readings.append(depth_m[depth_m > 0.0])
    merged = np.concatenate(readings) if readings else np.zeros(0)
    if not len(merged):
        return float("nan"), 0.0, len(readings)
    return (float(np.median(merged)),
            float(np.mean((merged >= RANGE_M[0]) & (merged <= RANGE_M[1]))), len(readings))


def describe_depth(scale, median_m, in_range, num_sampled):
    if not num_sampled:
        return []
    if np.isnan(median_m):
        return [f"no depth reading in {num_sampled} frames looked at (all 0 or 65535): is this the "
                "folder of depth images?"]
    if is_plausible(median_m) and in_range >= MIN_SHARE_IN_RANGE:
        return []
    others = [f"--depth-scale {unit:g} makes it {median_m * scale.units_per_m / unit:.2g} m"
              for unit in consistency.COMMON_UNITS_PER_M
              if unit != scale.units_per_m and 0.4 <= median_m * scale.units_per_m / unit <= 8.0]
    return [f"the median depth is {median_m:.3g} m and {in_range:.0%} of the readings lie within "
            f"{RANGE_M[0]:g} to {RANGE_M[1]:g} m ({num_sampled} frames, {scale.describe()}); "
            "usually the unit is another one, mostly millimetres"
            + ("; " + ", ".join(others) if others else "; --depth-scale sets it")]


def is_plausible(median_m):
    return MEDIANS_M[0] <= median_m <= MEDIANS_M[1]


def describe_steps(frames):
    steps_s = np.diff([frame.stamp_ns for frame in frames]) / 1e9
    if not len(steps_s) or STEPS_S[0] <= np.median(steps_s) <= STEPS_S[1]:
        return []
    return [f"frames are {np.median(steps_s):.3g} s apart (median); usually the stamps are in "
            "another unit than seconds, as milliseconds"]


def describe_check(report):
    if not report.is_checked or np.isnan(report.assumed.median_error):
        return ("poses not checked against depth: hardly any "
                "surface is seen from two frames")
    return (f"neighbouring frames: depth differs by {report.assumed.median_error:.1%} (median of "
            f"{report.assumed.num_compared} readings, {report.num_pairs} pairs)")


def describe_disagreement(report):
    return (f"neighbouring frames do not agree: depth carried over by the poses differs by "
            f"{report.assumed.median_error:.0%} (median), expected below 3 %, and no other "
            "--poses, --camera-axes or --depth-scale is better; usually the intrinsics are of "
            "other images, quaternions are not in the order x y z w, or poses and images are of "
            "different times")


def describe_better(report, convention, scale, median_m):
    """Names the options under which neighbouring frames agree."""
    options, causes = [], []
    wanted = report.setting.convention
    for option, now, then in (("--camera-axes", convention.axes, wanted.axes),
                              ("--poses", convention.direction, wanted.direction)):
        if now != then:
            options.append(f"{option} {then}")
            causes.append("poses of another convention")
    if report.setting.depth_factor != 1.0:
        option, cause = name_scale(report.setting.depth_factor, convention, scale, median_m)
        options.append(option)
        causes.append(cause)
    if report.setting.focal_factor != 1.0:
        options.append(f"--intrinsics of {report.setting.focal_factor:g} times the focal length")
        causes.append("intrinsics of other images, or depth that is not registered to colour")
    seen = ("hardly see each other's surfaces" if np.isnan(report.assumed.median_error) else
            f"differ in depth by {report.assumed.median_error:.0%} (median)")
    return (f"neighbouring frames {seen}, with {' '.join(options)} by "
            f"{report.best.median_error:.1%}; usual cause: {' and '.join(dict.fromkeys(causes))}")


def name_scale(factor, convention, scale, median_m):
    """(the option, what it means) that makes depth `factor` times as large beside the poses: the
    unit of depth, unless only the unit of the poses leaves a plausible depth."""
    units_per_m = scale.units_per_m / factor
    if is_plausible(median_m * factor) or not is_plausible(median_m):
        text = f"{units_per_m:g}" if units_per_m > 1.0 else f"{1.0 / units_per_m:g}"
        return (f"--depth-scale {text}",
                f"depth in another unit (median now {median_m:.2g} m, then "
                f"{median_m * factor:.2g} m)")
    return (f"--pose-scale {convention.scale_m / factor:g}",
            f"poses in another unit than metres (median depth {median_m:.2g} m)")
