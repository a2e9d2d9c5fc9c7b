# SPDX-License-Identifier: BSD-3-Clause
"""process_bag on recordings as people have them: other poses, stamps, units, transports, parts."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosbag

sys.path.insert(0, str(pathlib.Path(os.environ["TSG_SOURCE_DIR"]) / "test" / "support"))
import box_room  # noqa: E402
from box_room import Recording  # noqa: E402

PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph"
OPTICAL_IN_BODY = np.array([[0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
CONFIG = "mesh_fusion: {background: {tsdf: {voxel_size_m: 0.1}}}\n"


class BagInputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        for name, text in (("tasks", box_room.TASKS), ("places", box_room.PLACE_TASKS),
                           ("config", CONFIG)):
            (cls.folder / f"{name}.yaml").write_text(text)
        cls.clean = cls.run_on("clean", Recording().write(cls.folder / "clean.bag"))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def run_on(cls, name, bags, *options):
        bags = bags if isinstance(bags, list) else [bags]
        output = cls.folder / f"map_{name}"
        if "--config" not in options:
            options = ["--config", cls.folder / "config.yaml", *options]
        done = subprocess.run(
            [str(PROGRAMS / "process_bag"), "--bag", *map(str, bags), "--object-tasks",
             str(cls.folder / "tasks.yaml"), "--place-tasks", str(cls.folder / "places.yaml"),
             "--output", str(output),
             *map(str, options)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=300)
        return output, done

    def record(self, name, **changes):
        return Recording(**changes).write(self.folder / f"{name}.bag")

    def process(self, name, *options, **changes):
        return self.run_on(name, self.record(name, **changes), *options)

    def assert_same_map(self, result, max_shift_m=0.03):
        """The two boxes are where they are in the clean recording's map."""
        output, done = result
        self.assertEqual(done.returncode, 0, done.stderr)
        found, expected = (self.read_objects(folder) for folder in (output, self.clean[0]))
        self.assertEqual(set(found), set(expected))
        for task, position in expected.items():
            np.testing.assert_allclose(found[task], position, atol=max_shift_m, err_msg=task)

    @staticmethod
    def read_objects(folder):
        summary = json.loads((folder / "summary.json").read_text())
        return {row["task"]: row["position_m"] for room in summary["rooms"] for row in room["objects"]}

    def assert_refused(self, result, *words):
        output, done = result
        self.assertEqual(done.returncode, 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertFalse((output / "scene_graph.json").exists())

    def drops(self, output):
        return json.loads((output / "timing.json").read_text())["drops"]

    def rewrite_segmentations(self, name, datatype=None, md5sum=None):
        """The clean recording, but its segmentations say that they are of another type or version."""
        target = self.folder / f"{name}.bag"
        with rosbag.Bag(str(self.folder / "clean.bag")) as read, rosbag.Bag(str(target), "w") as written:
            for topic, message, when in read.read_messages(raw=True):
                if topic == "/segmentation":
                    message = (datatype or message[0], message[1], md5sum or message[2]) + message[3:]
                written.write(topic, message, when, raw=True)
        return target

    def test_segmentations_of_another_version_are_named_before_anything_is_done(self):
        bag = self.rewrite_segmentations("other_version", md5sum="0123456789abcdef0123456789abcdef")
        self.assert_refused(self.run_on("other_version", bag), "/segmentation", "another version",
                            "0123456789abcdef0123456789abcdef", "--ignore-recorded-segmentation")

    def test_segmentations_of_another_type_are_named_before_anything_is_done(self):
        bag = self.rewrite_segmentations("other_type", datatype="other_package/Segmentation")
        self.assert_refused(self.run_on("other_type", bag), "/segmentation", "other_package/Segmentation",
                            "expected task_scene_graph/Segmentation")

    def test_clean_recording_gives_both_boxes_and_drops_nothing(self):
        output, done = self.clean
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(set(self.read_objects(output)), {"take the red box", "take the blue box"})
        self.assertEqual(self.drops(output), {})
        self.assertEqual(done.stderr, "")

    # Transports

    def test_compressed_topics_are_found_and_give_the_same_map(self):
        self.assert_same_map(self.process("compressed", compressed=True))

    def test_compressed_topics_may_be_named(self):
        bag = self.record("compressed_named", compressed=True)
        self.assert_same_map(self.run_on("compressed_named", bag, "--color-topic",
                                         box_room.COLOR + "/compressed", "--depth-topic",
                                         box_room.DEPTH + "/compressedDepth"))

    # Poses

    def test_odometry_is_a_source_of_poses(self):
        self.assert_same_map(self.process("odometry", "--pose-topic", "/odom", pose="odometry"))

    def test_stamped_poses_are_a_source_of_poses(self):
        self.assert_same_map(self.process("stamped", "--pose-topic", "/odom", pose="pose"))

    def test_trajectory_file_is_a_source_of_poses(self):
        path = self.folder / "walk.txt"
        path.write_text(box_room.trajectory_lines())
        self.assert_same_map(self.process("trajectory", "--trajectory", path, pose=None))

    def test_trajectory_of_another_time_is_named_with_its_span(self):
        path = self.folder / "other.txt"
        path.write_text("5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n")
        self.assert_refused(self.process("other", "--trajectory", path, pose=None),
                            "no map was written", "go from 5.000 to 6.000 s")

    def test_odometry_of_the_body_uses_the_static_link(self):
        changes = {"pose": "odometry", "moving_frame": "base_link", "T_moving_camera": OPTICAL_IN_BODY}
        self.assert_same_map(self.process(
            "body", "--pose-topic", "/odom",
            links=[("base_link", box_room.CAMERA_FRAME, OPTICAL_IN_BODY)], **changes))
        self.assert_refused(self.process("body_alone", "--pose-topic", "/odom", **changes),
                            "'base_link'", "--pose-frame")

    def test_parts_of_a_split_recording_are_one(self):
        common = {"moving_frame": "base_link", "T_moving_camera": OPTICAL_IN_BODY}
        first = self.record("part_1", frames=range(0, 12), **common,
                            links=[("base_link", box_room.CAMERA_FRAME, OPTICAL_IN_BODY)])
        second = self.record("part_2", frames=range(12, 30), **common)
        self.assert_same_map(self.run_on("parts", [second, first]))
        self.assert_refused(self.run_on("part_2", second), "'camera_color_optical_frame'",
                            "base_link", "/tf_static")

    def test_frame_that_is_not_optical_is_turned(self):
        R = np.eye(4)
        R[:3, :3] = OPTICAL_IN_BODY[:3, :3]
        bag = self.record("axes", moving_frame="camera_link", T_moving_camera=R)
        for name in ("body", "flu", "ros"):
            self.assert_same_map(self.run_on(f"axes_{name}", bag, "--camera-axes", name, "--camera-frame",
                                             "camera_link"))
        self.assert_refused(self.run_on("axes_bad", bag, "--camera-axes", "forward"), "camera_axes", "forward",
                            "optical, opengl, body")

    def test_frame_of_the_camera_may_be_named(self):
        self.assert_same_map(self.process("named", "--camera-frame", "head",
                                          moving_frame="head", frame_id="wrong"))

    def test_world_frame_may_be_another(self):
        self.assert_same_map(self.process("map_frame", "--world-frame", "map", world_frame="map"))
        self.assert_refused(self.process("no_world", world_frame="map"), "'world'", "map",
                            "--world-frame")

    def test_transforms_of_a_robots_namespace_are_found(self):
        self.assert_same_map(self.process("namespace", tf_namespace="/robot1"))

    def test_slash_before_a_frame_changes_nothing(self):
        self.assert_same_map(self.process("slash", "--world-frame", "/world",
                                          frame_id="/" + box_room.CAMERA_FRAME))

    def test_hole_in_tf_is_counted_and_named(self):
        # No transform from 0.8 to 2.3 s, while images go on.
        output, done = self.process("hole", pose_at=[*range(9), *range(23, 30)])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.drops(output)["hole in tf"], 14)
        self.assertIn("input/max_tf_gap_s", done.stderr)
        self.assert_same_map(self.run_on("no_hole", self.folder / "hole.bag", "--max-tf-gap", "2"))

    # Stamps

    def test_streams_apart_are_named_with_the_distance_and_the_option(self):
        result = self.process("apart", depth_delay=lambda i: 0.033)
        self.assert_refused(result, "no depth image, 30", "0.033 s away", "--sync-tolerance")
        bag = self.folder / "apart.bag"
        self.assert_same_map(self.run_on("apart_ok", bag, "--sync-tolerance", "0.04"))

    def test_images_without_a_partner_are_counted(self):
        output, done = self.process("half", depth_delay=lambda i: 0.0 if i % 2 else None)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.drops(output), {"no depth image": 15,
                                              "segmentation without a frame": 15})
        self.assertIn("no depth image", done.stderr)

    def test_stamps_of_zero_are_named(self):
        self.assert_refused(self.process("zero", stamp=lambda i: 0.0), "no map was written",
                            "stamp is 0")

    def test_one_stamp_of_zero_costs_one_frame(self):
        output, done = self.process("one_zero", stamp=lambda i: 0.0 if i == 7 else 100.0 + 0.1 * i)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.drops(output)["stamp is 0"], 3)  # colour, depth, tf

    def test_stamp_at_the_end_of_time_costs_one_frame(self):
        output, done = self.process("end_of_time",
                                    stamp=lambda i: 4294967000.0 if i == 7 else 100.0 + 0.1 * i)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.drops(output)["stamp out of range"], 3)

    # Intrinsics

    def test_camera_info_once_is_enough(self):
        self.assert_same_map(self.process("latched", info_at=[0]))
        self.assert_same_map(self.process("late_info", info_at=[25]))

    def test_intrinsics_may_be_given(self):
        numbers = f"{box_room.FX},{box_room.FY},{box_room.CX},{box_room.CY}"
        self.assert_same_map(self.process("numbers", "--intrinsics", numbers, info_at=[]))
        path = self.folder / "K.txt"
        path.write_text(f"{box_room.FX} 0 {box_room.CX}\n0 {box_room.FY} {box_room.CY}\n0 0 1\n")
        self.assert_same_map(self.process("matrix", "--intrinsics", path, info_at=[]))
        self.assert_refused(self.process("no_info", info_at=[]), box_room.INFO, "--intrinsics")

    def test_file_of_intrinsics_lies_beside_the_configuration_that_names_it(self):
        folder = self.folder / "robot"
        folder.mkdir()
        (folder / "K.txt").write_text(f"{box_room.FX} {box_room.FY} {box_room.CX} {box_room.CY}\n")
        (folder / "my.yaml").write_text(CONFIG + "input: {intrinsics: K.txt}\n")
        bag = self.record("beside", info_at=[])
        self.assert_same_map(self.run_on("beside", bag, "--config", folder / "my.yaml"))
        (folder / "K.txt").unlink()
        self.assert_refused(self.run_on("gone", bag, "--config", folder / "my.yaml"), str(folder / "K.txt"))

    def test_distortion_is_warned_of_and_can_be_removed(self):
        distortion = [0.05, 0.0, 0.0, 0.0, 0.0]
        _, done = self.process("distorted", distortion=distortion)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("--rectify", done.stderr)
        _, done = self.run_on("rectified", self.folder / "distorted.bag", "--rectify")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")

    # Depth

    def test_units_of_depth_may_be_given(self):
        quarter = {"depth_units_per_m": 4000.0}
        self.assert_same_map(self.process("quarter", "--depth-scale", "0.00025", **quarter))
        self.assert_same_map(self.process("quarter_units", "--depth-scale", "4000", **quarter))
        self.assert_same_map(self.process("float_mm", "--depth-scale", "1e-3",
                                          depth_units_per_m=1000.0, depth_encoding="32FC1"))

    def test_scale_that_no_camera_has_is_refused(self):
        self.assert_refused(self.process("scale", "--depth-scale", "1e-9"), "depth_scale")

    def test_depth_of_another_size_is_matched(self):
        half = {"depth_size": (box_room.WIDTH // 2, box_room.HEIGHT // 2)}
        self.assert_refused(self.process("half_size", **half), "80x60", "160x120", "--match-size")
        bag = self.folder / "half_size.bag"
        # A pixel of the wall behind a box's edge passes for the box: at 80x60 that shows, the more
        # the farther readings reach.
        near = self.folder / "near.yaml"
        near.write_text("mesh_fusion: {reconstruction: {max_range_m: 4.0}}\n")
        for way in ("color-to-depth", "depth_to_color"):
            self.assert_same_map(self.run_on(f"half_{way}", bag, "--match-size", way, "--config",
                                             str(near)), 0.25)

    # Files

    def test_what_is_no_closed_rosbag_is_named_with_the_remedy(self):
        data = (self.folder / "clean.bag").read_bytes()
        unclosed = self.folder / "unclosed.bag"
        # As the recorder leaves it: no index yet. The header's index_pos and counts are 0.
        head = bytearray(data[: 13 + 4096 + 8])
        place = head.index(b"index_pos=") + len(b"index_pos=")
        head[place:place + 8] = bytes(8)
        unclosed.write_bytes(bytes(head) + data[len(head):len(data) // 2])
        (self.folder / "ros2.db3").write_bytes(b"SQLite format 3\0" + bytes(100))
        (self.folder / "empty.bag").write_bytes(b"")
        (self.folder / "text.bag").write_text("hello")
        (self.folder / "bag2").mkdir(exist_ok=True)
        (self.folder / "bag2" / "metadata.yaml").write_text("")
        for name, word in (("unclosed.bag", "rosbag reindex"), ("ros2.db3", "rosbags-convert"),
                           ("bag2", "rosbags-convert"), ("empty.bag", "is empty"),
                           ("text.bag", "no rosbag"), ("absent.bag", "no such file")):
            self.assert_refused(self.run_on("bad_file", self.folder / name), name, word)

    def test_bag_cut_short_is_named_with_the_remedy(self):
        data = (self.folder / "clean.bag").read_bytes()
        cut = self.folder / "cut.bag"
        cut.write_bytes(data[: len(data) // 2])
        self.assert_refused(self.run_on("cut", cut), "cut.bag", "rosbag reindex")

    def test_damaged_message_costs_only_itself(self):
        bag = self.record("damaged")
        data = bytearray(bag.read_bytes())
        # The length of the encoding's text, in the middle of the recording.
        place = data.index(b"rgb8", len(data) // 2) - 4
        data[place:place + 4] = b"\xff\xff\xff\x7f"
        bag.write_bytes(bytes(data))
        output, done = self.run_on("damaged", bag)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.drops(output)["unreadable message"], 1)
        self.assertIn(box_room.COLOR, done.stderr)

    def test_reading_stops_at_max_frames(self):
        output, done = self.run_on("few", self.folder / "clean.bag", "--max-frames", "5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("5 frames", done.stdout)

    def test_wrong_type_of_topic_is_named(self):
        self.assert_refused(self.run_on("type", self.folder / "clean.bag", "--color-topic",
                                        box_room.INFO), box_room.INFO, "sensor_msgs/CameraInfo")

    # Plausibility (docs/plausibility.md); that the clean recording has none is tested above.

    def assert_found(self, result, *words):
        _, done = result
        lines = [line for line in done.stderr.splitlines() if line.startswith("plausibility: ")]
        self.assertEqual(len(lines), 1, done.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def test_wrong_unit_of_depth_is_found(self):
        self.assert_found(self.process("tenth", depth_units_per_m=10000.0), "depth range",
                          "--depth-scale", "0.0001")
        self.assert_found(self.process("metres", depth_units_per_m=1000.0, depth_encoding="32FC1"),
                          "depth range", "--depth-scale", "0.001")

    def test_axes_that_are_not_optical_are_found(self):
        R = np.eye(4)
        R[:3, :3] = OPTICAL_IN_BODY[:3, :3]
        self.assert_found(self.process("body_axes", T_moving_camera=R), "camera axes",
                          "x forward, y left, z up")
        self.assert_found(self.process("opengl_axes", T_moving_camera=np.diag([1.0, -1.0, -1.0, 1.0])),
                          "camera axes", "OpenGL")

    def test_inverted_poses_are_found_and_can_be_turned(self):
        path = self.folder / "inverted.txt"
        path.write_text(box_room.trajectory_lines(inverted=True))
        result = self.process("inverted", "--trajectory", path, pose=None)
        self.assert_found(result, "pose direction", "--poses")
        self.assert_same_map(self.run_on("turned", self.folder / "inverted.bag", "--trajectory", path,
                                         "--poses", "world-to-camera"))

    def test_depth_of_another_frame_is_named(self):
        self.assert_found(self.process("frames", depth_frame_id="camera_depth_optical_frame"),
                          "camera_depth_optical_frame", box_room.CAMERA_FRAME)

    def test_share_of_images_without_a_partner_is_told(self):
        self.assert_found(self.process("partners", depth_delay=lambda i: 0.0 if i % 2 else None),
                          "15 of 30", "--sync-tolerance")

    # Settings

    def test_section_input_of_the_configuration_holds(self):
        config = self.folder / "config.yaml"
        try:
            config.write_text(CONFIG + "input: {depth_scale: 2.5e-4, sync_tolerance_s: 0.04}\n")
            self.assert_same_map(self.process("section", depth_units_per_m=4000.0,
                                              depth_delay=lambda i: 0.033))
            self.assert_refused(self.run_on("wins", self.folder / "section.bag", "--sync-tolerance",
                                            "0.001"), "0.033 s away")
        finally:
            config.write_text(CONFIG)

    def test_configuration_of_the_live_chain_is_taken(self):
        config = self.folder / "config.yaml"
        try:
            config.write_text(CONFIG + "tracker: {frame_cache: 20, input: {queue_size: 9}}\n")
            self.assert_same_map(self.run_on("live_config", self.folder / "clean.bag"))
        finally:
            config.write_text(CONFIG)

    def test_preset_of_the_authors_bags(self):
        topics = {"color_topic": "/dominic/forward/color/image_raw",
                  "depth_topic": "/dominic/forward/depth/image_rect_raw",
                  "pose_topic": "/dominic/forward/colmap_odom"}
        numbers = f"{box_room.FX},{box_room.FY},{box_room.CX},{box_room.CY}"
        bag = self.record("clio", pose="odometry", info_at=[], moving_frame="whatever", **topics)
        self.assert_same_map(self.run_on("clio", bag, "--preset", "clio_dataset", "--intrinsics",
                                         numbers))
        self.assert_refused(self.run_on("no_preset", bag, "--preset", "nonsense"), "nonsense",
                            "presets")

    def test_contradicting_options_are_refused(self):
        path = self.folder / "walk.txt"
        path.write_text(box_room.trajectory_lines())
        self.assert_refused(self.run_on("both", self.folder / "clean.bag", "--trajectory", path,
                                        "--pose-topic", "/odom"), "pose_topic", "trajectory")


if __name__ == "__main__":
    unittest.main()
