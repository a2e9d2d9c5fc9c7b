# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dataset_to_bag on tiny folders of each layout, its bags read back."""
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosbag
import yaml
from PIL import Image

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
from datasets import __main__ as command  # noqa: E402
from datasets import frames as frames_module  # noqa: E402
from datasets import rotation, tum, world_up  # noqa: E402

WIDTH, HEIGHT = 8, 6


def turn_z(angle_rad):
    T = np.eye(4)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    T[:2, :2] = [[c, -s], [s, c]]
    return T


def pose(index):
    T = turn_z(0.3 * index)
    T[:3, 3] = [0.1 * index, -0.2, 1.4]
    return T


def color(index):
    """Smooth, so that JPEG keeps it nearly unchanged."""
    return np.full((HEIGHT, WIDTH, 3), (40 + 10 * index, 90, 200), np.uint8)


def depth(index):
    return (np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH) * 100 + index)


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

    def save(self, name, pixels):
        Image.fromarray(pixels).save(self.path(name))

    def run_command(self, *arguments):
        """(exit status, what it printed)."""
        text = io.StringIO()
        with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            status = command.main(["--input", self.input, "--output", self.output, *arguments])
        return status, text.getvalue()

    def convert(self, *arguments):
        """{topic: [message]} of the bag; the messages in the order in which they were recorded."""
        status, text = self.run_command(*arguments)
        self.assertEqual(status, 0, text)
        self.order, messages = [], {}
        with rosbag.Bag(self.output) as bag:
            for topic, message, _ in bag.read_messages():
                self.order.append(topic)
                messages.setdefault(topic, []).append(message)
        return messages

    def expect_error(self, *parts, arguments=()):
        status, text = self.run_command(*arguments)
        self.assertEqual(status, 1, text)
        for part in parts:
            self.assertIn(part, text)
        self.assertFalse(os.path.exists(self.output))
        self.assertFalse(os.path.exists(self.output + ".part"))

    def expect_pose(self, message, T):
        transform = message.transforms[0]
        self.assertEqual(transform.header.frame_id, "world")
        self.assertEqual(transform.child_frame_id, "camera_color_optical_frame")
        t, q = transform.transform.translation, transform.transform.rotation
        np.testing.assert_allclose([t.x, t.y, t.z], T[:3, 3], atol=1e-9)
        np.testing.assert_allclose(rotation.from_quaternion([q.x, q.y, q.z, q.w]), T[:3, :3],
                                   atol=1e-9)


COLOR = "/camera/color/image_raw"
INFO = "/camera/color/camera_info"
DEPTH = "/camera/aligned_depth_to_color/image_raw"


def stamps_ns(messages):
    return [m.header.stamp.to_nsec() for m in messages]


def depth_pixels(message):
    kind = {"16UC1": "<u2", "32FC1": "<f4"}[message.encoding]
    return np.frombuffer(message.data, kind).reshape(message.height, message.width)


def number_lines(T):
    return "\n".join(" ".join(f"{v:.12e}" for v in row) for row in T) + "\n"


