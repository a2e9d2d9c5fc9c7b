# SPDX-License-Identifier: BSD-3-Clause
"""The command line of scripts/dataset_to_bag."""
import argparse

from . import depth_scale, intrinsics, size_match, world_up
from .conventions import AXES_NAMES, DIRECTIONS
from .frames import DatasetError
from .layouts import LAYOUTS


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(
        prog="dataset_to_bag", description="Turns a folder of posed RGB-D images into a rosbag: "
        "colour, registered depth, camera_info, tf (world -> camera_color_optical_frame). Label "
        "images with embeddings become recorded Segmentation messages; their tasks and rooms "
        "become OUTPUT.object_tasks.yaml and OUTPUT.place_tasks.yaml (without .bag). Sequences "
        "that start before 1 s are moved by 1 s, as ROS gives time 0 a meaning of its own.",
        epilog="layouts: " + "; ".join(f"{name}: {layout.LOOKS_FOR}"
                                       for name, layout in LAYOUTS.items()))
    parser.add_argument("--input", required=True, metavar="FOLDER")
    parser.add_argument("--output", required=True, metavar="FILE.bag")
    parser.add_argument("--format", default="auto", choices=["auto", *LAYOUTS])
    add_selection(parser.add_argument_group("which frames"))
    add_camera(parser.add_argument_group("camera"))
    add_poses(parser.add_argument_group("poses"))
    return parser.parse_args(arguments)


def add_selection(group):
    group.add_argument("--rate", type=positive_float, default=None, metavar="HZ",
                       help="frames 0, 1, 2, ... per second where the folder has no stamps (30)")
    group.add_argument("--stride", type=positive_int, default=1, metavar="N",
                       help="take every Nth frame (1)")
    group.add_argument("--max-frames", type=positive_int, default=None, metavar="N",
                       help="stop after N frames")
    group.add_argument("--sync-tolerance", type=positive_float, default=None, metavar="S",
                       help="tum: largest distance of the stamps of colour and depth (0.02)")
    group.add_argument("--skip-broken", action="store_true",
                       help="leave out, name and count what cannot be read, in place of stopping")


def add_camera(group):
    group.add_argument("--intrinsics", type=camera, default=None, metavar="FILE|FX,FY,CX,CY",
                       help="of the colour images: a 3x3 or 4x4 matrix, fx fy cx cy, or a "
                       "calibration in YAML or JSON; goes before what the folder says")
    group.add_argument("--depth-intrinsics", type=camera, default=None, metavar="FILE|FX,FY,CX,CY",
                       help="of the depth images, where they are not the colour images' own")
    group.add_argument("--depth-scale", type=depth_scale.parse_option, default=None, metavar="X",
                       help="metres per unit (0.001) or, above 1, units per metre (5000)")
    group.add_argument("--match-size", type=hyphenated, choices=size_match.MODES, default=None,
                       help="colour and depth of different sizes: which is brought to the other's "
                       "(color-to-depth where both intrinsics are known, else refused)")


def add_poses(group):
    group.add_argument("--trajectory", default=None, metavar="FILE",
                       help="poses from a TUM file (stamp tx ty tz qx qy qz qw) in place of the "
                       "folder's; images need stamps")
    group.add_argument("--camera-axes", choices=list(AXES_NAMES), default="optical",
                       help="axes of the camera that poses speak of: optical (opencv) x right, y "
                       "down, z forward; opengl x right, y up, z backward; body (flu, ros) x "
                       "forward, y left, z up")
    group.add_argument("--poses", type=hyphenated, choices=DIRECTIONS, default="camera-to-world",
                       help="what a pose takes to what (camera-to-world)")
    group.add_argument("--pose-scale", type=positive_float, default=1.0, metavar="M",
                       help="metres per unit of the poses' translations (1)")
    group.add_argument("--world-up", type=up_direction, default=None, metavar="level|X,Y,Z",
                       help="turn the world so that this direction of it becomes z, up; level: the "
                       "one that fits a camera held level (7-Scenes' world is its first camera's); "
                       "negative X: --world-up=-1,0,0")


def hyphenated(text):
    """Choices may be written as in configuration files, color_to_depth."""
    return text.replace("_", "-")


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


def camera(text):
    try:
        return intrinsics.parse_option(text)
    except (DatasetError, OSError) as error:
        raise argparse.ArgumentTypeError(str(error))


def up_direction(text):
    try:
        return world_up.parse_up(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(error)
