# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dataset_to_bag: conventions of poses, and what neighbouring frames tell of them."""
import os
import sys
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from dataset_folder import (BoxRoom, Folder, ReplicaFolder, ScanNetFolder, ThreeDMatchFolder,  # noqa: E402
                            TumFolder, number_lines, pose, trajectory_line)
from datasets.conventions import AXES_NAMES, T_AXES_OPTICAL, PoseConvention  # noqa: E402
from datasets.rotation import from_quaternion  # noqa: E402

ROOM = BoxRoom()
SHARED = os.environ.get("TSG_SHARED", "")


def to_given(T_world_camera, axes="optical", direction="camera-to-world", scale_m=1.0):
    """What a folder of another convention holds for a pose."""
    T = T_world_camera @ np.linalg.inv(T_AXES_OPTICAL[axes])
    T = np.linalg.inv(T) if direction == "world-to-camera" else T
    T = T.copy()
    T[:3, 3] /= scale_m
    return T


class Conventions(ThreeDMatchFolder):
    def test_known_axes(self):
        """A camera at the origin that looks along the world's x axis, z up."""
        T = PoseConvention("body").to_camera_to_world(np.eye(4))
        np.testing.assert_array_equal(T[:3, :3] @ [0, 0, 1], [1, 0, 0])  # forward
        np.testing.assert_array_equal(T[:3, :3] @ [1, 0, 0], [0, -1, 0])  # right
        np.testing.assert_array_equal(T[:3, :3] @ [0, 1, 0], [0, 0, -1])  # down
        T = PoseConvention("opengl").to_camera_to_world(np.eye(4))
        np.testing.assert_array_equal(T[:3, :3] @ [0, 0, 1], [0, 0, -1])
        np.testing.assert_array_equal(T[:3, :3] @ [0, 1, 0], [0, -1, 0])

    def test_every_convention_comes_back_to_camera_to_world(self):
        self.write_frames(3)
        for axes in AXES_NAMES:
            for direction in ("camera-to-world", "world-to-camera", "world_to_camera"):
                for i in range(3):
                    given = to_given(pose(i), AXES_NAMES[axes], direction.replace("_", "-"), 0.01)
                    self.write(f"frame-{i:06d}.pose.txt", number_lines(given))
                messages = self.convert("--camera-axes", axes, "--poses", direction,
                                        "--pose-scale", "0.01")
                for i, message in enumerate(messages["/tf"]):
                    self.expect_pose(message, pose(i))

    def test_they_hold_for_every_layout(self):
        for layout in (TumFolder, ReplicaFolder, ScanNetFolder):
            folder = layout()
            folder.setUp()
            folder.write_frames()
            plain = folder.convert()["/tf"]
            turned = folder.convert("--camera-axes", "opengl", "--poses", "world-to-camera")["/tf"]
            convention = PoseConvention("opengl", "world-to-camera")
            for before, after in zip(plain, turned):
                folder.expect_pose(after, convention.to_camera_to_world(to_matrix(before)))
            folder.doCleanups()

    def test_world_up_is_found_after_them(self):
        self.write_frames(2)
        for i in range(2):
            self.write(f"frame-{i:06d}.pose.txt", number_lines(to_given(pose(i), "opengl")))
        R = np.eye(4)
        R[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # -y to z about x
        for i, message in enumerate(self.convert("--camera-axes", "opengl", "--world-up=0,-1,0")["/tf"]):
            self.expect_pose(message, R @ pose(i))


def to_matrix(message):
    transform = message.transforms[0].transform
    t, q = transform.translation, transform.rotation
    T = np.eye(4)
    T[:3, :3] = from_quaternion([q.x, q.y, q.z, q.w])
    T[:3, 3] = [t.x, t.y, t.z]
    return T


class NeighbouringFrames(Folder):
    """A room of known shape: its depth images under one convention, its poses under another."""

    def write_room(self, units_per_m=1000.0, focal=ROOM.FOCAL, noise=0.0, holes=0.0, **given):
        random = np.random.RandomState(5)
        for i, (T, depth_m) in enumerate(zip(ROOM.poses, ROOM.depths_m)):
            depth_m = depth_m * (1.0 + noise * random.randn(*depth_m.shape))
            depth_m[random.rand(*depth_m.shape) < holes] = 0.0
            raw = np.clip(np.rint(depth_m * units_per_m), 0, 65534).astype(np.uint16)
            Image.fromarray(raw).save(self.path(f"frame-{i}.depth.png"))
            Image.new("RGB", ROOM.SIZE).save(self.path(f"frame-{i}.color.png"))
            self.write(f"frame-{i}.pose.txt", number_lines(to_given(T, **given)))
        self.write("camera-intrinsics.txt", f"{focal} {focal} {ROOM.CENTRE[0]} {ROOM.CENTRE[1]}")

    def expect_named(self, *parts, arguments=()):
        """One warning, which names the options that hold."""
        self.convert(*arguments)
        warning, = self.warnings()
        for part in ("neighbouring frames", *parts):
            self.assertIn(part, warning)
        return warning

    def expect_silent(self, *arguments):
        self.convert(*arguments)
        self.assertEqual(self.warnings(), [])

    def test_a_clean_room_is_silent(self):
        self.write_room()
        for stride in ("1", "5", "10"):
            self.expect_silent("--stride", stride)
        self.assertIn("depth differs by 0.", self.text)

    def test_noise_and_holes_are_silent(self):
        self.write_room(noise=0.02, holes=0.3)
        self.expect_silent()
        self.expect_silent("--stride", "5")

    def test_other_axes_are_named(self):
        for axes in ("opengl", "body"):
            self.write_room(axes=axes)
            warning = self.expect_named(f"--camera-axes {axes}")
            self.assertNotIn("--poses", warning)
            self.assertNotIn("scale", warning)
            self.expect_silent("--camera-axes", axes)

    def test_inverted_poses_are_named(self):
        self.write_room(direction="world-to-camera")
        warning = self.expect_named("--poses world-to-camera")
        self.assertNotIn("--camera-axes", warning)
        self.expect_silent("--poses", "world-to-camera")

    def test_both_are_named_together(self):
        self.write_room(axes="opengl", direction="world-to-camera")
        self.expect_named("--camera-axes opengl --poses world-to-camera")

    def test_options_that_are_wrong_are_named_too(self):
        self.write_room()
        self.expect_named("--camera-axes optical", arguments=["--camera-axes", "opengl"])
        self.expect_named("--poses camera-to-world", arguments=["--poses", "world-to-camera"])

    def test_depth_in_another_unit_is_named(self):
        self.write_room()
        for wrong in ("5000", "4000", "10000", "6553.5"):
            self.expect_named("--depth-scale 1000 ", "depth in another unit",
                              arguments=["--depth-scale", wrong])
        for units in (5000, 10000):
            self.write_room(units_per_m=units)
            self.expect_named(f"--depth-scale {units} ")

    def test_a_tum_folder_with_millimetres_is_told_its_unit(self):
        self.write_room()
        rgb, depths, poses = "", "", ""
        for i, T in enumerate(ROOM.poses):
            rgb += f"{100 + i / 30:.6f} frame-{i}.color.png\n"
            depths += f"{100 + i / 30:.6f} frame-{i}.depth.png\n"
            poses += trajectory_line(100 + i / 30, T)
        for name, text in (("rgb.txt", rgb), ("depth.txt", depths), ("groundtruth.txt", poses)):
            self.write(name, text)
        self.expect_named("--depth-scale 1000 ", "then 2", arguments=["--format", "tum"])
        self.expect_silent("--format", "tum", "--depth-scale", "1000")

    def test_poses_in_another_unit_are_named(self):
        self.write_room(scale_m=0.001)
        self.expect_named("--pose-scale 0.001", "poses in another unit")
        self.write_room(scale_m=1000.0)
        self.expect_named("--pose-scale 1000", "poses in another unit")

    def test_other_intrinsics_are_named(self):
        self.write_room(focal=ROOM.FOCAL / 2)
        self.expect_named("2 times the focal length")

    def test_poses_of_other_frames_are_told_not_to_agree(self):
        self.write_room()
        random = np.random.RandomState(3)
        order = random.permutation(len(ROOM.poses))
        for i, k in enumerate(order):
            T = ROOM.poses[k].copy()
            T[:3, 3] += random.randn(3) * 0.5
            self.write(f"frame-{i}.pose.txt", number_lines(T))
        self.expect_named("do not agree", "no other --poses")

    def test_a_camera_at_rest_tells_nothing(self):
        self.write_room()
        for i in range(len(ROOM.poses)):
            self.write(f"frame-{i}.pose.txt", number_lines(ROOM.poses[0]))
            self.write_bytes(f"frame-{i}.depth.png", self.read_bytes("frame-0.depth.png"))
        self.expect_silent()
        self.expect_silent("--camera-axes", "opengl")

    def test_one_frame_is_not_checked_and_says_so(self):
        self.write_room()
        self.expect_silent("--max-frames", "1")
        self.assertIn("poses not checked", self.text)

    def test_a_broken_image_does_not_stop_the_check(self):
        self.write_room(axes="opengl")
        self.cut("frame-0.depth.png")
        self.convert("--skip-broken")
        self.assertTrue(any("--camera-axes opengl" in line for line in self.warnings()))


class RealRecordings(Folder):
    """No false alarm on real and on rendered walks; every fault is named."""

    def link_frames(self, name, step):
        """A folder of every step-th frame of a recording."""
        source = os.path.join(SHARED, "data", name)
        if not os.path.isdir(source):
            self.skipTest(f"{name}: absent, TSG_SHARED names the folder that has data/{name}")
        self.input = os.path.join(self.temporary.name, f"{name}_{step}")
        os.makedirs(self.input)
        for file in os.listdir(source):
            number = file[len("frame-"):][:6]
            if file == "camera-intrinsics.txt" or (number.isdigit() and int(number) % step == 0):
                os.symlink(os.path.join(source, file), os.path.join(self.input, file))

    def expect_warning(self, text, *arguments):
        self.convert(*arguments)
        self.assertEqual(len(self.warnings()), 1, self.text)
        self.assertIn(text, self.warnings()[0])

    def check_walk(self, name):
        for step in (1, 5, 10):
            self.link_frames(name, step)
            few = ["--stride", str(200 // step)]  # to write; the check looks at those between, too
            self.convert(*few)
            self.assertEqual(self.warnings(), [])
            self.expect_warning("--camera-axes optical by", *few, "--camera-axes", "opengl")
            self.expect_warning("--poses camera-to-world by", *few, "--poses", "world-to-camera")
            self.expect_warning("--depth-scale 1000 by", *few, "--depth-scale", "5000")

    def test_kitchen(self):
        self.check_walk("kitchen")

    def test_house_a(self):
        self.check_walk("house_a")


if __name__ == "__main__":
    unittest.main()
