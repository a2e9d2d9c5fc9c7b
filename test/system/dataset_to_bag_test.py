# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dataset_to_bag on tiny folders of each layout, its bags read back."""
import os
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np
import yaml
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from dataset_folder import (COLOR, DEPTH, HEIGHT, INFO, INTRINSICS, WIDTH, Folder,  # noqa: E402
                            ReplicaFolder, ScanNetFolder, ThreeDMatchFolder, TumFolder, color,
                            color_pixels, depth, depth_pixels, number_line, number_lines, pose,
                            stamps_ns, trajectory_line, turn_z)
from datasets import conventions, layouts, numbered, rotation, trajectory, tum, world_up  # noqa: E402


class ThreeDMatch(ThreeDMatchFolder):
    def test_images_poses_and_intrinsics_arrive_unchanged(self):
        self.write_frames(3)
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1100000000, 1200000000])
        for i in range(3):
            image = messages[COLOR][i]
            self.assertEqual((image.encoding, image.header.frame_id),
                             ("rgb8", "camera_color_optical_frame"))
            np.testing.assert_array_equal(color_pixels(image), color(i))
            self.assertEqual(messages[DEPTH][i].encoding, "16UC1")
            np.testing.assert_array_equal(depth_pixels(messages[DEPTH][i]), depth(i))
            self.expect_pose(messages["/tf"][i], pose(i))
            self.assertEqual(messages["/tf"][i].transforms[0].header.stamp, image.header.stamp)
        info = messages[INFO][0]
        self.expect_camera(info, 10.0, 11.0, 4.0, 3.0)
        self.assertEqual((info.width, info.height), (WIDTH, HEIGHT))

    def test_messages_of_a_frame_are_recorded_pose_first(self):
        self.write_frames(2)
        self.convert()
        self.assertEqual(self.order, ["/tf", INFO, DEPTH, COLOR] * 2)

    def test_stride_and_max_frames_pick_frames(self):
        self.write_frames(6)
        messages = self.convert("--rate", "10", "--stride", "2", "--max-frames", "2")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1200000000])

    def test_timestamps_file_is_used_to_the_nanosecond(self):
        self.write_frames(2)
        self.write("timestamps.txt", "1305031102.175304001\n1305031102.211214002\n")
        messages = self.convert()
        self.assertEqual(stamps_ns(messages[DEPTH]), [1305031102175304001, 1305031102211214002])

    def test_timestamps_of_another_number_are_refused(self):
        self.write_frames(2)
        self.write("timestamps.txt", "0.0\n")
        self.expect_error("timestamps.txt", "1 lines", "expected one per frame, 2")

    def test_frames_that_lost_tracking_are_skipped_and_counted(self):
        self.write_frames(4)
        self.write("frame-000001.pose.txt", "-inf " * 16)
        self.write("frame-000002.pose.txt", "NaN " * 16)
        status, text = self.run_command("--rate", "10")
        self.assertEqual(status, 0)
        self.assertIn("2 frames skipped", text)
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1300000000])

    def test_invalid_depth_65535_becomes_0(self):
        self.write_frames(1)
        pixels = depth(0)
        pixels[2, 3] = 65535
        self.save("frame-000000.depth.png", pixels)
        self.assertEqual(depth_pixels(self.convert()[DEPTH][0])[2, 3], 0)

    def test_intrinsics_above_the_sequence_folder_are_found(self):
        self.write_frames(1)
        os.rename(self.path("camera-intrinsics.txt"),
                  os.path.join(self.temporary.name, "camera-intrinsics.txt"))
        self.assertEqual(self.convert()[INFO][0].K[0], 10.0)

    def test_broken_pose_file_names_file_and_count(self):
        self.write_frames(1)
        self.write("frame-000000.pose.txt", "1 2 3\n")
        self.expect_error("frame-000000.pose.txt", "3 numbers", "expected 16", "--skip-broken")

    def test_a_line_of_a_pose_file_that_is_no_number_is_named(self):
        self.write_frames(1)
        self.write("frame-000000.pose.txt", number_lines(pose(0)).replace("-2.", "x2.", 1))
        self.expect_error("frame-000000.pose.txt:2", "expected numbers")

    def test_a_pose_written_column_by_column_is_refused(self):
        self.write_frames(2)
        self.write("frame-000001.pose.txt", number_lines(pose(1).T))
        self.expect_error("frame-000001.pose.txt", "last row 0.1 -0.2 1.4 1", "transposed")

    def test_mirrored_and_scaled_poses_are_counted_by_their_fault(self):
        self.write_frames(3)
        self.write("frame-000000.pose.txt", number_lines(np.diag([1.0, -1.0, 1.0, 1.0])))
        self.write("frame-000001.pose.txt", number_lines(np.diag([2.0, 2.0, 2.0, 1.0])))
        self.convert()
        self.assertIn("1 frames skipped: the pose mirrors", self.text)
        self.assertIn("1 frames skipped: the pose's upper left 3x3 block is not a rotation", self.text)

    def test_windows_not_a_number_is_lost_tracking(self):
        self.write_frames(2)
        self.write("frame-000000.pose.txt", "-1.#IND " * 16)
        self.convert()
        self.assertIn("1 frames skipped: no valid pose", self.text)

    def test_numbers_without_leading_zeros_are_in_natural_order(self):
        for number in (0, 9, 10, 100):
            self.save(f"frame-{number}.color.png", color(number % 7))
            self.save(f"frame-{number}.depth.png", depth(number))
            self.write(f"frame-{number}.pose.txt", number_lines(pose(number)))
        self.write("camera-intrinsics.txt", INTRINSICS)
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]),
                         [1000000000, 1900000000, 2000000000, 11000000000])
        for message, number in zip(messages["/tf"], (0, 9, 10, 100)):
            self.expect_pose(message, pose(number))

    def test_an_option_without_effect_is_told(self):
        self.write_frames(2)
        self.convert("--sync-tolerance", "0.1", "--match-size", "color-to-depth")
        self.assertIn("--sync-tolerance 0.1 is not used", self.warnings()[0])
        self.assertIn("--match-size color-to-depth is not used", self.warnings()[1])
        self.write("timestamps.txt", "10.0\n10.1\n")
        self.convert("--rate", "10")
        self.assertIn("--rate 10 is not used: stamps come from", self.warnings()[0])

    def test_mixed_padding_belongs_together_by_number(self):
        self.write_frames(2)
        os.rename(self.path("frame-000001.depth.png"), self.path("frame-1.depth.png"))
        np.testing.assert_array_equal(depth_pixels(self.convert()[DEPTH][1]), depth(1))

    def test_two_files_of_one_number_are_refused(self):
        self.write_frames(2)
        self.save("frame-1.depth.png", depth(1))
        self.expect_error("frame-000001.depth.png", "frame-1.depth.png", "same number")

    def test_absent_images_and_poses_are_counted_and_shift_nothing(self):
        self.write_frames(5)
        os.remove(self.path("frame-000001.depth.png"))
        os.remove(self.path("frame-000002.color.png"))
        os.remove(self.path("frame-000003.pose.txt"))
        messages = self.convert("--rate", "10")
        for kind in ("depth image", "colour image", "pose"):
            self.assertIn(f"1 frames skipped: no {kind} of their number", self.text)
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1400000000])
        np.testing.assert_array_equal(depth_pixels(messages[DEPTH][1]), depth(4))
        self.expect_pose(messages["/tf"][1], pose(4))

    def test_timestamps_of_all_frames_serve_a_thinned_out_folder(self):
        for number in (0, 2, 4):
            self.write_frame(number)
        self.write("camera-intrinsics.txt", INTRINSICS)
        self.write("timestamps.txt", "".join(f"{10 + 0.1 * k:.1f}\n" for k in range(6)))
        self.assertEqual(stamps_ns(self.convert()[COLOR]), [10000000000, 10200000000, 10400000000])

    def test_timestamps_in_another_unit_are_refused_by_name(self):
        self.write_frames(2)
        for stamp, unit in (("1305031102175304001", "nanoseconds"), ("1305031102175304", "micro"),
                            ("1305031102175", "milliseconds")):
            self.write("timestamps.txt", f"{stamp}\n{stamp}\n")
            self.expect_error("timestamps.txt:1", f"it looks like {unit}")

    def test_stamps_that_do_not_rise_are_refused(self):
        self.write_frames(3)
        self.write("timestamps.txt", "0\n0\n0\n")
        self.expect_error("2 of 3 frames have a stamp that is not after the one before")

    def test_one_repeated_stamp_is_counted(self):
        self.write_frames(3)
        self.write("timestamps.txt", "10\n10\n10.1\n")
        self.assertEqual(stamps_ns(self.convert()[COLOR]), [10000000000, 10100000000])
        self.assertIn("1 frames skipped: stamp not after the one before", self.text)

    def test_stamps_far_apart_are_remarked(self):
        self.write_frames(3)
        self.write("timestamps.txt", "0\n33\n66\n")
        self.convert()
        self.assertIn("33 s apart", self.warnings()[0])

    def test_numbers_that_are_stamps_of_some_unit_follow_the_rate(self):
        for i, number in enumerate((1305031102175304, 1305031102211214)):
            self.save(f"frame-{number}.color.png", color(i))
            self.save(f"frame-{number}.depth.png", depth(i))
            self.write(f"frame-{number}.pose.txt", number_lines(pose(i)))
        self.write("camera-intrinsics.txt", INTRINSICS)
        self.assertEqual(stamps_ns(self.convert("--rate", "10")[COLOR]), [1000000000, 1100000000])

    def test_info_file_gives_cameras_sizes_and_depth_unit(self):
        """As 3RScan and ScanNet's C++ exporter write it; their depth is .pgm."""
        for i in range(2):
            self.save(f"frame-{i:06d}.color.jpg", color(i, 24, 18))
            Image.fromarray(depth(i, 12, 9).astype(np.int32)).save(
                self.path(f"frame-{i:06d}.depth.pgm"))
            self.write(f"frame-{i:06d}.pose.txt", number_lines(pose(i)))
        self.write("_info.txt", "m_versionNumber = 4\nm_sensorName = StructureSensor\n"
                   "m_colorWidth = 24\nm_colorHeight = 18\nm_depthWidth = 12\nm_depthHeight = 9\n"
                   "m_depthShift = 500\n"
                   "m_calibrationColorIntrinsic = 20 0 11.5 0 0 21 8.5 0 0 0 1 0 0 0 0 1 \n"
                   "m_calibrationDepthIntrinsic = 10 0 5.5 0 0 10.5 4 0 0 0 1 0 0 0 0 1 \n"
                   "m_frames.size = 2\n")
        messages = self.convert()
        self.expect_camera(messages[INFO][0], 10.0, 10.5, 5.5, 4.0)
        np.testing.assert_allclose(depth_pixels(messages[DEPTH][1]), depth(1, 12, 9) / 500.0, rtol=1e-6)

    def test_given_direction_becomes_z(self):
        self.write_frames(2)
        turned = self.convert("--world-up=0,-2,0")["/tf"]
        R = np.eye(4)
        R[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # -y to z about x
        for i, message in enumerate(turned):
            self.expect_pose(message, R @ pose(i))

    def test_level_is_refused_where_the_camera_does_not_turn(self):
        self.write_frames(3)
        for i in range(3):
            self.write(f"frame-{i:06d}.pose.txt", number_lines(pose(0)))
        self.expect_error("--world-up", "turns too little", arguments=["--world-up", "level"])


class WorldUp(unittest.TestCase):
    def test_level_finds_up_of_a_camera_that_pans_and_tilts(self):
        rng = np.random.default_rng(1)
        for _ in range(20):
            up = rng.normal(size=3)
            up /= np.linalg.norm(up)
            R_world_level = world_up.find_rotation(up).T
            poses = []
            for _ in range(50):
                yaw, pitch = rng.uniform(-1.5, 1.5), rng.uniform(-1.0, 0.5)
                forward = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch),
                                    np.sin(pitch)])
                right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
                T = np.eye(4)
                T[:3, :3] = R_world_level @ np.column_stack([right, np.cross(forward, right), forward])
                poses.append(T)
            np.testing.assert_allclose(world_up.find_level_up(poses), up, atol=1e-9)

    def test_rotation_takes_up_to_z(self):
        rng = np.random.default_rng(2)
        for up in [*rng.normal(size=(50, 3)), (0, 0, 1), (0, 0, -1)]:
            up = np.asarray(up, float) / np.linalg.norm(up)
            R = world_up.find_rotation(up)
            np.testing.assert_allclose(R @ up, [0, 0, 1], atol=1e-12)
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            self.assertGreater(np.linalg.det(R), 0.0)

    def test_directions_are_checked(self):
        for text in ("0,0,0", "1,2", "nan,0,1", "up"):
            with self.assertRaises(ValueError):
                world_up.parse_up(text)