class ThreeDMatch(Folder):
    def write_frames(self, count, with_intrinsics=True):
        for i in range(count):
            self.save(f"frame-{i:06d}.color.png", color(i))
            self.save(f"frame-{i:06d}.depth.png", depth(i))
            self.write(f"frame-{i:06d}.pose.txt", number_lines(pose(i)))
        if with_intrinsics:
            self.write("camera-intrinsics.txt", "500 0 4\n0 510 3\n0 0 1\n")

    def test_images_poses_and_intrinsics_arrive_unchanged(self):
        self.write_frames(3)
        messages = self.convert("--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1100000000, 1200000000])
        for i in range(3):
            image = messages[COLOR][i]
            self.assertEqual((image.encoding, image.header.frame_id),
                             ("rgb8", "camera_color_optical_frame"))
            pixels = np.frombuffer(image.data, np.uint8).reshape(image.height, image.step)
            np.testing.assert_array_equal(pixels.reshape(HEIGHT, WIDTH, 3), color(i))
            self.assertEqual(messages[DEPTH][i].encoding, "16UC1")
            np.testing.assert_array_equal(depth_pixels(messages[DEPTH][i]), depth(i))
            self.expect_pose(messages["/tf"][i], pose(i))
            self.assertEqual(messages["/tf"][i].transforms[0].header.stamp, image.header.stamp)
        info = messages[INFO][0]
        self.assertEqual((info.K[0], info.K[4], info.K[2], info.K[5]), (500.0, 510.0, 4.0, 3.0))
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

    def test_without_intrinsics_7_scenes_values_are_taken(self):
        self.write_frames(1, with_intrinsics=False)
        self.assertEqual(self.convert()[INFO][0].K[0], 585.0)

    def test_intrinsics_above_the_sequence_folder_are_found(self):
        self.write_frames(1)
        os.rename(self.path("camera-intrinsics.txt"),
                  os.path.join(self.temporary.name, "camera-intrinsics.txt"))
        self.assertEqual(self.convert()[INFO][0].K[0], 500.0)

    def test_depth_of_another_size_names_file_value_and_expected(self):
        self.write_frames(1)
        self.save("frame-000000.depth.png", np.zeros((3, 4), np.uint16))
        self.expect_error("frame-000000.depth.png", "4x3", "8x6")

    def test_broken_pose_file_names_file_and_count(self):
        self.write_frames(1)
        self.write("frame-000000.pose.txt", "1 2 3\n")
        self.expect_error("frame-000000.pose.txt", "3 numbers", "expected 16")

    def test_broken_image_is_named(self):
        self.write_frames(1)
        self.write("frame-000000.depth.png", "no image")
        self.expect_error("frame-000000.depth.png", "expected a readable image")

    def test_folder_without_a_layout_is_refused(self):
        self.expect_error(self.input, "0 layouts match", "--format")


    def test_given_direction_becomes_z(self):
        self.write_frames(2)
        turned = self.convert("--world-up=0,-2,0")["/tf"]
        R = np.eye(4)
        R[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]  # -y to z about x
        for i, message in enumerate(turned):
            self.expect_pose(message, R @ pose(i))

    def test_level_is_refused_where_the_camera_does_not_turn(self):
        for i in range(3):
            self.save(f"frame-{i:06d}.color.png", color(i))
            self.save(f"frame-{i:06d}.depth.png", depth(i))
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


class RecordedLabels(ThreeDMatch):
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


class Tum(Folder):
    def write_frames(self):
        rgb, depths = "# color images\n", "# depth maps\n"
        for i, (t_rgb, t_depth) in enumerate([(10.00, 10.005), (10.10, 10.13), (10.20, 10.19)]):
            self.save(f"rgb/{i}.png", color(i))
            self.save(f"depth/{i}.png", depth(i))
            rgb += f"{t_rgb:.6f} rgb/{i}.png\n"
            depths += f"{t_depth:.6f} depth/{i}.png\n"
        self.write("rgb.txt", rgb)
        self.write("depth.txt", depths)
        self.write("groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n"
                   "9.95 0 0 1 0 0 0 1\n10.05 1 0 1 0 0 0.7071067811865476 0.7071067811865476\n"
                   "10.15 1 0 1 0 0 0.7071067811865476 0.7071067811865476\n10.21 3 0 1 0 0 0 1\n")

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
        self.assertEqual(messages[INFO][0].K[2], 319.5)

    def test_images_outside_the_ground_truth_are_skipped_and_counted(self):
        self.write_frames()
        self.write("groundtruth.txt", "10.15 0 0 1 0 0 0 1\n10.25 0 0 1 0 0 0 1\n")
        _, text = self.run_command()
        self.assertIn("1 frames skipped", text)
        self.assertEqual(stamps_ns(self.convert()[COLOR]), [10200000000])

    def test_no_pose_is_interpolated_across_a_gap(self):
        self.assertIsNone(tum.interpolate([0, 600000000], [None, None], 300000000))

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


class Replica(Folder):
    def write_frames(self):
        for i in range(2):
            Image.fromarray(color(i)).save(self.path(f"results/frame{i:06d}.jpg"), quality=95)
            self.save(f"results/depth{i:06d}.png", depth(i) * 10)
        self.write("traj.txt", "".join(" ".join(f"{v:.12e}" for v in pose(i).ravel()) + "\n"
                                       for i in range(2)))

    def test_frames_follow_the_trajectory_at_the_given_rate(self):
        self.write_frames()
        messages = self.convert("--rate", "20")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1050000000])
        self.expect_pose(messages["/tf"][1], pose(1))
        np.testing.assert_allclose(depth_pixels(messages[DEPTH][1]), depth(1) * 10 / 6553.5,
                                   rtol=1e-6)
        pixels = np.frombuffer(messages[COLOR][1].data, np.uint8).reshape(HEIGHT, WIDTH, 3)
        np.testing.assert_allclose(pixels, color(1), atol=4)
        self.assertEqual(messages[INFO][0].K[0], 600.0)

    def test_cam_params_are_used_where_there_are_some(self):
        self.write_frames()
        self.write("cam_params.json",
                   '{"camera": {"fx": 320, "fy": 321, "cx": 4, "cy": 3, "scale": 1000}}')
        messages = self.convert()
        self.assertEqual((messages[INFO][0].K[0], messages[DEPTH][0].encoding), (320.0, "16UC1"))

    def test_cam_params_without_scale_are_refused(self):
        self.write_frames()
        self.write("cam_params.json", '{"camera": {"fx": 320, "fy": 321, "cx": 4, "cy": 3}}')
        self.expect_error("cam_params.json", "scale")

    def test_trajectory_of_another_length_is_refused(self):
        self.write_frames()
        self.write("traj.txt", "")
        self.expect_error("traj.txt", "0 poses", "2")


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
        self.assertFalse(frames_module.is_rigid(T))
        self.assertFalse(frames_module.is_rigid(np.diag([1.0, 1.0, -1.0, 1.0])))


class Command(unittest.TestCase):
    def test_the_script_itself_explains_its_options(self):
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts",
                              "dataset_to_bag")
        done = subprocess.run([script, "--help"], stdout=subprocess.PIPE, timeout=120)
        self.assertEqual(done.returncode, 0)
        self.assertIn(b"--max-frames", done.stdout)


if __name__ == "__main__":
    unittest.main()
