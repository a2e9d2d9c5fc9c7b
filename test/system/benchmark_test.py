#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""evaluate_scene_graph and scripts/benchmark: from a generated world to the table."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.environ["TSG_SOURCE_DIR"]
PROGRAMS = os.path.join(os.environ["TSG_BUILD_DIR"], "devel", "lib", "task_scene_graph")
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
from evaluation import figures, report, results, study  # noqa: E402


def run(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=600, check=False)


def make_node(index, center, size, embedding, layer=2):
    identity = {"w": 1, "x": 0, "y": 0, "z": 0}
    return {"id": (ord("O") << 56) + index, "layer": layer, "partition": 0, "attributes": {
        "type": "KhronosObjectAttributes", "position": center, "name": "", "is_active": False,
        "bounding_box": {"type": "AABB", "dimensions": size, "world_P_center": center,
                         "world_R_center": identity},
        "semantic_feature": embedding}}


class EvaluateSceneGraph(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.write("truth.yaml", "cup: [{center: [0, 0, 0], extents: [1, 1, 1]}]\n"
                                 "sofa: [{center: [5, 0, 0], extents: [2, 1, 1]}]\n")
        self.write("tasks.yaml", "tasks:\n- {name: sofa, embedding: [0, 1, 0]}\n"
                                 "- {name: cup, embedding: [1, 0, 0]}\n")
        self.write_map([make_node(0, [0, 0, 0], [1, 1, 1], [0.9, 0.1, 0.4]),
                        make_node(1, [5.2, 0, 0], [2, 1, 1], [0.1, 0.9, 0.4])])

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def write_map(self, nodes):
        self.write("scene_graph.json", json.dumps({"nodes": nodes, "edges": []}))

    def evaluate(self, *options):
        return run(os.path.join(PROGRAMS, "evaluate_scene_graph"), "--map", self.folder.name,
                   "--truth", self.path("truth.yaml"), "--tasks", self.path("tasks.yaml"), *options)

    def test_scores_are_those_of_the_boxes(self):
        done = self.evaluate("--json", self.path("scores.json"))
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.path("scores.json"), encoding="utf-8") as file:
            scores = json.load(file)["paper"]
        self.assertEqual(scores["strict"], {"recall": 1.0, "precision": 1.0, "f1": 1.0})
        self.assertAlmostEqual(scores["iou"], (1.0 + 1.8 / 2.2) / 2.0, 6)
        self.assertEqual([row["task"] for row in scores["tasks"]], ["cup", "sofa"])
        self.assertIn("osR 1.000", done.stdout)

    def test_objects_far_from_every_task_are_left_out_on_request(self):
        done = self.evaluate("--min-cosine", "0.95")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("kept 0 of 0 objects", done.stdout)

    def test_named_segments_are_refused(self):
        done = self.evaluate("--named", "--layer", "segments")
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn("--named", done.stdout)

    def test_objects_of_no_task_are_left_out_on_request(self):
        named = make_node(0, [0, 0, 0], [1, 1, 1], [0.9, 0.1, 0.4])
        named["attributes"]["name"] = "cup"
        self.write_map([named, make_node(1, [5.2, 0, 0], [2, 1, 1], [0.1, 0.9, 0.4])])
        done = self.evaluate("--named")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("kept 1 of 1 objects", done.stdout)

    def test_false_objects_and_the_share_of_right_ones_by_cosine_are_told(self):
        self.write("truth.yaml", "cup: [{center: [0, 0, 0], extents: [1, 1, 1]}]\nsofa: []\n")
        done = self.evaluate("--json", self.path("scores.json"))
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.path("scores.json"), encoding="utf-8") as file:
            scores = json.load(file)
        self.assertEqual(scores["paper"]["num_false"], 1)  # the sofa that nobody has
        self.assertEqual(sum(row["num_objects"] for row in scores["calibration"]["bins"]), 2)
        self.assertEqual(sum(row["num_right"] for row in scores["calibration"]["bins"]), 1)
        self.assertIn("for tasks that nothing serves", done.stdout)

    def test_regions_are_scored_against_true_rooms(self):
        place = {"id": 10, "layer": 3, "attributes": {
            "type": "PlaceNodeAttributes", "position": [0.5, 0.5, 0.6], "distance": 0.5}}
        room = {"id": 90, "layer": 4, "attributes": {"type": "RoomNodeAttributes"}}
        self.write("scene_graph.json", json.dumps({
            "nodes": [place, room, make_node(0, [0, 0, 0], [1, 1, 1], [0.9, 0.1, 0.4])],
            "edges": [{"source": 90, "target": 10}]}))
        self.write("rooms.json", json.dumps({"rooms": [
            {"name": "hall", "rectangle_m": [0, 0, 2, 2], "height_m": 2.6}]}))
        done = self.evaluate("--rooms", self.path("rooms.json"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("no floor_0.yaml", done.stdout)
        self.write("floor_0.yaml", "image: f.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n"
                                   "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")
        with open(self.path("f.pgm"), "wb") as file:
            file.write(b"P5\n20 20\n255\n" + bytes([254]) * 400)
        done = self.evaluate("--rooms", self.path("rooms.json"), "--json", self.path("scores.json"))
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.path("scores.json"), encoding="utf-8") as file:
            regions = json.load(file)["regions"]
        self.assertEqual((regions["precision"], regions["num_rooms"]), (1.0, 1))
        self.assertAlmostEqual(regions["recall"], 0.19, delta=0.03)  # a disc of 0.5 m in 2 m x 2 m

    def test_going_to_things_needs_a_map_folder_with_places(self):
        self.write("mesh.ply", "ply\n")
        done = self.evaluate("--true-mesh", self.path("mesh.ply"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("map.json", done.stdout)
        done = run(os.path.join(PROGRAMS, "evaluate_scene_graph"), "--map",
                   self.path("scene_graph.json"), "--truth", self.path("truth.yaml"), "--tasks",
                   self.path("tasks.yaml"), "--true-mesh", self.path("mesh.ply"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("is no folder", done.stdout)

    def test_classes_of_vertices_are_scored_against_a_labelled_mesh(self):
        head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n" \
               "property float z\nproperty int {}\nend_header\n"
        self.write("mesh.ply", head.format(3, "object_id") + "0 0 0 0\n0 0 0.5 1\n5 0 0 1\n")
        self.write("labels.ply", head.format(4, "label") +
                   "0 0 0.5 0\n5 0 0.05 0\n5 0 0 1\n9 9 9 -1\n")
        self.write_map([make_node(1, [0, 0, 0], [1, 1, 1], [0.9, 0.1, 0.4])])
        done = self.evaluate("--labels", self.path("labels.ply"), "--json", self.path("scores.json"))
        self.assertEqual(done.returncode, 0, done.stdout)
        with open(self.path("scores.json"), encoding="utf-8") as file:
            classes = json.load(file)["classes"]
        self.assertEqual(classes["recalls"], [1.0, 0.0])  # the sofa's vertex is the cup's object's
        self.assertAlmostEqual(classes["weighted_iou"], 4.0 / 9.0)
        self.write("labels.ply", "solid\n")
        done = self.evaluate("--labels", self.path("labels.ply"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("labels.ply", done.stdout)

    def test_task_of_the_truth_without_embedding_is_named(self):
        self.write("tasks.yaml", "tasks:\n- {name: sofa, embedding: [0, 1, 0]}\n")
        done = self.evaluate()
        self.assertEqual(done.returncode, 1)
        self.assertIn("'cup'", done.stdout)

    def test_embeddings_of_another_size_are_named(self):
        self.write_map([make_node(0, [0, 0, 0], [1, 1, 1], [1, 0])])
        done = self.evaluate()
        self.assertEqual(done.returncode, 1)
        self.assertIn("2 numbers, expected the tasks' 3", done.stdout)

    def test_nodes_that_cannot_be_read_are_left_out_and_named(self):
        bad = make_node(7, [0, 0, 0], [1, 1, 1], [1, 0, 0])
        del bad["attributes"]["bounding_box"]
        self.write_map([make_node(0, [0, 0, 0], [1, 1, 1], [1, 0, 0]), bad])
        done = self.evaluate()
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("left out: O7", done.stdout)
        self.assertIn("bounding_box", done.stdout)

    def test_map_whose_nodes_cannot_be_read_is_no_empty_map(self):
        bad = make_node(7, [0, 0, 0], [1, 1, 1], [1, 0, 0])
        del bad["attributes"]["semantic_feature"]
        self.write_map([bad])
        done = self.evaluate()
        self.assertEqual(done.returncode, 1)
        self.assertIn("no node that can be scored among 1", done.stdout)

    def test_wrong_words_are_answered_with_the_right_ones(self):
        done = self.evaluate("--layer", "rooms")
        self.assertEqual(done.returncode, 2)
        self.assertIn("objects, segments", done.stdout)


def make_result(method, f1, world="apartment", level="none"):
    scores = {"recall": f1, "precision": f1, "f1": f1}
    return {"world": world, "level": level, "method": method, "ms_per_frame": 5.0,
            "scores": {"paper": {"strict": scores, "relaxed": scores, "iou": 0.5,
                                 "num_objects": 10}}}


class Report(unittest.TestCase):
    def test_mean_and_sample_deviation(self):
        table = report.make_table({"clio": [make_result("clio", 0.8), make_result("clio", 0.9)]})
        self.assertIn("0.850 ± 0.071", table)

    def test_regions_and_calibration_have_tables_where_they_were_scored(self):
        one, other = make_result("clio", 0.8), make_result("khronos", 0.5)
        text = report.make_report([one, other], "command")
        self.assertNotIn("Regions", text)
        one["scores"]["regions"] = {"precision": 0.9, "recall": 0.8, "f1": 0.847, "num_regions": 6,
                                    "num_rooms": 5}
        one["scores"]["calibration"] = {"separation": 0.9, "bins": [
            {"low": 0.22, "num_objects": 4, "num_right": 1},
            {"low": 0.28, "num_objects": 5, "num_right": 5}]}
        text = report.make_report([one, other], "command")
        self.assertIn("| apartment | none | clio | 0.900 | 0.800 | 0.847 | 6.0 | 5.0 |", text)
        self.assertIn("| clio | 0.25 of 4 | 1.00 of 5 |", text)

    def test_curve_of_several_maps_is_the_mean_at_each_cosine(self):
        def make_row(*points):
            return {"scores": {"precision_recall": [
                {"min_cosine": cosine, "precision": precision, "recall": recall}
                for cosine, precision, recall in points]}}
        line = figures.average_curve([make_row((0.2, 0.5, 0.8), (0.3, 1.0, 0.4)),
                                      make_row((0.25, 0.7, 0.6)), {"scores": {}}])
        # 0.3: nothing of the second map is left; 0.25: the first has what it has from 0.3 on.
        self.assertEqual(line, [(0.2, 1.0), (0.5, 0.85), (0.7, 0.6)])

    def test_figures_are_drawn_where_matplotlib_is(self):
        one, other = make_result("clio", 0.8), make_result("cg", 0.5, level="hard")
        one["stages"] = {"tracking": 1.5, "places": 0.5}
        one["scores"]["precision_recall"] = [{"min_cosine": 0.2, "precision": 1, "recall": 0.5}]
        with tempfile.TemporaryDirectory() as folder:
            drawn = figures.draw([one, other], folder)
            self.assertEqual(sorted(os.listdir(folder)), sorted(drawn))
            self.assertEqual(figures.draw([], folder), [])

    def test_comparison_has_the_change(self):
        lines = report.compare([make_result("clio", 0.8)], [make_result("clio", 0.9)])
        self.assertIn("| apartment | none | clio | 0.800 | 0.900 | +0.100 |", lines)

    def test_study_averages_recordings_that_have_every_value(self):
        def make_row(recording, value, f1):
            return {"world": "cubicle", "recording": recording, "parameter": "prior", "value": value,
                    "f1": f1, "relaxed_f1": f1, "iou": f1, "num_objects": 10}
        rows = [make_row("a", "uniform", 0.8), make_row("a", "marginal", 0.4),
                make_row("b", "uniform", 0.6), make_row("b", "marginal", 0.2),
                make_row("stopped early", "uniform", 0.1)]
        text = study.make_report(rows, "command")
        self.assertIn("| uniform (default) | 0.700 | 0.700 | 0.700 | 10.0 |", text)
        self.assertIn("| marginal | 0.300 |", text)
        self.assertIn("Means over 2 pairs ", text)
        self.assertNotIn("## alpha", text)

    def test_damaged_result_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "clio.result.json")
            with open(path, "w", encoding="utf-8") as file:
                file.write('{"world": ')
            with self.assertRaisesRegex(ValueError, "clio.result.json"):
                results.load_all(folder)


class Benchmark(unittest.TestCase):
    def test_smoke_suite_makes_the_table_and_a_second_run_makes_nothing_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [os.path.join(SOURCE, "scripts", "benchmark"), "--output", folder, "--suite",
                       "smoke", "--methods", "clio", "clio_online", "clio_batch", "khronos_task"]
            done = run(*command)
            self.assertEqual(done.returncode, 0, done.stdout)
            with open(os.path.join(folder, "report.md"), encoding="utf-8") as file:
                text = file.read()
            self.assertRegex(text, r"\| clio \| [0-9.]+ ")
            self.assertRegex(text, r"\| clio_batch \| [0-9.]+ ")
            self.assertRegex(text, r"\| khronos_task \| [0-9.]+ ")
            found = results.load_all(folder)
            self.assertEqual([row["method"] for row in found], ["clio", "clio_batch", "clio_online", "khronos_task"])
            # Clustered while the walk went on, or at once at the end: the same objects.
            live, batch = (row["scores"]["paper"] for row in found[:2])
            for kind in ("strict", "relaxed", "num_objects", "num_kept"):
                self.assertEqual(batch[kind], live[kind], kind)
            self.assertAlmostEqual(batch["iou"], live["iou"], 4)
            used, untracked, recorded = found[2]["frames"]
            self.assertLess(untracked, recorded)
            self.assertGreater(recorded, 50)
            self.assertGreater(used, 0.5 * recorded)  # a busy machine may drop some
            self.assertGreater(found[2]["scores"]["paper"]["num_objects"], 0)
            self.assertIn("## Frames of the live chain", text)
            self.assertGreater(found[0]["scores"]["paper"]["num_objects"], 0)
            self.assertIn("regions", found[0]["scores"])
            self.assertGreater(found[0]["scores"]["classes"]["mean_accuracy"], 0.1)
            self.check_goals(found[0]["scores"]["goals"])
            self.assertIn("## Going to things", text)
            again = run(*command)
            self.assertEqual(again.returncode, 0, again.stdout)
            self.assertNotIn("strict F1", again.stdout)

    def check_goals(self, goals):
        """In the first seconds of a walk most things are not seen, but some are gone to."""
        self.assertEqual(len(goals["tasks"]), goals["num_tasks"] + goals["num_unreachable"])
        self.assertGreater(goals["num_tasks"], 10)
        self.assertGreater(goals["success"], 0.0)
        self.assertLessEqual(goals["success"], min(goals["right"], goals["path"], goals["free"]))
        self.assertLessEqual(goals["spl"], goals["success"])
        for row in goals["tasks"]:
            if row["is_right"] and row["is_free"] and row["is_reachable"]:
                self.assertGreater(row["path_m"], 0.8 * row["shortest_m"] - 0.5, row)

    def test_study_makes_curves_and_a_second_run_makes_nothing_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            command = [os.path.join(SOURCE, "scripts", "benchmark"), "--output", folder, "--suite",
                       "smoke", "--study", "--parameters", "alpha", "min_observations"]
            done = run(*command)
            self.assertEqual(done.returncode, 0, done.stdout)
            with open(os.path.join(folder, "study.json"), encoding="utf-8") as file:
                rows = json.load(file)["rows"]
            values = {p.name: p.values for p in study.PARAMETERS}
            alpha = {row["value"]: row for row in rows if row["parameter"] == "alpha"}
            self.assertEqual(sorted(alpha), values["alpha"])
            self.assertGreater(alpha[0.23]["f1"], 0.0)
            # What is left lies above alpha, and more observations leave fewer tracks.
            self.assertGreaterEqual(alpha[0.17]["num_objects"], alpha[0.28]["num_objects"])
            seen = {row["value"]: row for row in rows if row["parameter"] == "min_observations"}
            self.assertEqual(sorted(seen), values["min_observations"])
            self.assertGreater(seen[1]["num_objects"], seen[5]["num_objects"])
            with open(os.path.join(folder, "study.md"), encoding="utf-8") as file:
                self.assertRegex(file.read(), r"\| 0.23 \(default\) \| 0\.[0-9]+ ")
            again = run(*command)
            self.assertEqual(again.returncode, 0, again.stdout)
            self.assertNotIn("strict F1", again.stdout)

    def test_unknown_parameter_is_refused_with_the_known_ones(self):
        done = run(os.path.join(SOURCE, "scripts", "benchmark"), "--study", "--parameters", "luck")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'luck'", done.stdout)
        self.assertIn("top_k", done.stdout)

    def test_worlds_have_two_lists_and_maps_without_tasks_are_made_once(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run(os.path.join(SOURCE, "scripts", "benchmark"), "--output", folder, "--suite",
                       "smoke", "--worlds", "cubicle", "--methods", "khronos_task")
            self.assertEqual(done.returncode, 0, done.stdout)
            worlds = {result["world"] for result in results.load_all(folder)}
            self.assertEqual(worlds, {"cubicle", "cubicle (coarse tasks)"})
            with open(os.path.join(folder, "log.txt"), encoding="utf-8") as file:
                self.assertEqual(file.read().count("$ process_bag"), 1)

    def test_unknown_method_is_refused_with_the_known_ones(self):
        done = run(os.path.join(SOURCE, "scripts", "benchmark"), "--methods", "magic")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'magic'", done.stdout)
        self.assertIn("khronos_task", done.stdout)


if __name__ == "__main__":
    unittest.main()