class RecordedLabels(ThreeDMatchFolder):
    def write_labels(self):
        self.write_frames(2)
        labels = np.zeros((HEIGHT, WIDTH), np.uint16)
        labels[0, :3], labels[1, :2], labels[2, 0] = 70, 5, 300
        self.save("frame-000000.labels.png", labels)
        self.save("frame-000001.labels.png", np.full((HEIGHT, WIDTH), 70, np.uint16))
        np.savez(self.path("embeddings.npz"), instance_ids=np.int32([5, 70]),
                 embeddings=np.float32([[1, 0, 0], [0, 1, 0]]),
                 task_names=np.array(["a: mug", "b"]),
                 task_embeddings=np.float32([[0.25, 0.5, 0], [0, 0, 1]]))
        np.savez(self.path("image_embeddings.npz"),
                 frame_embeddings=np.float32([[0, 0, 1], [0, 0.5, 0.5]]),
                 room_names=np.array(["kitchen"]), room_embeddings=np.float32([[0, 1, 0]]))

    def test_labels_become_segments_numbered_from_1_with_their_embeddings(self):
        self.write_labels()
        first, second = self.convert()["/segmentation"]
        self.assertEqual(self.order[:5], ["/tf", INFO, DEPTH, COLOR, "/segmentation"])
        labels = np.frombuffer(first.labels.data, "<u2").reshape(HEIGHT, WIDTH)
        expected = np.zeros((HEIGHT, WIDTH))
        expected[0, :3], expected[1, :2], expected[2, 0] = 2, 1, 3
        np.testing.assert_array_equal(labels, expected)
        self.assertEqual(first.embedding_size, 3)
        self.assertEqual(list(first.embeddings), [1, 0, 0, 0, 1, 0, 0, 0, 0])
        self.assertEqual(list(first.confidences), [1, 1, 1])
        self.assertEqual(list(second.image_embedding), [0, 0.5, 0.5])
        self.assertEqual(np.frombuffer(second.labels.data, "<u2").tolist(), [1] * HEIGHT * WIDTH)
        self.assertEqual(list(second.embeddings), [0, 1, 0])

    def test_tasks_and_rooms_become_task_files_beside_the_bag(self):
        self.write_labels()
        self.convert()
        stem = self.output[: -len(".bag")]
        with open(stem + ".object_tasks.yaml") as file:
            tasks = yaml.safe_load(file)
        self.assertEqual(tasks, {"tasks": [{"name": "a: mug", "embedding": [0.25, 0.5, 0]},
                                           {"name": "b", "embedding": [0, 0, 1]}]})
        with open(stem + ".place_tasks.yaml") as file:
            self.assertEqual(yaml.safe_load(file)["tasks"][0]["name"], "kitchen")

    def test_image_embeddings_of_another_number_of_frames_are_refused(self):
        self.write_labels()
        np.savez(self.path("image_embeddings.npz"), frame_embeddings=np.zeros((5, 3), np.float32),
                 room_names=np.array(["kitchen"]), room_embeddings=np.float32([[0, 1, 0]]))
        self.expect_error("image_embeddings.npz", "(5, 3)", "(2, 3)")

    def test_rows_of_image_embeddings_stay_with_their_frames_when_some_are_skipped(self):
        self.write_labels()
        os.remove(self.path("frame-000000.depth.png"))
        only, = self.convert()["/segmentation"]
        self.assertEqual(list(only.image_embedding), [0, 0.5, 0.5])

    def test_frames_without_a_label_image_are_counted(self):
        self.write_labels()
        os.remove(self.path("frame-000001.labels.png"))
        self.assertEqual(len(self.convert()["/segmentation"]), 1)
        self.assertIn("1 of 2 frames have no label image", self.warnings()[0])

    def test_broken_tables_are_named(self):
        for name in ("embeddings.npz", "image_embeddings.npz"):
            for data in (b"", b"PK\x03\x04 cut", b"no archive"):
                self.write_labels()
                self.write_bytes(name, data)
                self.expect_error(name, "expected an .npz with the arrays")

    def test_labels_of_eight_bits_are_ids_too(self):
        self.write_labels()
        self.save("frame-000001.labels.png", np.full((HEIGHT, WIDTH), 70, np.uint8))
        self.assertEqual(list(self.convert()["/segmentation"][1].embeddings), [0, 1, 0])

    def test_labels_of_a_third_size_are_refused(self):
        self.write_labels()
        self.save("frame-000001.labels.png", np.full((3, 3), 70, np.uint8))
        self.expect_error("frame-000001.labels.png", "3x3", "8x6")

    def test_labels_go_with_the_images_that_have_their_size(self):
        """Colour 16x12, depth 8x6: labels of either size end at the output's, nearest, unmixed."""
        for size in ((16, 12), (8, 6)):
            self.write_labels()
            self.write("camera-intrinsics.txt", "20 0 8\n0 22 6\n0 0 1\n")
            for i in range(2):
                self.save(f"frame-{i:06d}.color.png", color(i, 16, 12))
                labels = np.full((size[1], size[0]), 70, np.uint16)
                labels[:, : size[0] // 2] = 5
                self.save(f"frame-{i:06d}.labels.png", labels)
            for mode, shape in (("color-to-depth", (6, 8)), ("depth-to-color", (12, 16))):
                message = self.convert("--match-size", mode)["/segmentation"][0]
                labels = np.frombuffer(message.labels.data, "<u2").reshape(shape)
                np.testing.assert_array_equal(labels[:, : shape[1] // 2], 1)
                np.testing.assert_array_equal(labels[:, shape[1] // 2:], 2)


class Tum(TumFolder):
    def test_pairs_by_nearest_stamp_with_interpolated_pose_and_metric_depth(self):
        self.write_frames()
        messages = self.convert()
        self.assertEqual(stamps_ns(messages[COLOR]), [10000000000, 10200000000])
        self.assertEqual(stamps_ns(messages[DEPTH]), stamps_ns(messages[COLOR]))
        half_way = turn_z(np.pi / 4)
        half_way[:3, 3] = [0.5, 0.0, 1.0]
        self.expect_pose(messages["/tf"][0], half_way)
        self.assertEqual(messages[DEPTH][1].encoding, "32FC1")
        np.testing.assert_allclose(depth_pixels(messages[DEPTH][1]), depth(2) / 5000.0, rtol=1e-6)

    def test_images_outside_the_ground_truth_are_skipped_and_counted(self):
        self.write_frames()
        self.write("groundtruth.txt", "10.15 0 0 1 0 0 0 1\n10.25 0 0 1 0 0 0 1\n")
        self.assertEqual(stamps_ns(self.convert()[COLOR]), [10200000000])
        self.assertIn("1 frames skipped: no valid pose within groundtruth.txt's time", self.text)

    def test_no_pose_is_interpolated_across_a_gap(self):
        self.assertIsNone(trajectory.interpolate([0, 600000000], [None, None], 300000000))

    def test_association_uses_every_image_once_nearest_first(self):
        self.assertEqual(tum.associate([100, 110], [108, 130], 25), [(1, 0)])
        random = np.random.RandomState(3)
        for _ in range(50):
            first = sorted(random.choice(300, 12, replace=False).tolist())
            second = sorted(random.choice(300, 15, replace=False).tolist())
            self.assertEqual(tum.associate(first, second, 20), brute_force_pairs(first, second, 20))

    def test_a_line_that_is_no_stamp_is_named(self):
        self.write_frames()
        self.write("rgb.txt", "1.0 rgb/0.png\nnow rgb/1.png\n")
        self.expect_error("rgb.txt:2", "'now'", "expected seconds")

    def test_images_without_a_partner_are_counted_with_the_smallest_distance(self):
        self.write_frames()
        self.convert()
        self.assertIn("1 colour images skipped: no depth image of their own within 0.02 s (smallest "
                      "distance found: 0.03 s, --sync-tolerance 0.032 pairs them)", self.text)
        self.assertIn("1 depth images skipped", self.text)

    def test_sync_tolerance_pairs_what_lies_further_apart(self):
        self.write_frames()
        self.assertEqual(len(self.convert("--sync-tolerance", "0.032")[COLOR]), 3)

    def test_no_pair_at_all_tells_the_smallest_distance(self):
        self.write_frames()
        self.write("depth.txt", "10.033 depth/0.png\n10.135 depth/1.png\n")
        self.expect_error("rgb.txt", "depth.txt", "within 0.02 s", "smallest distance found: 0.033 s",
                          "--sync-tolerance 0.035")

    def test_lists_of_other_clocks_are_told_apart_from_a_small_tolerance(self):
        self.write_frames()
        self.write("depth.txt", "1305031102.0 depth/0.png\n")
        self.expect_error("different times or clocks")

    def test_associations_take_the_place_of_the_two_lists_in_either_order(self):
        for first, second in (("rgb", "depth"), ("depth", "rgb")):
            self.write_frames()
            os.remove(self.path("rgb.txt"))
            os.remove(self.path("depth.txt"))
            stamps = {"rgb": 10.0, "depth": 10.005}
            self.write("associations.txt", "".join(
                f"{stamps[first] + 0.1 * i:.6f} {first}/{i}.png "
                f"{stamps[second] + 0.1 * i:.6f} {second}/{i}.png\n" for i in range(3)))
            messages = self.convert()
            self.assertEqual(stamps_ns(messages[COLOR]), [10000000000, 10100000000, 10200000000])
            np.testing.assert_allclose(depth_pixels(messages[DEPTH][1]), depth(1) / 5000.0, rtol=1e-6)

    def test_an_association_without_a_depth_image_is_named(self):
        self.write_frames()
        os.remove(self.path("rgb.txt"))
        self.write("associations.txt", "1 a/0.png 1 b/0.png\n")
        self.expect_error("associations.txt:1", "'depth'")

    def test_frame_numbers_in_place_of_stamps_follow_the_rate(self):
        """ICL-NUIM's lists."""
        self.write_frames()
        os.remove(self.path("rgb.txt"))
        self.write("associations.txt", "".join(f"{i} depth/{i}.png {i} rgb/{i}.png\n"
                                               for i in range(3)))
        self.write("groundtruth.txt", "".join(trajectory_line(i, pose(i)) for i in range(3)))
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1100000000, 1200000000])
        self.expect_pose(messages["/tf"][2], pose(2))
        self.assertIn("taken as frame numbers", self.text)

    def test_without_ground_truth_a_trajectory_file_gives_the_poses(self):
        self.write_frames()
        os.remove(self.path("groundtruth.txt"))
        path = self.write("slam/trajectory.txt",
                          trajectory_line(9.0, pose(0)) + trajectory_line(9.4, pose(0))
                          + trajectory_line(9.8, pose(3)) + trajectory_line(10.3, pose(3)))
        self.expect_error("groundtruth.txt", "--trajectory")
        messages = self.convert("--trajectory", path)
        self.expect_pose(messages["/tf"][0], pose(3))

    def test_a_trajectory_of_another_time_tells_both_times(self):
        self.write_frames()
        path = self.write("other.txt", trajectory_line(100.0, pose(0)) + trajectory_line(101, pose(0)))
        self.expect_error("other.txt", "100.000 s to 101.000 s", "10.000 s to 10.200 s",
                          arguments=["--trajectory", path])

    def test_a_listed_file_that_is_absent_is_named(self):
        self.write_frames()
        os.remove(self.path("depth/0.png"))
        self.expect_error("depth/0.png", "absent", "--skip-broken")

    def test_freiburg_3_has_its_own_intrinsics_by_the_folders_name(self):
        for name, fx in (("rgbd_dataset_freiburg3_long_office", 535.4), ("fr3_office", 535.4),
                         ("rgbd_dataset_freiburg1_desk", 525.0), ("fr31", 525.0)):
            self.assertEqual(tum.find_camera("/data/" + name).fx_px, fx)


def brute_force_pairs(first, second, max_gap):
    """Takes the closest free pair over and over."""
    free_first, free_second, pairs = set(range(len(first))), set(range(len(second))), []
    while True:
        gaps = [(abs(first[i] - second[j]), i, j) for i in free_first for j in free_second]
        gaps = [gap for gap in gaps if gap[0] <= max_gap]
        if not gaps:
            return sorted(pairs)
        _, i, j = min(gaps)
        free_first.remove(i)
        free_second.remove(j)
        pairs.append((i, j))


class TrajectoryFile(ThreeDMatchFolder):
    """--trajectory, TUM's format, on images with stamps of their own."""

    def write_stamped(self):
        self.write_frames(3)
        self.write("timestamps.txt", "10.0\n10.1\n10.2\n")
        return self.write("t.txt", "# stamp tx ty tz qx qy qz qw\n" + "".join(
            trajectory_line(10.0 + 0.1 * i, pose(i + 2)) for i in range(3)))

    def test_it_takes_the_place_of_the_folders_poses(self):
        messages = self.convert("--trajectory", self.write_stamped())
        for i, message in enumerate(messages["/tf"]):
            self.expect_pose(message, pose(i + 2))

    def test_folders_without_poses_are_known_with_it(self):
        path = self.write_stamped()
        for i in range(3):
            os.remove(self.path(f"frame-{i:06d}.pose.txt"))
        self.expect_error("frame-N.pose.txt")
        self.assertEqual(len(self.convert("--trajectory", path)[COLOR]), 3)

    def test_images_without_stamps_are_refused_with_it(self):
        path = self.write_stamped()
        os.remove(self.path("timestamps.txt"))
        self.expect_error("--trajectory", "no stamps", "timestamps.txt",
                          arguments=["--trajectory", path])

    def test_frames_beyond_its_end_are_counted(self):
        path = self.write_stamped()
        self.write("timestamps.txt", "10.0\n10.1\n10.3\n")
        self.assertEqual(len(self.convert("--trajectory", path)[COLOR]), 2)
        self.assertIn("1 frames skipped: no pose at their stamp in", self.text)

    def test_broken_lines_are_named_and_can_be_skipped(self):
        for line, fault in (("10.05 1 2 3\n", "4 numbers"), ("10.05 0 0 0 0 0 0 x\n", "expected num"),
                            ("10.05 0 0 0 1 1 1 1\n", "quaternion of length 2"),
                            ("now 0 0 0 0 0 0 1\n", "expected seconds")):
            path = self.write_stamped()
            with open(path, "a") as file:
                file.write(line)
            self.expect_error("t.txt:5", fault, "--skip-broken", arguments=["--trajectory", path])
            self.convert("--trajectory", path, "--skip-broken")
            self.assertIn("1 broken files or lines skipped", self.text)
            os.remove(self.output)

    def test_poses_of_lost_tracking_are_counted(self):
        path = self.write_stamped()
        self.write("t.txt", trajectory_line(10.0, pose(0)) + "10.1 0 0 0 0 0 0 0\n"
                   + "10.2 nan nan nan nan nan nan nan\n")
        self.assertEqual(len(self.convert("--trajectory", path)[COLOR]), 1)
        self.assertIn("2 frames skipped: no valid pose", self.text)

    def test_an_absent_trajectory_is_named(self):
        self.write_frames(1)
        self.expect_error("/no/such.txt: absent", arguments=["--trajectory", "/no/such.txt"])


class Replica(ReplicaFolder):
    def test_frames_follow_the_trajectory_at_the_given_rate(self):
        self.write_frames()
        messages = self.convert("--rate", "20")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1050000000])
        self.expect_pose(messages["/tf"][1], pose(1))
        np.testing.assert_allclose(depth_pixels(messages[DEPTH][1]), depth(1) * 10 / 6553.5,
                                   rtol=1e-6)
        np.testing.assert_allclose(color_pixels(messages[COLOR][1]), color(1), atol=4)

    def test_numbers_without_leading_zeros_get_the_pose_of_their_line(self):
        self.write_frames(range(12), name="{}")
        for i, message in enumerate(self.convert()["/tf"]):
            self.expect_pose(message, pose(i))

    def test_lines_of_the_trajectory_are_frame_numbers_where_images_are_absent(self):
        self.write_frames(range(6))
        for name in ("frame000002.jpg", "depth000002.png", "depth000004.png"):
            os.remove(self.path("results", name))
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [int(1e9 + 1e8 * i) for i in (0, 1, 3, 5)])
        for message, number in zip(messages["/tf"], (0, 1, 3, 5)):
            self.expect_pose(message, pose(number))
        self.assertIn("1 poses skipped: no image of their number", self.text)
        self.assertIn("1 frames skipped: no depth image of their number", self.text)

    def test_frames_counted_from_1_or_thinned_out_with_their_trajectory_are_taken_in_order(self):
        for numbers in ((1, 2, 3), (0, 10, 20)):
            self.write_frames(numbers)
            self.write("traj.txt", "".join(number_line(pose(i)) for i in range(3)))
            for i, message in enumerate(self.convert()["/tf"]):
                self.expect_pose(message, pose(i))
            for number in numbers:
                os.remove(self.path(f"results/frame{number:06d}.jpg"))
                os.remove(self.path(f"results/depth{number:06d}.png"))

    def test_trajectory_of_another_length_is_refused(self):
        self.write_frames()
        for text, count in (("", "0 poses"), (number_line(pose(0)), "1 poses")):
            self.write("traj.txt", text)
            self.expect_error("traj.txt", count, "for 2 frames")

    def test_a_broken_line_is_named_and_keeps_its_place_when_skipped(self):
        self.write_frames(range(3))
        self.write("traj.txt", number_line(pose(0)) + "1 2 3\n" + number_line(pose(2)))
        self.expect_error("traj.txt:2", "3 numbers", "expected 16")
        messages = self.convert("--skip-broken")
        self.expect_pose(messages["/tf"][1], pose(2))
        self.assertIn("1 frames skipped: the pose is broken", self.text)

    def test_cam_params_are_used_where_there_are_some(self):
        self.write_frames()
        os.remove(self.path("camera-intrinsics.txt"))
        self.write("cam_params.json", '{"camera": {"w": 8, "h": 6, "fx": 10, "fy": 11, "cx": 4, '
                   '"cy": 3, "scale": 1000}}')
        messages = self.convert()
        self.expect_camera(messages[INFO][0], 10, 11, 4, 3)
        self.assertEqual(messages[DEPTH][0].encoding, "16UC1")

    def test_cam_params_without_scale_are_refused(self):
        self.write_frames()
        self.write("cam_params.json", '{"camera": {"fx": 10, "fy": 11, "cx": 4, "cy": 3}}')
        self.expect_error("cam_params.json", "scale")


