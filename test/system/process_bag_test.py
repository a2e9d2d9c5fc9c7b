# SPDX-License-Identifier: BSD-3-Clause
"""The program process_bag: its files, that they are the same for any number of threads, its errors."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy
import rosbag
import yaml

PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph"
MAP_FILES = ["scene_graph.json", "summary.json", "mesh.ply"]


def run(program, *arguments, cwd=None, env=None):
    return subprocess.run([str(PROGRAMS / program), *map(str, arguments)], stdout=subprocess.PIPE, cwd=cwd,
                          env=env, stderr=subprocess.PIPE, universal_newlines=True, timeout=300)


def rename_frame(source, target, old, new):
    """Copies a bag with another name for the frame that tf's transforms lead to."""
    with rosbag.Bag(str(source)) as read, rosbag.Bag(str(target), "w") as written:
        for topic, message, time in read.read_messages():
            for transform in message.transforms if topic in ("/tf", "/tf_static") else []:
                if transform.header.frame_id == old:
                    transform.header.frame_id = new
            written.write(topic, message, time)


class ProcessBag(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.bag = cls.folder / "home.bag"
        cls.tasks = cls.folder / "home.object_tasks.yaml"
        cls.simulated = run("simulate_apartment", "--output", cls.bag, "--seed", "3", "--width", "160",
                            "--height", "120", "--duration", "12", "--rate", "10")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        self.assertEqual(self.simulated.returncode, 0, self.simulated.stderr)

    def process(self, name, *arguments, bag=None, tasks=None):
        output = self.folder / name
        return output, run("process_bag", "--bag", bag or self.bag, "--object-tasks",
                           tasks or self.tasks, "--output", output, *arguments)

    def configured(self, text):
        path = self.folder / "config.yaml"
        path.write_text(text)
        return "--config", path

    def assert_refused(self, done, *words):
        self.assertEqual(done.returncode, 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_files_are_the_same_for_any_number_of_threads(self):
        results = []
        for num_threads in (1, 2, 3):
            output, done = self.process(
                f"threads_{num_threads}",
                *self.configured(f"mesh_fusion:\n"
                                 f"  background: {{tsdf: {{num_threads: {num_threads}}}}}\n"
                                 f"  free_space: {{tsdf: {{num_threads: {num_threads}}}}}\n"
                                 f"scene_graph: {{num_threads: {num_threads}}}\n"))
            self.assertEqual(done.returncode, 0, done.stderr)
            results.append({name: (output / name).read_bytes() for name in MAP_FILES})
        for name in MAP_FILES:
            self.assertTrue(results[0][name] == results[1][name] == results[2][name], name)
        self.assertGreater(len(json.loads(results[0]["scene_graph.json"])["nodes"]), 10)

    def test_vertices_of_the_mesh_name_the_objects_they_belong_to(self):
        output, done = self.process("ids")
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads((output / "summary.json").read_text())
        objects = {row["id"]: row for room in summary["rooms"] for row in room["objects"]}
        data = (output / "mesh.ply").read_bytes()
        start = data.index(b"end_header\n") + len(b"end_header\n")
        count = int(data[:start].split(b"element vertex ")[1].split(b"\n")[0])
        vertices = numpy.frombuffer(data, offset=start, count=count, dtype=[
            ("position", "<f4", 3), ("rgb", "u1", 3), ("object_id", "<i4")])
        ids = set(vertices["object_id"].tolist())
        self.assertLessEqual(ids, {0} | set(objects))
        self.assertGreaterEqual(len(ids), 1 + len(objects) // 2)  # small things: no voxel of their own
        self.assertIn(0, ids)
        for row_id in ids - {0}:
            points = vertices["position"][vertices["object_id"] == row_id]
            self.assertTrue((points > numpy.array(objects[row_id]["box_min_m"]) - 0.06).all())
            self.assertTrue((points < numpy.array(objects[row_id]["box_max_m"]) + 0.06).all())

    def test_occupancy_map_is_written_where_it_is_enabled(self):
        output, done = self.process("occupancy",
                                    *self.configured("mesh_fusion: {occupancy: {enabled: true}}\n"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((output / "map.bt").read_bytes().startswith(b"# Octomap OcTree binary file"))
        self.assertTrue((output / "map.ot").read_bytes().startswith(b"# Octomap OcTree file"))

    def test_timing_counts_every_frame(self):
        output, done = self.process("timing")
        self.assertEqual(done.returncode, 0, done.stderr)
        timing = json.loads((output / "timing.json").read_text())
        self.assertEqual(timing["drops"], {})
        self.assertEqual(timing["stages"]["background"]["frames"], 121)
        for times in timing["stages"].values():
            self.assertLessEqual(times["p50_ms"], times["p95_ms"])
            self.assertLessEqual(times["p95_ms"], times["max_ms"])

    def test_place_tasks_are_a_list_of_their_own(self):
        output, done = self.process("places", "--place-tasks", self.folder / "home.place_tasks.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads((output / "summary.json").read_text())
        self.assertIn("corridor", [row["task"] for row in summary["rooms_per_task"]])
        self.assertNotIn("corridor", [row["task"] for row in summary["objects_per_task"]])

    def test_last_line_says_which_files_were_written_and_what_they_hold(self):
        output, done = self.process("line")
        self.assertEqual(done.returncode, 0, done.stderr)
        counts = json.loads((output / "summary.json").read_text())["counts"]
        line = done.stdout.splitlines()[-1]
        self.assertTrue(line.startswith(f"wrote {output}: scene_graph.json ({counts['objects']} object"), line)
        self.assertRegex(line, r"settings\.yaml, trajectory\.txt \(\d+ poses\), mesh\.ply \(\d+ vertices\), "
                               r"(floor_\d\.\w+( \([^)]*\))?, )*state \(to go on from\), map\.json, timing\.json$")
        for path in output.iterdir():
            self.assertIn(path.name, line)

    def test_without_a_usable_frame_the_last_line_says_that_no_map_was_written_and_why(self):
        output, done = self.process("no_frame", "--world-frame", "moon")
        self.assert_refused(done, "no map was written", "no transform, 121", "'moon'")
        self.assertFalse(output.exists())

    def test_settings_are_stored_and_can_be_used_again(self):
        output, done = self.process("first", *self.configured(
            "input: {sync_tolerance_s: 3e-2}\ntracker: {window_s: 3, frame_cache: 99}\n"))
        self.assertEqual(done.returncode, 0, done.stderr)
        settings = yaml.safe_load((output / "settings.yaml").read_text())
        self.assertEqual(settings["input"]["sync_tolerance_s"], 0.03)
        self.assertEqual(settings["tracker"]["window_s"], 3)
        self.assertEqual(settings["scene_graph"]["object_tasks"], str(self.tasks))
        self.assertEqual(settings["made_with"], {"program": "process_bag", "bag": [str(self.bag)]})
        again = self.folder / "again"
        done = run("process_bag", "--bag", self.bag, "--config", output / "settings.yaml", "--output", again)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in MAP_FILES:
            self.assertEqual((output / name).read_bytes(), (again / name).read_bytes(), name)

    def test_files_name_the_frame_of_the_map(self):
        bag = self.folder / "odom.bag"
        rename_frame(self.bag, bag, "world", "odom")
        output, done = self.process("odom", *self.configured("input: {world_frame: odom}\n"), bag=bag)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads((output / "summary.json").read_text())["frame"], "odom")
        graph = json.loads((output / "scene_graph.json").read_text())
        self.assertEqual(graph["metadata"]["frame"], "odom")
        self.assertIn(b"\ncomment frame odom\n", (output / "mesh.ply").read_bytes()[:200])

    def test_tilde_is_the_home_folder_and_no_folder_of_that_name_is_made(self):
        done = run("process_bag", "--bag", "~/home.bag", "--object-tasks", "file://~/home.object_tasks.yaml",
                   "--output=~/tilde", cwd=self.folder, env={**os.environ, "HOME": str(self.folder)})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.folder / "tilde" / "summary.json").exists())
        self.assertFalse((self.folder / "~").exists())

    def test_relative_paths_of_the_configuration_begin_at_its_folder(self):
        folder = self.folder / "relative"
        folder.mkdir()
        (folder / "my.yaml").write_text("output: map\nscene_graph: {object_tasks: ../home.object_tasks.yaml}\n")
        done = run("process_bag", "--bag", self.bag, "--config", folder / "my.yaml", cwd="/")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((folder / "map" / "summary.json").exists())

    def test_tasks_without_a_task_are_a_warning(self):
        tasks = self.folder / "none.yaml"
        tasks.write_text("tasks: []\n")
        _, done = self.process("no_tasks", tasks=tasks)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"task file '{tasks}' holds no task: there will be no objects", done.stderr)

    def test_parameters_of_the_nodelets_are_known_and_checked(self):
        _, done = self.process("none", *self.configured("tracker: {frame_cache: 0}\n"))
        self.assert_refused(done, "frame_cache")

    def test_neither_tasks_nor_output_is_a_usage_error(self):
        done = run("process_bag", "--bag", self.bag)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--object-tasks", done.stderr)

    def test_misspelt_parameter_is_named_with_the_nearest(self):
        _, done = self.process("none", *self.configured("tracker: {windw_s: 2.0}\n"))
        self.assert_refused(done, "windw_s", "window_s", "config.yaml")

    def test_missing_bag_is_named(self):
        _, done = self.process("none", bag=self.folder / "absent.bag")
        self.assert_refused(done, "absent.bag")

    def test_missing_task_file_is_named(self):
        _, done = self.process("none", tasks=self.folder / "absent.yaml")
        self.assert_refused(done, "absent.yaml")

    def test_tasks_without_embeddings_need_a_text_encoder(self):
        tasks = self.folder / "words.yaml"
        tasks.write_text("- get the mug\n")
        _, done = self.process("none", tasks=tasks)
        self.assert_refused(done, "words.yaml", "text")

    def test_without_segmentation_and_models_the_option_is_named(self):
        _, done = self.process("none", "--ignore-recorded-segmentation")
        self.assert_refused(done, "--models")

    def test_absent_topic_is_named(self):
        _, done = self.process("none", "--depth-topic", "/no/such/depth")
        self.assert_refused(done, "/no/such/depth")

    def test_unknown_option_is_a_usage_error(self):
        _, done = self.process("none", "--nonsense")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nonsense", done.stderr)


if __name__ == "__main__":
    unittest.main()
