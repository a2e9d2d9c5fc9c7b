# SPDX-License-Identifier: BSD-3-Clause
"""The program simulate_apartment: its bag, task files and ground truth, and its errors."""
import hashlib
import json
import os
import subprocess
import tempfile
import unittest

import numpy as np
import rosbag
import yaml

PROGRAM = os.path.join(os.environ["TSG_BUILD_DIR"], "devel", "lib", "task_scene_graph",
                       "simulate_apartment")
COLOR = "/camera/color/image_raw"
INFO = "/camera/color/camera_info"
DEPTH = "/camera/aligned_depth_to_color/image_raw"
ORDER = ["/tf", INFO, DEPTH, COLOR, "/segmentation"]
SMALL = ["--width", "160", "--height", "120", "--duration", "2", "--rate", "5"]


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=300)


def pixels(image, kind):
    return np.frombuffer(image.data, kind).reshape(image.height, image.width, -1).squeeze()


class SimulateApartment(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.bag = os.path.join(cls.temporary.name, "new", "home.bag")
        cls.done = run("--output", cls.bag, "--seed", "3", *SMALL)
        if cls.done.returncode == 0:
            with rosbag.Bag(cls.bag) as bag:
                cls.recorded = [(t, m) for t, m, _ in bag.read_messages()]

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)

    def beside(self, ending):
        return self.bag[: -len(".bag")] + ending

    def messages(self, topic):
        return [message for name, message in self.recorded if name == topic]

    def test_every_frame_has_all_topics_in_order_with_one_stamp(self):
        self.assertEqual([topic for topic, _ in self.recorded], ORDER * 11)
        for i, color in enumerate(self.messages(COLOR)):
            stamp = color.header.stamp
            self.assertEqual(stamp.to_nsec(), 1000000000 + i * 200000000)
            self.assertEqual(self.messages("/tf")[i].transforms[0].header.stamp, stamp)
            for topic in (INFO, DEPTH, "/segmentation"):
                self.assertEqual(self.messages(topic)[i].header.stamp, stamp)
                self.assertEqual(self.messages(topic)[i].header.frame_id,
                                 "camera_color_optical_frame")

    def test_images_have_the_asked_size_and_content(self):
        for color, depth in zip(self.messages(COLOR), self.messages(DEPTH)):
            self.assertEqual((color.encoding, depth.encoding), ("rgb8", "16UC1"))
            self.assertEqual(pixels(color, np.uint8).shape, (120, 160, 3))
            self.assertGreater(pixels(color, np.uint8).std(), 5.0)
            measured = pixels(depth, "<u2")
            self.assertGreater(np.mean(measured > 0), 0.6)
            self.assertLessEqual(measured.max(), 6500)

    def test_segments_are_numbered_without_gaps_and_embedded(self):
        for message in self.messages("/segmentation"):
            labels = pixels(message.labels, "<u2")
            count = len(message.confidences)
            self.assertEqual(set(np.unique(labels)) - {0}, set(range(1, count + 1)))
            rows = np.array(message.embeddings).reshape(count, message.embedding_size)
            np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1.0, atol=1e-4)
            self.assertEqual(len(message.image_embedding), message.embedding_size)

    def test_task_files_match_the_embeddings_in_the_bag(self):
        size = self.messages("/segmentation")[0].embedding_size
        for kind in ("object", "place"):
            with open(self.beside(f".{kind}_tasks.yaml")) as file:
                tasks = yaml.safe_load(file)["tasks"]
            self.assertGreaterEqual(len(tasks), 6)
            for task in tasks:
                self.assertEqual(len(task["embedding"]), size, task["name"])

    def test_ground_truth_lies_beside_the_bag(self):
        folder = self.beside(".ground_truth")
        with open(os.path.join(folder, "instances.json")) as file:
            self.assertGreater(len(json.load(file)), 50)
        with open(os.path.join(folder, "rooms.json")) as file:
            self.assertEqual(len(json.load(file)["rooms"]), 6)
        with open(os.path.join(folder, "tasks.yaml")) as file:
            boxes = [box for boxes in yaml.safe_load(file).values() for box in boxes]
        self.assertEqual(set(boxes[0]), {"center", "extents", "rotation"})
        poses = np.loadtxt(os.path.join(folder, "poses.txt"))
        translation = self.messages("/tf")[4].transforms[0].transform.translation
        self.assertAlmostEqual(poses[4, 0], 1.8)
        np.testing.assert_allclose(poses[4, 1:4], [translation.x, translation.y, translation.z])

    def test_the_same_seed_gives_the_same_bag_for_any_number_of_threads(self):
        digests = []
        for threads in ("1", "4"):
            path = os.path.join(self.temporary.name, f"threads{threads}.bag")
            self.assertEqual(run("--output", path, "--seed", "3", "--threads", threads,
                                 *SMALL).returncode, 0)
            digest = hashlib.sha256()
            with rosbag.Bag(path) as bag:
                for topic, raw, stamp in bag.read_messages(raw=True):
                    digest.update(topic.encode() + raw[1] + str(stamp).encode())
            digests.append(digest.hexdigest())
        self.assertEqual(digests[0], digests[1])

    def test_noise_and_segmentation_can_be_switched_off(self):
        path = os.path.join(self.temporary.name, "clean.bag")
        done = run("--output", path, "--seed", "3", "--noise", "off", "--no-segmentation", *SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        with rosbag.Bag(path) as bag:
            messages = list(bag.read_messages())
        self.assertNotIn("/segmentation", {message.topic for message in messages})
        with open(path.replace(".bag", ".object_tasks.yaml")) as file:
            self.assertIn("get the coffee mug", yaml.safe_load(file))
        exact = [pixels(m.message, "<u2") for m in messages if m.topic == DEPTH]
        noisy = [pixels(m, "<u2") for m in self.messages(DEPTH)]
        both = (exact[3] > 0) & (noisy[3] > 0)
        error = np.abs(exact[3].astype(int) - noisy[3])[both]
        self.assertGreater(np.median(error), 0)
        self.assertLess(np.median(error), 60)

    def test_other_worlds_have_a_second_list_of_tasks_over_the_same_things(self):
        path = os.path.join(self.temporary.name, "cubicle.bag")
        done = run("--output", path, "--world", "cubicle", "--seed", "3", *SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        stem = path[: -len(".bag")]
        boxes, names = {}, {}
        for kind, truth, tasks in (("fine", "tasks", "object_tasks"),
                                   ("coarse", "coarse_tasks", "coarse_tasks")):
            with open(os.path.join(stem + ".ground_truth", truth + ".yaml")) as file:
                boxes[kind] = yaml.safe_load(file)
            with open(f"{stem}.{tasks}.yaml") as file:
                names[kind] = [task["name"] for task in yaml.safe_load(file)["tasks"]]
            self.assertEqual(names[kind], list(boxes[kind]))
        self.assertEqual(len(boxes["fine"]["get the green book"]),
                         len(boxes["coarse"]["move the stacks of books"]))
        chairs = "move the office chair"
        self.assertEqual(boxes["fine"][chairs], boxes["coarse"][chairs])
        self.assertNotIn("get the green book", boxes["coarse"])
        for name in ("labels", "coarse_labels"):
            with open(os.path.join(stem + ".ground_truth", name + ".ply")) as file:
                self.assertIn("property int label", file.read(400))

    def test_tf_of_a_drifting_walk_is_odometry_and_the_truth_stays(self):
        path = os.path.join(self.temporary.name, "drift.bag")
        done = run("--output", path, "--seed", "3", "--drift", "0.3", *SMALL)
        self.assertEqual(done.returncode, 0, done.stderr)
        folder = path[: -len(".bag")] + ".ground_truth"
        truth = np.loadtxt(os.path.join(folder, "poses.txt"))
        odometry = np.loadtxt(os.path.join(folder, "odometry.txt"))
        np.testing.assert_array_equal(truth, np.loadtxt(os.path.join(self.beside(".ground_truth"), "poses.txt")))
        np.testing.assert_allclose(odometry[:, 0], truth[:, 0], atol=1e-9)
        np.testing.assert_allclose(odometry[0], truth[0], atol=1e-9)
        self.assertGreater(np.linalg.norm(odometry[-1, 1:4] - truth[-1, 1:4]), 1e-3)
        with rosbag.Bag(path) as bag:
            tf = [m.transforms[0].transform.translation for _, m, _ in bag.read_messages("/tf")]
            images = [m.data for _, m, _ in bag.read_messages(COLOR)]
        np.testing.assert_allclose([[t.x, t.y, t.z] for t in tf], odometry[:, 1:4], atol=1e-9)
        self.assertEqual(images, [m.data for m in self.messages(COLOR)])
        self.assertFalse(os.path.exists(os.path.join(self.beside(".ground_truth"), "odometry.txt")))

    def test_errors_name_option_value_and_what_was_expected(self):
        path = os.path.join(self.temporary.name, "bad.bag")
        for arguments, parts in ((["--rooms", "many"], ["--rooms", "many", "number"]),
                                 (["--noise", "loud"], ["--noise", "loud", "on or off"]),
                                 (["--wdth", "3"], ["--wdth"]),
                                 (["--world", "castle"], ["castle", "cubicle"]),
                                 (["--rooms", "20"], ["num_rooms", "20"]),
                                 (["--laps", "0"], ["laps", "0"]),
                                 (["--drift", "-1"], ["position_per_m", "-1"]),
                                 (["--width", "0"], ["width", "0"])):
            done = run("--output", path, *arguments)
            self.assertNotEqual(done.returncode, 0)
            for part in parts:
                self.assertIn(part, done.stderr)
        self.assertFalse(os.path.exists(path))

    def test_a_bag_that_cannot_be_written_leaves_nothing_behind(self):
        blocked = os.path.join(self.temporary.name, "file")
        with open(blocked, "w"):
            pass
        done = run("--output", os.path.join(blocked, "home.bag"), *SMALL)
        self.assertEqual(done.returncode, 1)
        self.assertIn("file", done.stderr)


if __name__ == "__main__":
    unittest.main()