class ScanNet(ScanNetFolder):
    def test_frames_have_depths_size_and_intrinsics_and_their_own_pose(self):
        self.write_frames((0, 1, 2, 9, 10, 11))
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]),
                         [int(1e9 + 1e8 * i) for i in (0, 1, 2, 9, 10, 11)])
        for k, i in enumerate((0, 1, 2, 9, 10, 11)):
            self.expect_pose(messages["/tf"][k], pose(i))
            np.testing.assert_array_equal(depth_pixels(messages[DEPTH][k]), depth(i, 12, 9))
            np.testing.assert_allclose(color_pixels(messages[COLOR][k]), color(i, 12, 9), atol=4)
        self.expect_camera(messages[INFO][0], 10.0, 10.5, 5.5, 4.0)
        self.assertEqual((messages[INFO][0].width, messages[INFO][0].height), (12, 9))
        self.assertIn("colour 24x18 brought to depth's 12x9 by their intrinsics", self.text)

    def test_frames_that_lost_tracking_are_counted(self):
        self.write_frames()
        self.write("pose/1.txt", "-inf -inf -inf -inf\n" * 4)
        self.assertEqual(len(self.convert()[COLOR]), 2)
        self.assertIn("1 frames skipped: no valid pose", self.text)

    def test_intrinsics_are_found_where_exporters_put_them(self):
        self.write_frames()
        for name in ("intrinsic_{}.txt", "intrinsics_{}.txt", "intrinsics/intrinsic_{}.txt"):
            for kind in ("color", "depth"):
                os.remove(self.path(f"intrinsic/intrinsic_{kind}.txt"))
            self.write_intrinsics(name)
            self.expect_camera(self.convert()[INFO][0], 10.0, 10.5, 5.5, 4.0)
            for kind in ("color", "depth"):
                os.rename(self.path(name.format(kind)), self.path(f"intrinsic/intrinsic_{kind}.txt"))

    def test_the_scenes_own_text_file_gives_intrinsics(self):
        self.write_frames()
        for kind in ("color", "depth"):
            os.remove(self.path(f"intrinsic/intrinsic_{kind}.txt"))
        self.expect_error("no intrinsics for its 24x18 images", "--intrinsics")
        self.write("input.txt", "appVersionId = 121\ncolorHeight = 18\ncolorWidth = 24\n"
                   "depthHeight = 9\ndepthWidth = 12\nfx_color = 20\nfx_depth = 10\nfy_color = 21\n"
                   "fy_depth = 10.5\nmx_color = 11.5\nmx_depth = 5.5\nmy_color = 8.5\n"
                   "my_depth = 4.0\nsceneType = Bedroom / Hotel\n")
        self.expect_camera(self.convert()[INFO][0], 10.0, 10.5, 5.5, 4.0)

    def test_padded_names_and_folders_called_rgb_and_poses_are_the_same_layout(self):
        self.write_frames((0, 100), name="{:06d}")
        os.rename(self.path("color"), os.path.join(self.input, "rgb"))
        os.rename(self.path("pose"), os.path.join(self.input, "poses"))
        self.assertEqual(len(self.convert()[COLOR]), 2)

    def test_colour_exported_at_depths_size_takes_depths_intrinsics(self):
        """SensReader resizes colour and writes the intrinsics of the large images all the same."""
        self.write_frames()
        for i in range(3):
            self.save(f"color/{i}.jpg", color(i, 12, 9))
        self.write("intrinsic/intrinsic_color.txt", "200 0 115 0\n0 210 85 0\n0 0 1 0\n0 0 0 1\n")
        self.expect_camera(self.convert()[INFO][0], 10.0, 10.5, 5.5, 4.0)
        self.assertIn("is for larger images", self.text)

    def test_one_of_the_two_intrinsics_is_enough(self):
        for absent, expected in (("depth", (10, 10.5, 5.5, 4.0)), ("color", (10, 10.5, 5.5, 4.0))):
            self.write_frames()
            os.remove(self.path(f"intrinsic/intrinsic_{absent}.txt"))
            self.expect_camera(self.convert()[INFO][0], *expected)
            self.assertIn("by the ratio of the sizes", self.text)

    def test_poses_without_images_are_counted_and_images_keep_their_rows(self):
        """Images thinned out, poses not; one row of embeddings for each image."""
        self.write_frames((0, 2))
        for i in range(4):
            self.write(f"pose/{i}.txt", number_lines(pose(i)))
        for i in (0, 2):
            self.save(f"labels/{i}.png", np.full((18, 24), 3, np.uint16))
        np.savez(self.path("embeddings.npz"), instance_ids=np.int32([3]),
                 embeddings=np.float32([[0, 1]]), task_names=np.array(["a"]),
                 task_embeddings=np.float32([[1, 0]]))
        np.savez(self.path("image_embeddings.npz"), frame_embeddings=np.float32([[1, 0], [0, 1]]),
                 room_names=np.array(["a"]), room_embeddings=np.float32([[1, 0]]))
        messages = self.convert()["/segmentation"]
        self.assertEqual([list(m.image_embedding) for m in messages], [[1, 0], [0, 1]])
        self.assertIn("2 poses skipped: no image of their number", self.text)

    def test_extrinsics_that_differ_are_remarked_equal_ones_not(self):
        self.write_frames()
        self.write("intrinsic/extrinsic_color.txt", number_lines(np.eye(4)))
        self.write("intrinsic/extrinsic_depth.txt", number_lines(np.eye(4)))
        self.convert()
        self.assertNotIn("extrinsic", self.text)
        T = np.eye(4)
        T[0, 3] = 0.05
        self.write("intrinsic/extrinsic_depth.txt", number_lines(T))
        self.convert()
        self.assertIn("differ (by 0.050 m)", self.text)

    def test_instance_images_with_embeddings_become_segments(self):
        self.write_frames()
        for i in range(3):
            self.save(f"instance-filt/{i}.png", np.full((18, 24), 3, np.uint8))
        np.savez(self.path("embeddings.npz"), instance_ids=np.int32([3]),
                 embeddings=np.float32([[0, 1]]), task_names=np.array(["a"]),
                 task_embeddings=np.float32([[1, 0]]))
        message = self.convert()["/segmentation"][2]
        self.assertEqual((message.labels.width, message.labels.height), (12, 9))
        self.assertEqual(list(message.embeddings), [0, 1])


