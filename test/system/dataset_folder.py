# SPDX-License-Identifier: BSD-3-Clause
"""Tiny folders of images for the tests of scripts/dataset_to_bag, and their bags read back."""
import contextlib
import io
import os
import sys
import tempfile
import unittest

import numpy as np
import rosbag
from PIL import Image

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
from datasets import __main__ as command  # noqa: E402
from datasets import rotation  # noqa: E402

COLOR = "/camera/color/image_raw"
INFO = "/camera/color/camera_info"
DEPTH = "/camera/aligned_depth_to_color/image_raw"
WIDTH, HEIGHT = 8, 6
INTRINSICS = "10 0 4\n0 11 3\n0 0 1\n"  # fit 8x6 images


def turn_z(angle_rad):
    T = np.eye(4)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    T[:2, :2] = [[c, -s], [s, c]]
    return T


def pose(index):
    T = turn_z(0.3 * index)
    T[:3, 3] = [0.1 * index, -0.2, 1.4]
    return T


def color(index, width=WIDTH, height=HEIGHT):
    """Smooth, so that JPEG keeps it nearly unchanged."""
    return np.full((height, width, 3), (40 + 10 * index, 90, 200), np.uint8)


def depth(index, width=WIDTH, height=HEIGHT):
    return (np.arange(height * width).reshape(height, width) % 50 * 100 + index).astype(np.uint16)


def number_lines(T):
    return "\n".join(" ".join(f"{v:.12e}" for v in row) for row in T) + "\n"


def number_line(T):
    return " ".join(f"{v:.12e}" for v in T.ravel()) + "\n"


def trajectory_line(stamp_s, T):
    q = rotation.to_quaternion(T[:3, :3])
    return f"{stamp_s:.6f} " + " ".join(f"{v:.12e}" for v in [*T[:3, 3], *q]) + "\n"


def stamps_ns(messages):
    return [m.header.stamp.to_nsec() for m in messages]


def depth_pixels(message):
    kind = {"16UC1": "<u2", "32FC1": "<f4"}[message.encoding]
    return np.frombuffer(message.data, kind).reshape(message.height, message.width)


def color_pixels(message):
    return np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, 3)


