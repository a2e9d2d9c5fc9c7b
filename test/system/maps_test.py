# SPDX-License-Identifier: BSD-3-Clause
"""Saved maps: going on from one, merging two, asking one without a ROS master, kill -9 and faults while saving."""
import json
import math
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from map_folders import cut_bag, find_lost, list_files, read_objects, run
from ros_session import PROGRAMS, SOURCE, Session, wait_until

DURATION_S = 16.0


class Maps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.bag = cls.folder / "home.bag"
        cls.tasks = cls.folder / "home.object_tasks.yaml"
        done = run("simulate_apartment", "--output", cls.bag, "--seed", "3", "--width", "160", "--height", "120",
                   "--duration", DURATION_S, "--rate", "10")
        assert done.returncode == 0, done.stderr
        cut_bag(cls.bag, cls.folder / "first.bag", 0.0, DURATION_S / 2)
        cut_bag(cls.bag, cls.folder / "second.bag", DURATION_S / 2, 1e9)
        for name, bag in (("whole", cls.bag), ("a", cls.folder / "first.bag"), ("b", cls.folder / "second.bag")):
            done = cls.process(name, bag)
            assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def process(cls, name, bag, *arguments, **options):
        return run("process_bag", "--bag", bag, "--object-tasks", cls.tasks, "--output", cls.folder / name,
                   *arguments, **options)

    def path(self, name):
        return self.folder / name

    def assert_same_objects(self, name):
        """By box overlap; a quarter of them may be cut otherwise where the walk was cut."""
        ours, whole = read_objects(self.path(name)), read_objects(self.path("whole"))
        self.assertGreater(len(whole), 3)
        self.assertLessEqual(len(find_lost(whole, ours)), 0.25 * len(whole), (ours, whole))
        self.assertLessEqual(len(find_lost(ours, whole)), 0.25 * len(ours), (ours, whole))

    def test_going_on_from_a_map_gives_the_objects_of_one_run(self):
        done = self.process("went_on", self.path("second.bag"), "--map", self.path("a"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_objects("went_on")
        lines = [len((self.path(name) / "trajectory.txt").read_text().splitlines()) for name in ("whole", "went_on")]
        self.assertLessEqual(abs(lines[0] - lines[1]), 2)

    def test_two_halves_merged_have_the_objects_of_one_run(self):
        done = run("merge_maps", self.path("a"), self.path("b"), self.path("merged"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_objects("merged")
        sources = json.loads((self.path("merged") / "map.json").read_text())["sources"]
        self.assertEqual([source["name"] for source in sources], [str(self.path("b"))])

    def test_maps_in_different_frames_need_a_transform(self):
        config = self.path("map_frame.yaml")
        config.write_text("input: {world_frame: other}\n")
        other = self.path("other_frame")
        shutil.copytree(str(self.path("b")), str(other))
        manifest = json.loads((other / "map.json").read_text())
        manifest["frame"] = "other"
        (other / "map.json").write_text(json.dumps(manifest))
        refused = run("merge_maps", self.path("a"), other, self.path("not_there"))
        self.assertEqual(refused.returncode, 1)
        self.assertIn("'other', expected 'world'", refused.stderr)
        self.assertFalse(self.path("not_there").exists())
        done = run("merge_maps", self.path("a"), other, self.path("with_transform"), "--transform", "0", "0", "0", "0",
                   "0", "0", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        wrong = run("merge_maps", self.path("a"), other, self.path("not_there"), "--transform", "0", "-1", "0")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("3 numbers, expected 7", wrong.stderr)

    def test_a_map_that_does_not_fit_is_refused_and_nothing_is_written(self):
        broken = self.path("broken")
        shutil.copytree(str(self.path("a")), str(broken))
        manifest = json.loads((broken / "map.json").read_text())
        cases = [("version", 2, "version 2, expected 1"), ("frame", "moon", "'moon', expected 'world'"),
                 ("embedding_size", 7, "7, expected")]
        for key, value, words in cases:
            (broken / "map.json").write_text(json.dumps({**manifest, key: value}))
            done = self.process("not_there", self.path("second.bag"), "--map", broken)
            self.assertEqual(done.returncode, 1, key)
            self.assertIn(words, done.stderr)
            self.assertIn(str(broken), done.stderr)
        (broken / "map.json").write_text(json.dumps(manifest))
        state = broken / "state" / "primitives.bin"
        state.write_bytes(state.read_bytes()[:-100])
        done = self.process("not_there", self.path("second.bag"), "--map", broken)
        self.assertIn("primitives.bin' is damaged", done.stderr)
        self.assertFalse(self.path("not_there").exists())

    def test_where_the_disk_is_full_the_map_of_before_stays(self):
        output = self.path("full_disk")
        shutil.copytree(str(self.path("a")), str(output))
        before = list_files(output)

        def limit_files():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

        done = self.process("full_disk", self.path("second.bag"), preexec_fn=limit_files, restore_signals=False)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("cannot write", done.stderr)
        self.assertEqual(list_files(output), before)

    def test_killed_at_any_moment_of_saving_a_whole_map_is_there(self):
        output = self.path("killed")
        shutil.copytree(str(self.path("a")), str(output))
        random.seed(4)
        num_killed = 0
        for round_number in range(20):
            program = subprocess.Popen(
                [str(PROGRAMS / "process_bag"), "--bag", str(self.path("second.bag")), "--object-tasks",
                 str(self.tasks), "--output", str(output), "--max-frames", "12"], stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL)
            deadline = time.monotonic() + 120.0
            while program.poll() is None and time.monotonic() < deadline:
                if any(output.glob(".sav*")):
                    time.sleep(random.uniform(0.0, 0.08))
                    program.kill()
                    num_killed += 1
                    break
                time.sleep(0.0005)
            program.wait()
            asked = run("ask_map", "--map", output, "--explain", "primitive", "999999")
            self.assertIn("primitive 999999 is not in the map", asked.stderr, round_number)
        self.assertGreater(num_killed, 5)
        done = self.process("killed", self.path("second.bag"), "--max-frames", "12")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([path.name for path in output.iterdir() if path.name.startswith(".")], [])

    # Questions to a saved map; no ROS master is there.

    def ask(self, *arguments):
        return run("ask_map", "--map", self.path("whole"), *arguments,
                   env={**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"})

    def embedding_of(self, node_letter):
        graph = json.loads((self.path("whole") / "scene_graph.json").read_text())
        for node in graph["nodes"]:
            feature = node["attributes"].get("semantic_feature", {}).get("data")
            if chr(node["id"] >> 56) == node_letter and feature:
                return node["id"] & (1 << 56) - 1, [value[0] if isinstance(value, list) else value
                                                    for value in feature]
        raise AssertionError("no node " + node_letter)

    def test_an_embedding_finds_the_object_that_has_it(self):
        number, vector = self.embedding_of("O")
        done = self.ask("--embedding", *vector)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"object +%d +score +1\.000" % number)

    def test_words_without_a_text_encoder_are_refused_with_the_reason(self):
        done = self.ask("coffee", "mug")
        self.assertEqual(done.returncode, 2)
        self.assertIn("text encoder", done.stderr)

    def test_reasons_are_given(self):
        number, _ = self.embedding_of("O")
        done = self.ask("--explain", "object", number)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("object %d" % number, done.stdout)
        absent = self.ask("--explain", "object", "999999")
        self.assertEqual(absent.returncode, 2)
        self.assertIn("999999", absent.stderr)

    def test_a_path_leads_to_an_object(self):
        done = [self.ask("--path-to", "object", number) for number in
                {node["id"] for room in json.loads((self.path("whole") / "summary.json").read_text())["rooms"]
                 for node in room["objects"]}]
        self.assertTrue(any(one.returncode == 0 and "path of" in one.stdout for one in done),
                        [one.stdout + one.stderr for one in done])

    def read_places(self):
        """Positions by id."""
        graph = json.loads((self.path("whole") / "scene_graph.json").read_text())
        return {node["id"] & (1 << 56) - 1: node["attributes"]["position"] for node in graph["nodes"]
                if chr(node["id"] >> 56) == "p"}

    def path_length(self, done):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return float(re.search(r"path of ([0-9.]+) m", done.stdout).group(1))

    def path_points(self, done):
        return [list(map(float, line.split()[:3])) for line in done.stdout.splitlines() if "  yaw " in line]

    def test_paths_lead_from_place_to_place(self):
        places = self.read_places()
        first, last = places[min(places)], places[max(places)]
        start = ["--from", *first]
        to_place = self.ask("--path-to", "place", max(places), *start)
        straight = math.hypot(first[0] - last[0], first[1] - last[1])
        self.assertGreaterEqual(self.path_length(to_place), straight - 1.0)
        points = self.path_points(to_place)
        self.assertLess(math.hypot(points[-1][0] - last[0], points[-1][1] - last[1]), 0.5)
        self.assertLess(math.hypot(points[0][0] - first[0], points[0][1] - first[1]), 0.5)
        to_point = self.ask("--path-to", "point", *last, *start)
        self.assertAlmostEqual(self.path_length(to_point), self.path_length(to_place), delta=0.01)

    def test_paths_lead_to_what_serves_a_task_and_to_regions(self):
        summary = json.loads((self.path("whole") / "summary.json").read_text())
        best = {}
        for room in summary["rooms"]:
            for thing in room["objects"]:
                if thing["task"] not in best or thing["score"] > best[thing["task"]]["score"]:
                    best[thing["task"]] = thing
        answers = [(self.ask("--path-to", "object", *task.split()), self.ask("--path-to", "object", thing["id"]))
                   for task, thing in best.items()]
        self.assertTrue(any(by_task.returncode == 0 for by_task, _ in answers))
        for by_task, by_id in answers:
            self.assertEqual((by_task.returncode, by_task.stdout), (by_id.returncode, by_id.stdout))
        rooms = [room["id"] for room in summary["rooms"] if room.get("id")]
        self.assertTrue(rooms)
        for room in rooms:
            self.assertGreater(self.path_length(self.ask("--path-to", "region", room)), 0.0)

    def test_goals_that_are_not_there_and_starts_in_the_void_are_named(self):
        for goal, words in [(["object", "999999"], "999999"), (["place", "999999"], "999999"),
                            (["region", "999999"], "999999"), (["point", "1", "x", "0"], "'x', expected a number"),
                            (["the", "moon"], "text encoder")]:
            done = self.ask("--path-to", *goal)
            self.assertEqual(done.returncode, 2, goal)
            self.assertIn(words, done.stderr)
        lost = self.ask("--path-to", "place", min(self.read_places()), "--from", "1000", "1000", "1")
        self.assertEqual(lost.returncode, 1, lost.stdout + lost.stderr)
        self.assertNotEqual(lost.stdout.strip(), "")

    def test_the_viewer_of_a_saved_map_plans_in_it(self):
        folder = self.path("viewer")
        folder.mkdir()
        session = Session(os.path.realpath(str(folder)))
        try:
            viewer = session.start([PROGRAMS / "view_map", "--map", self.path("whole"), "__ns:=/task_scene_graph"],
                                   "view_map")
            service = "/task_scene_graph/plan_path"
            wait_until(lambda: service in session.run("rosservice", "list").stdout.split(), "the viewer")
            goal = max(self.read_places())
            planned = session.run(SOURCE / "scripts" / "plan_path", "place", goal)
            self.assertAlmostEqual(self.path_length(planned), self.path_length(self.ask("--path-to", "place", goal)),
                                   delta=0.01)
            shown = session.run("rostopic", "echo", "-n", "1", "--noarr", "/task_scene_graph/path/header")
            self.assertIn("frame_id", shown.stdout)
            refused = session.run(SOURCE / "scripts" / "plan_path", "object", "999999")
            self.assertEqual(refused.returncode, 1)
            self.assertIn("999999", refused.stderr)
            self.assertTrue(viewer.is_running(), viewer.output())
        finally:
            session.close()

    def test_what_is_no_map_is_named(self):
        done = run("ask_map", "--map", self.folder, "mug")
        self.assertEqual(done.returncode, 2)
        self.assertIn("has no map.json", done.stderr)


if __name__ == "__main__":
    unittest.main()