class Layouts(Folder):
    def test_an_unknown_folder_tells_what_was_looked_for_and_found(self):
        self.write("images/0.jpg", "")
        self.write("notes.txt", "")
        text = self.expect_error(self.input, "0 layouts match", "Found: images/ (1 .jpg), 1 .txt", "--format")
        for name, layout in layouts.LAYOUTS.items():
            self.assertIn(f"{name}: {layout.LOOKS_FOR}", text)

    def test_what_the_folder_is_instead_is_said(self):
        for name, hint in (("scene0000_00.sens", "SensReader"), ("data.zip", "unpack"),
                           ("transforms.json", "NeRF"), ("walk.bag", "process_bag")):
            path = self.write(name, "x")
            self.expect_error(hint)
            os.remove(path)

    def test_a_subfolder_that_fits_is_named(self):
        self.input, above = os.path.join(self.input, "scene", "exported"), self.input
        ScanNetFolder.write_frames(self)
        self.input = os.path.join(above, "scene")
        self.expect_error("Subfolders that fit: exported (scannet)")

    write_frame = ScanNetFolder.write_frame
    write_intrinsics = ScanNetFolder.write_intrinsics
    COLOR_SIZE, DEPTH_SIZE = ScanNetFolder.COLOR_SIZE, ScanNetFolder.DEPTH_SIZE

    def test_no_layout_is_taken_for_another(self):
        """Each layout's folder, and folders that share names with one, under every reader."""
        writers = {"3dmatch": lambda self: ThreeDMatchFolder.write_frames(self, 2),
                   "tum": TumFolder.write_frames, "replica": ReplicaFolder.write_frames,
                   "scannet": ScanNetFolder.write_frames}
        for name, write in writers.items():
            self.input = os.path.join(self.temporary.name, name)
            self.write_frame = (ThreeDMatchFolder if name == "3dmatch"
                                else ScanNetFolder).write_frame.__get__(self)
            write(self)
            self.assertEqual(layouts.list_matches(self.input, False), [name])

    def test_lookalikes_are_not_taken(self):
        def expect_none(has_trajectory=False):
            self.assertEqual(layouts.list_matches(self.input, has_trajectory), [])
        self.write("frame-000000.pose.txt", number_lines(pose(0)))  # poses alone
        expect_none()
        self.write("color/0.jpg", "x")
        self.write("depth/0.png", "x")
        self.write("pose/0.txt", "0.1 0.2 0.3 0 0 0 1\n")  # translation and quaternion
        expect_none()
        self.write("rgb.txt", "a list of colours\nred\n")
        self.write("depth.txt", "deep\n")
        self.write("groundtruth.txt", "1 0 0 0 0 0 0 1\n")
        expect_none()
        self.write("traj.txt", "0 0 0\n")
        self.write("results/image000000.jpg", "x")
        expect_none()
        self.write("depth/0.png", "x")
        os.rename(self.path("depth/0.png"), self.path("depth/5.png"))  # no number in common
        expect_none(has_trajectory=True)

    def test_two_layouts_in_one_folder_are_told(self):
        ScanNetFolder.write_frames(self)
        TumFolder.write_frames(self)
        self.expect_error("2 layouts match, tum and scannet", "--format")
        self.assertIn("layout scannet", self.run_command("--format", "scannet")[1])

    def test_a_named_layout_says_what_it_lacks(self):
        ScanNetFolder.write_frames(self)
        self.expect_error("--format tum", "absent: rgb.txt", "groundtruth.txt",
                          arguments=["--format", "tum"])

    def test_no_folder_is_told_from_a_file(self):
        self.input = os.path.join(self.temporary.name, "no")
        self.expect_error("absent", "expected a folder")
        self.input = os.path.join(self.temporary.name, "walk.bag")
        with open(self.input, "w") as file:
            file.write("x")
        self.expect_error("a file, expected a folder", "process_bag")

    def test_apple_double_files_are_no_frames(self):
        self.write("._frame-000000.color.png", "x")
        self.assertEqual(numbered.list_numbered(self.input, "frame-", [".color.png"]), {})

    def test_endings_in_capitals_count_and_the_first_ending_wins(self):
        for name in ("0.PNG", "1.JPG", "1.png"):
            self.write(name, "x")
        found = numbered.list_numbered(self.input, "", (".jpg", ".png"))
        self.assertEqual([os.path.basename(path) for path in found.values()], ["0.PNG", "1.JPG"])