class Folder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.input = os.path.join(self.temporary.name, "input")
        self.output = os.path.join(self.temporary.name, "out.bag")
        os.makedirs(self.input)

    def path(self, *names):
        path = os.path.join(self.input, *names)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return path

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def write_bytes(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)

    def read_bytes(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def cut(self, name, share=0.5):
        """Truncates a file to a share of its bytes."""
        data = self.read_bytes(name)
        self.write_bytes(name, data[: int(len(data) * share)])

    def save(self, name, pixels, **options):
        Image.fromarray(pixels).save(self.path(name), **options)

    def run_command(self, *arguments):
        """(exit status, what it printed)."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            status = command.main(["--input", self.input, "--output", self.output, *arguments])
        return status, text.getvalue()

    def convert(self, *arguments):
        """{topic: [message]} of the bag; self.order: topics as recorded, self.text: what was said."""
        status, self.text = self.run_command(*arguments)
        self.assertEqual(status, 0, self.text)
        self.assertFalse(os.path.exists(self.output + ".part"))
        self.order, messages = [], {}
        with rosbag.Bag(self.output) as bag:
            for topic, message, _ in bag.read_messages():
                self.order.append(topic)
                messages.setdefault(topic, []).append(message)
        return messages

    def warnings(self):
        return [line for line in self.text.splitlines() if "warning:" in line]

    def expect_error(self, *parts, arguments=()):
        status, text = self.run_command(*arguments)
        self.assertEqual(status, 1, text)
        for part in ("nothing was written", *parts):
            self.assertIn(part, text)
        self.assertFalse(os.path.exists(self.output))
        self.assertFalse(os.path.exists(self.output + ".part"))
        return text

    def expect_usage_error(self, *parts, arguments):
        """argparse refuses: exit status 2."""
        text = io.StringIO()
        with contextlib.redirect_stderr(text), self.assertRaises(SystemExit) as caught:
            command.main(["--input", self.input, "--output", self.output, *arguments])
        self.assertEqual(caught.exception.code, 2)
        for part in parts:
            self.assertIn(part, text.getvalue())

    def expect_camera(self, info, fx, fy, cx, cy):
        np.testing.assert_allclose([info.K[0], info.K[4], info.K[2], info.K[5]], [fx, fy, cx, cy],
                                   atol=1e-6)

    def expect_pose(self, message, T):
        transform = message.transforms[0]
        self.assertEqual(transform.header.frame_id, "world")
        self.assertEqual(transform.child_frame_id, "camera_color_optical_frame")
        t, q = transform.transform.translation, transform.transform.rotation
        np.testing.assert_allclose([t.x, t.y, t.z], T[:3, 3], atol=1e-9)
        np.testing.assert_allclose(rotation.from_quaternion([q.x, q.y, q.z, q.w]), T[:3, :3],
                                   atol=1e-9)


class ThreeDMatchFolder(Folder):
    def write_frame(self, i, color_size=(WIDTH, HEIGHT), depth_size=(WIDTH, HEIGHT)):
        self.save(f"frame-{i:06d}.color.png", color(i, *color_size))
        self.save(f"frame-{i:06d}.depth.png", depth(i, *depth_size))
        self.write(f"frame-{i:06d}.pose.txt", number_lines(pose(i)))

    def write_frames(self, count, with_intrinsics=True, **sizes):
        for i in range(count):
            self.write_frame(i, **sizes)
        if with_intrinsics:
            self.write("camera-intrinsics.txt", INTRINSICS)


class TumFolder(Folder):
    def write_frames(self):
        rgb, depths = "# color images\n", "# depth maps\n"
        for i, (t_rgb, t_depth) in enumerate([(10.00, 10.005), (10.10, 10.13), (10.20, 10.19)]):
            self.save(f"rgb/{i}.png", color(i))
            self.save(f"depth/{i}.png", depth(i))
            rgb += f"{t_rgb:.6f} rgb/{i}.png\n"
            depths += f"{t_depth:.6f} depth/{i}.png\n"
        self.write("rgb.txt", rgb)
        self.write("depth.txt", depths)
        self.write("camera-intrinsics.txt", INTRINSICS)
        self.write("groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n"
                   "9.95 0 0 1 0 0 0 1\n10.05 1 0 1 0 0 0.7071067811865476 0.7071067811865476\n"
                   "10.15 1 0 1 0 0 0.7071067811865476 0.7071067811865476\n10.21 3 0 1 0 0 0 1\n")


class ReplicaFolder(Folder):
    def write_frames(self, numbers=(0, 1), name="{:06d}"):
        for i in numbers:
            self.save(f"results/frame{name.format(i)}.jpg", color(i), quality=95)
            self.save(f"results/depth{name.format(i)}.png", depth(i) * 10)
        self.write("traj.txt", "".join(number_line(pose(i)) for i in numbers))
        self.write("camera-intrinsics.txt", INTRINSICS)


class ScanNetFolder(Folder):
    COLOR_SIZE, DEPTH_SIZE = (24, 18), (12, 9)

    def write_frame(self, i, name="{}"):
        self.save(f"color/{name.format(i)}.jpg", color(i, *self.COLOR_SIZE), quality=95)
        self.save(f"depth/{name.format(i)}.png", depth(i, *self.DEPTH_SIZE))
        self.write(f"pose/{name.format(i)}.txt", number_lines(pose(i)))

    def write_frames(self, numbers=(0, 1, 2), name="{}"):
        for i in numbers:
            self.write_frame(i, name)
        self.write_intrinsics("intrinsic/intrinsic_{}.txt")

    def write_intrinsics(self, name):
        """Those of depth are not exactly half those of colour."""
        self.write(name.format("color"), "20 0 11.5 0\n0 21 8.5 0\n0 0 1 0\n0 0 0 1\n")
        self.write(name.format("depth"), "10 0 5.5 0\n0 10.5 4.0 0\n0 0 1 0\n0 0 0 1\n")


class BoxRoom:
    """A room of 6 x 5 x 2.6 m with a box in it, seen by a camera that walks and turns: depth in closed
    form. 160x120 pixels, fx = fy = 120."""
    SIZE, FOCAL, CENTRE = (160, 120), 120.0, (79.5, 59.5)
    ROOM = np.array([[-3.0, -2.5, 0.0], [3.0, 2.5, 2.6]])
    BOX = np.array([[-0.6, -0.4, 0.0], [0.5, 0.7, 0.9]])

    def __init__(self, num_frames=30):
        self.poses = [self.pose_at(0.05 * k) for k in range(num_frames)]
        self.depths_m = [self.render(T) for T in self.poses]

    def pose_at(self, t):
        """T_world_camera (optical frame): on a circle, looking inwards and somewhat down."""
        position = np.array([1.9 * np.cos(0.6 * t), 1.5 * np.sin(0.6 * t) - 0.3 * t, 1.3 + 0.1 * t])
        forward = np.array([0.2, 0.1, 0.7]) - position
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        T = np.eye(4)
        T[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
        T[:3, 3] = position
        return T

    def render(self, T):
        u, v = np.meshgrid(np.arange(self.SIZE[0]), np.arange(self.SIZE[1]))
        rays = np.stack([(u - self.CENTRE[0]) / self.FOCAL, (v - self.CENTRE[1]) / self.FOCAL,
                         np.ones_like(u)], axis=-1) @ T[:3, :3].T
        with np.errstate(divide="ignore"):
            room, box = (np.sort((bounds[:, None, None] - T[:3, 3]) / rays, axis=0)
                         for bounds in (self.ROOM, self.BOX))
        enter, leave = box[0].max(axis=-1), box[1].min(axis=-1)
        hits_box = (enter < leave) & (enter > 0.0)
        return np.where(hits_box, enter, room[1].min(axis=-1))
