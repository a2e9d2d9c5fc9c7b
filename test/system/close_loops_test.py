# SPDX-License-Identifier: BSD-3-Clause
"""From a recording whose odometry drifts to a map that is right: close_loops, then correct_map."""
import json
import pathlib
import re
import subprocess
import tempfile
import unittest

from map_folders import run, run_well
from ros_session import SOURCE

DRIFT = 0.02  # of the way, and a degree for each 10 m


def count_poses(path):
    return sum(1 for line in path.read_text().splitlines() if line and not line.startswith("#"))


class CloseLoops(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.bag = cls.folder / "walk.bag"
        cls.truth = cls.folder / "walk.ground_truth"
        cls.tasks = cls.folder / "walk.object_tasks.yaml"
        cls.corrected = cls.folder / "corrected.tum"
        run_well("simulate_apartment", "--seed", 1, "--laps", 2, "--drift", DRIFT, "--width", 160, "--height", 120,
                 "--output", cls.bag)
        cls.closed = run_well("close_loops", "--bag", cls.bag, "--output", cls.corrected,
                              "--list", cls.folder / "loops.json", "--truth", cls.truth / "poses.txt")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def score(self, folder):
        """Strict F1 of the objects."""
        out = self.folder / "scores.json"
        run_well("evaluate_scene_graph", "--map", folder, "--truth", self.truth / "tasks.yaml",
                  "--tasks", self.tasks, "--json", out)
        return json.loads(out.read_text())["paper"]["strict"]["f1"]

    def test_at_least_70_percent_of_the_drift_s_error_is_removed(self):
        error = re.search(r"error .*: ([0-9.]+) m before, ([0-9.]+) m after", self.closed)
        self.assertIsNotNone(error, self.closed)
        before, after = map(float, error.groups())
        print("trajectory: %.3f m before, %.3f m after" % (before, after), flush=True)
        self.assertGreater(before, 0.3)
        self.assertLess(after, 0.3 * before)

    def test_every_pose_is_there_and_every_pair_has_its_reason(self):
        self.assertEqual(count_poses(self.corrected), count_poses(self.truth / "odometry.txt"))
        pairs = json.loads((self.folder / "loops.json").read_text())
        self.assertGreater(sum(pair["accepted"] for pair in pairs), 10)
        for pair in pairs:
            self.assertTrue(pair["accepted"] or pair["reason"], pair)

    def test_the_map_that_follows_has_the_objects_where_they_are(self):
        drifted, fixed = self.folder / "drifted", self.folder / "fixed"
        run_well("process_bag", "--bag", self.bag, "--output", drifted, "--object-tasks", self.tasks,
                  "--place-tasks", self.folder / "walk.place_tasks.yaml")
        run_well("correct_map", "--map", drifted, "--trajectory", self.corrected, "--output", fixed)
        before, after = self.score(drifted), self.score(fixed)
        print("strict F1: %.3f drifted, %.3f corrected" % (before, after), flush=True)
        self.assertGreater(after, before + 0.3)  # 0.13 and 0.58; with true poses 0.87

    def plot(self, *arguments):
        return subprocess.run([str(SOURCE / "scripts" / "plot_loops"), "--before", str(self.truth / "odometry.txt"),
                               "--after", str(self.corrected), *map(str, arguments)], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=120)

    def test_a_picture_of_it_can_be_drawn(self):
        picture = self.folder / "loops.png"
        done = self.plot("--list", self.folder / "loops.json", "--truth", self.truth / "poses.txt", "--output", picture)
        if "python3-matplotlib" in done.stderr:
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        wrong = self.plot("--list", self.truth / "poses.txt", "--output", self.folder / "none.png")
        self.assertNotEqual(wrong.returncode, 0)
        self.assertIn("expected the list of close_loops", wrong.stderr)
        self.assertFalse((self.folder / "none.png").exists())

    def test_where_one_file_cannot_be_written_neither_is(self):
        folder = self.folder / "both"
        folder.mkdir()
        (folder / "file").write_text("no folder")
        for output, listed in (("a.tum", "file/list.json"), ("file/a.tum", "list.json"), ("a.tum", "."),
                               (".", "list.json")):
            done = run("close_loops", "--bag", self.bag, "--output", folder / output, "--list", folder / listed,
                       "--max-candidates", 1, "--max-drift", 0)
            self.assertNotEqual(done.returncode, 0, (output, listed))
            self.assertEqual([path.name for path in folder.iterdir()], ["file"], done.stderr)

    def test_what_is_not_there_is_named(self):
        output = self.folder / "none.tum"
        done = run("close_loops", "--bag", self.folder / "no.bag", "--output", output)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no.bag", done.stderr)
        self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
