# SPDX-License-Identifier: BSD-3-Clause
"""Command line of scripts/dataset_to_bag."""
import argparse
import os
import sys

from . import recorded_segmentation, replica, three_d_match, tum, world_up
from .frames import DatasetError

LAYOUTS = {"3dmatch": three_d_match, "tum": tum, "replica": replica}


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(
        prog="dataset_to_bag", description="Turns a folder of posed RGB-D images into a rosbag: "
        "colour, registered depth, camera_info, tf (world -> camera_color_optical_frame). Label "
        "images with embeddings become recorded Segmentation messages; their tasks and rooms "
        "become OUTPUT.object_tasks.yaml and OUTPUT.place_tasks.yaml (without .bag). Sequences "
        "that start before 1 s are moved by 1 s, as ROS gives time 0 a meaning of its own.")
    parser.add_argument("--input", required=True, metavar="FOLDER")
    parser.add_argument("--output", required=True, metavar="FILE.bag")
    parser.add_argument("--format", default="auto", choices=["auto", *LAYOUTS])
    parser.add_argument("--rate", type=positive_float, default=30.0, metavar="HZ",
                        help="frame rate where the folder has no stamps (30)")
    parser.add_argument("--stride", type=positive_int, default=1, metavar="N",
                        help="take every Nth frame (1)")
    parser.add_argument("--max-frames", type=positive_int, default=None, metavar="N",
                        help="stop after N frames")
    parser.add_argument("--world-up", type=up_direction, default=None, metavar="level|X,Y,Z",
                        help="turn the world so that this direction of it becomes z, up; level: the "
                        "one that fits a camera held level (7-Scenes' world is its first camera's); "
                        "negative X: --world-up=-1,0,0")
    return parser.parse_args(arguments)


def positive_int(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}, expected at least 1")
    return value


def positive_float(text):
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text}, expected more than 0")
    return value


def up_direction(text):
    try:
        return world_up.parse_up(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(error)


def find_layout(folder, name):
    if not os.path.isdir(folder):
        raise DatasetError(f"--input {folder}: expected a folder")
    if name != "auto":
        return LAYOUTS[name]
    found = [layout for layout in LAYOUTS.values() if layout.matches(folder)]
    if len(found) != 1:
        raise DatasetError(f"{folder}: {len(found)} layouts match, expected one of 3dmatch "
                           "(frame-*.pose.txt), tum (rgb.txt, depth.txt, groundtruth.txt), "
                           "replica (results/, traj.txt); --format names it")
    return found[0]


def show_progress(done, total):
    """A bar on a terminal, else a line every tenth part."""
    if sys.stderr.isatty():
        filled = 40 * done // total
        end = "\n" if done == total else ""
        print(f"\r[{'#' * filled}{'.' * (40 - filled)}] {done}/{total} frames", end=end,
              file=sys.stderr, flush=True)
    elif done == total or done % max(1, total // 10) == 0:
        print(f"[dataset_to_bag] {done}/{total} frames", file=sys.stderr, flush=True)


def convert(arguments):
    from . import bag  # needs ROS; --help does not
    layout = find_layout(arguments.input, arguments.format)
    sequence = layout.read(arguments.input, arguments.rate)
    if arguments.world_up is not None and sequence.frames:
        sequence = world_up.turn_world(sequence, arguments.world_up)
    frames = sequence.frames[:: arguments.stride][: arguments.max_frames]
    print(f"[dataset_to_bag] {arguments.input}: layout {sequence.layout}, {sequence.num_total} "
          f"frames, {len(frames)} to write; intrinsics: {sequence.camera.source}")
    if sequence.num_without_pose:
        print(f"[dataset_to_bag] {sequence.num_without_pose} frames skipped: no valid pose")
    if not frames:
        raise DatasetError(f"{arguments.input}: no frame with a valid pose, expected at least one")
    segmentation = None
    if recorded_segmentation.is_present(arguments.input):
        segmentation = recorded_segmentation.RecordedSegmentation(arguments.input,
                                                                  sequence.num_total)
    bag.write_bag(arguments.output, sequence, frames, segmentation, show_progress)
    written = [arguments.output] + (write_task_files(arguments.output, segmentation)
                                    if segmentation else [])
    print("[dataset_to_bag] wrote " + ", ".join(written))


def write_task_files(output, segmentation):
    stem = output[: -len(".bag")] if output.endswith(".bag") else output
    written = []
    for kind, tasks in (("object", segmentation.tasks), ("place", segmentation.rooms)):
        if tasks:
            written.append(f"{stem}.{kind}_tasks.yaml")
            recorded_segmentation.write_tasks(written[-1], tasks)
    return written


def main(arguments=None):
    try:
        convert(parse_arguments(arguments))
    except (DatasetError, OSError) as error:
        print(f"dataset_to_bag: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
