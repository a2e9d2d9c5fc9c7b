# SPDX-License-Identifier: BSD-3-Clause
"""The program process_bag: its files, that they are the same for any number of threads, its errors."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph"
MAP_FILES = ["scene_graph.json", "summary.json", "mesh.ply"]


def run(program, *arguments):
    return subprocess.run([str(PROGRAMS / program), *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, timeout=300)


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

    def test_misspelt_parameter_is_named_with_the_nearest(self):
        _, done = self.process("none", *self.configured("tracker: {windw_s: 2.0}\n"))
        self.assert_refused(done, "tracker/windw_s", "window_s")

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
