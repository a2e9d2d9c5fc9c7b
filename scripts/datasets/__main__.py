# SPDX-License-Identifier: BSD-3-Clause
"""Folder -> bag, with a line on every choice made and a last line on what was written."""
import os
import sys

from . import plausibility, recorded_segmentation, world_up
from .cameras import ImageSizes, find_cameras
from .conventions import AXES_NAMES, PoseConvention
from .depth_scale import DepthScale
from .frames import RATE, BrokenFiles, DatasetError, Settings
from .images import find_common_size
from .intrinsics import find_doubt, to_text
from .layouts import find_layout
from .loader import FrameLoader
from .numbered import keep_rising
from .options import parse_arguments
from .output import OutputFiles, prepare
from .size_match import match_sizes
from .trajectory import read_trajectory

DEFAULT_RATE_HZ = 30.0
DEFAULT_SYNC_TOLERANCE_S = 0.02
MAX_NAMED = 5


def say(text):
    print(f"[dataset_to_bag] {text}", flush=True)


def warn(text):
    print(f"[dataset_to_bag] warning: {text}", file=sys.stderr, flush=True)


def show_progress(done, total):
    """A bar on a terminal, else a line every tenth part."""
    if sys.stderr.isatty():
        filled = 40 * done // total
        end = "\n" if done == total else ""
        print(f"\r[{'#' * filled}{'.' * (40 - filled)}] {done}/{total} frames", end=end,
              file=sys.stderr, flush=True)
    elif done == total or done % max(1, total // 10) == 0:
        print(f"[dataset_to_bag] {done}/{total} frames", file=sys.stderr, flush=True)


def read_sequence(arguments, broken):
    """The folder's frames with poses as it gives them, stamps rising."""
    folder = os.path.expanduser(arguments.input)
    layout = find_layout(folder, arguments.format, arguments.trajectory is not None)
    trajectory = arguments.trajectory and read_trajectory(os.path.expanduser(arguments.trajectory),
                                                          broken)
    sequence = layout.read(folder, Settings(arguments.rate or DEFAULT_RATE_HZ,
                                            arguments.sync_tolerance or DEFAULT_SYNC_TOLERANCE_S,
                                            trajectory, broken))
    frames, repeated = keep_rising(sequence.frames)
    sequence = sequence._replace(frames=frames, left_out=sequence.left_out + repeated)
    describe_sequence(folder, sequence)
    warn_of_unused(arguments, sequence)
    if not frames:
        raise DatasetError(f"{folder}: none of {sequence.num_total} frames can be used, expected "
                           "at least one with colour, depth and a valid pose"
                           + "".join(f"; {entry.count} {entry.what}: {entry.why}"
                                     for entry in sequence.left_out))
    return folder, sequence


def describe_sequence(folder, sequence):
    say(f"{folder}: layout {sequence.layout}, {sequence.num_total} frames, {len(sequence.frames)} "
        f"with colour, depth and pose; stamps: {sequence.stamps_source}")
    for entry in sequence.left_out:
        say(f"{entry.count} {entry.what} skipped: {entry.why}")
    for note in sequence.notes:
        say(note)


def warn_of_unused(arguments, sequence):
    """Options that the folder leaves nothing to do for."""
    if arguments.rate and sequence.stamps_source != RATE:
        warn(f"--rate {arguments.rate:g} is not used: stamps come from {sequence.stamps_source}")
    if arguments.sync_tolerance and os.path.basename(sequence.stamps_source) != "rgb.txt":
        warn(f"--sync-tolerance {arguments.sync_tolerance:g} is not used: colour and depth belong "
             "together by number or by a list of pairs")


def make_loader(arguments, folder, sequence):
    """Decides on camera, size and unit, and says so."""
    sizes = ImageSizes(*find_common_size([frame.color_path for frame in sequence.frames]),
                       *find_common_size([frame.depth_path for frame in sequence.frames]))
    cameras = find_cameras(folder, sequence, sizes, arguments.intrinsics,
                           arguments.depth_intrinsics)
    match = match_sizes(cameras, sizes, arguments.match_size,
                        "color-to-depth" if sequence.layout == "scannet" else None)
    scale = arguments.depth_scale or DepthScale(sequence.depth_units_per_m, "the layout's")
    say(f"intrinsics of the bag: {to_text(match.camera)} for {match.size[0]}x{match.size[1]}, from "
        f"{match.camera.source}; depth: {scale.describe()}")
    if match.note:
        say(match.note)
    if arguments.match_size and not match.color and not match.depth:
        warn(f"--match-size {arguments.match_size} is not used: colour and depth have one size")
    for camera, size in ((cameras.color, sizes.color), (cameras.depth, sizes.depth)):
        doubt = camera and find_doubt(camera, size)
        if doubt:
            warn(doubt)
    return FrameLoader(match, sizes, scale, arguments.depth_scale is not None)


def convert_poses(sequence, convention, up):
    """The sequence with poses T_world_camera of the optical frame, `up` (if any) turned to z."""
    frames = [frame._replace(T_world_camera=convention.to_camera_to_world(frame.T_world_camera))
              for frame in sequence.frames]
    sequence = sequence._replace(frames=frames)
    return sequence if up is None else world_up.turn_world(sequence, up)


def check(loader, frames, convention):
    """Remarks and warnings on frames with poses as the folder gives them."""
    remarks, warnings = plausibility.find_doubts(loader, frames, [f.T_world_camera for f in frames],
                                                 convention)
    for remark in remarks:
        say(remark)
    for warning in warnings:
        warn(warning)


def read_segmentation(folder, sequence):
    """None without embeddings.npz."""
    if not recorded_segmentation.is_present(folder):
        return None
    num_labels = sum(frame.labels_path is not None for frame in sequence.frames)
    if num_labels < len(sequence.frames):
        warn(f"{len(sequence.frames) - num_labels} of {len(sequence.frames)} frames have no label "
             "image beside embeddings.npz: no segmentation for these")
    return recorded_segmentation.RecordedSegmentation(folder, sequence.num_total)


def convert(arguments):
    from . import bag  # needs ROS; --help does not
    broken = BrokenFiles(arguments.skip_broken)
    folder, given = read_sequence(arguments, broken)
    loader = make_loader(arguments, folder, given)
    convention = PoseConvention(AXES_NAMES[arguments.camera_axes], arguments.poses,
                                arguments.pose_scale)
    sequence = convert_poses(given, convention, arguments.world_up)
    frames = sequence.frames[:: arguments.stride][: arguments.max_frames]
    check(loader, [frame for frame in given.frames if frame.index <= frames[-1].index], convention)
    segmentation = read_segmentation(folder, sequence)
    output = os.path.expanduser(arguments.output)
    prepare(output)
    with OutputFiles() as files:
        written = write_files(bag, files, output, frames, loader, segmentation, broken)
        paths = files.commit()
    say_end(paths, written, broken)


def write_files(bag, files, output, frames, loader, segmentation, broken):
    """Writes under temporary names; returns what the bag holds."""
    temporary = files.add(output)
    try:
        if segmentation:
            recorded_segmentation.write_task_files(files, output, segmentation)
        written = bag.write_bag(temporary, frames, loader, segmentation, broken, show_progress)
    except OSError as error:
        raise DatasetError(f"{output}: {error.strerror or error}")
    if not written.num_frames:
        raise DatasetError(f"none of {len(frames)} frames could be read; the first: "
                           f"{broken.errors[0]}")
    return written


def say_end(paths, written, broken):
    """One line for each broken file up to a few, then the line on what was written."""
    for error in broken.errors[:MAX_NAMED]:
        warn(f"skipped: {error}")
    if len(broken.errors) > MAX_NAMED:
        warn(f"skipped: {len(broken.errors) - MAX_NAMED} more")
    skipped = f", {len(broken.errors)} broken files or lines skipped" if broken.errors else ""
    say(f"wrote {', '.join(paths)}: {written.num_frames} frames over {written.duration_s:.2f} s"
        f"{skipped}, {os.path.getsize(paths[0]) / 1e6:.1f} MB, topics {', '.join(written.topics)}")


def main(arguments=None):
    try:
        convert(parse_arguments(arguments))
    except (DatasetError, OSError) as error:
        print(f"[dataset_to_bag] nothing was written: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("[dataset_to_bag] nothing was written: interrupted", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