class Output(ThreeDMatchFolder):
    def test_last_line_says_what_was_written_and_what_it_holds(self):
        self.write_frames(3)
        self.convert("--rate", "10")
        last = self.text.splitlines()[-1]
        for part in (self.output, "3 frames over 0.20 s", "/tf", COLOR, DEPTH, INFO, "MB"):
            self.assertIn(part, last)

    def test_the_folder_of_the_output_is_made(self):
        self.write_frames(1)
        self.output = os.path.join(self.temporary.name, "a", "b", "walk.bag")
        self.convert()
        self.assertTrue(os.path.exists(self.output))

    def test_tilde_and_relative_paths_are_taken_as_people_write_them(self):
        self.write_frames(1)
        self.write("t.txt", trajectory_line(0.0, pose(0)))
        self.write("timestamps.txt", "0\n")
        self.addCleanup(os.environ.__setitem__, "HOME", os.environ["HOME"])
        self.addCleanup(os.chdir, os.getcwd())
        os.environ["HOME"] = self.temporary.name
        os.chdir(self.temporary.name)
        for folder, output in (("~/input", "~/1.bag"), ("input/", "2.bag"), ("./input", "x/3.bag")):
            self.input, self.output = folder, output
            status, text = self.run_command("--trajectory", folder + "/t.txt", "--intrinsics",
                                            folder + "/camera-intrinsics.txt")
            self.assertEqual(status, 0, text)
            self.assertTrue(os.path.exists(os.path.expanduser(output)))
        self.assertFalse(os.path.exists("~"))

    def test_an_output_that_is_a_folder_is_refused(self):
        self.write_frames(1)
        for output in (self.temporary.name, os.path.join(self.temporary.name, "new", "")):
            status, text = self.run_command("--output", output)
            self.assertEqual(status, 1)
            self.assertIn("a folder, expected a file name", text)

    def test_an_output_below_a_file_is_refused(self):
        self.write_frames(1)
        self.output = self.path("camera-intrinsics.txt") + "/walk.bag"
        self.expect_error("--output", "camera-intrinsics.txt")

    def test_an_output_without_permission_is_refused(self):
        self.write_frames(1)
        with mock.patch("os.access", return_value=False):  # root may write everywhere
            self.expect_error("no permission to write into", self.temporary.name)

    def test_a_full_disk_is_told_and_leaves_nothing(self):
        self.write_frames(1)
        full = OSError(28, "No space left on device")
        with mock.patch("rosbag.Bag.write", side_effect=full):
            self.expect_error(self.output, "No space left on device")

    def test_an_older_bag_stays_when_a_run_fails(self):
        self.write_frames(2)
        self.convert()
        size = os.path.getsize(self.output)
        self.cut("frame-000001.depth.png")
        self.assertEqual(self.run_command()[0], 1)
        self.assertEqual(os.path.getsize(self.output), size)

    def test_an_interrupted_run_leaves_nothing(self):
        self.write_frames(1)
        with mock.patch("rosbag.Bag.write", side_effect=KeyboardInterrupt):
            status, text = self.run_command()
        self.assertEqual(status, 130)
        self.assertIn("nothing was written: interrupted", text)
        self.assertEqual(os.listdir(self.temporary.name), ["input"])


class Rotation(unittest.TestCase):
    def test_quaternions_and_matrices_are_inverse(self):
        random = np.random.RandomState(1)
        for _ in range(100):
            q = random.randn(4)
            q /= np.linalg.norm(q) * np.sign(q[3])
            np.testing.assert_allclose(rotation.to_quaternion(rotation.from_quaternion(q)), q,
                                       atol=1e-9)

    def test_zero_quaternion_is_no_rigid_pose(self):
        T = np.eye(4)
        T[:3, :3] = rotation.from_quaternion([0, 0, 0, 0])
        self.assertFalse(conventions.is_rigid(T))
        self.assertFalse(conventions.is_rigid(np.diag([1.0, 1.0, -1.0, 1.0])))


class Command(unittest.TestCase):
    def test_the_script_itself_explains_its_options(self):
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts",
                              "dataset_to_bag")
        done = subprocess.run([script, "--help"], stdout=subprocess.PIPE, timeout=120)
        self.assertEqual(done.returncode, 0)
        self.assertIn(b"--max-frames", done.stdout)


if __name__ == "__main__":
    unittest.main()
