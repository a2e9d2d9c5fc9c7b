# SPDX-License-Identifier: BSD-3-Clause
"""A walk through a house (house_a) in two halves: going on from the map of the first, and both merged, give the map
of one run."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

from map_folders import compute_iou, cut_bag, find_lost, read_objects, run
from ros_session import SOURCE

HOUSE = pathlib.Path(os.environ.get("TSG_SHARED") or SOURCE.parent / "shared") / "data" / "house_a"
STRIDE = 2  # 200 of the 400 images: 5 Hz, as segmenters run
NUM_FRAMES = 200
HALF_S = 20.0


def find_least_overlap(objects, others):
    return min(max(compute_iou(a, b) for b in others if a[0] == b[0]) for a in objects)


@unittest.skipUnless(HOUSE.is_dir(), f"{HOUSE} is not here (TSG_SHARED names the folder that has data/house_a)")
class HouseMaps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.first, cls.second = cls.folder / "first.bag", cls.folder / "second.bag"
        bag = cls.folder / "house_a.bag"
        done = subprocess.run([str(SOURCE / "scripts" / "dataset_to_bag"), "--input", str(HOUSE), "--output", str(bag),
                               "--stride", str(STRIDE)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True, timeout=600)
        assert done.returncode == 0, done.stdout
        cut_bag(bag, cls.first, 0.0, HALF_S)
        cut_bag(bag, cls.second, HALF_S, 1e9)
        bag.unlink()  # hundreds of megabytes
        cls.process("whole", cls.first, cls.second)
        cls.process("a", cls.first)
        cls.process("b", cls.second)
        cls.process("went_on", cls.second, "--map", cls.folder / "a")
        done = run("merge_maps", cls.folder / "a", cls.folder / "b", cls.folder / "merged")
        assert done.returncode == 0, done.stderr

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def process(cls, name, *bags_and_options):
        done = run("process_bag", "--object-tasks", cls.folder / "house_a.object_tasks.yaml", "--place-tasks",
                   cls.folder / "house_a.place_tasks.yaml", "--output", cls.folder / name, "--bag", *bags_and_options)
        assert done.returncode == 0, done.stderr

    def objects(self, name):
        return read_objects(self.folder / name)

    def count(self, name, what):
        return json.loads((self.folder / name / "summary.json").read_text())["counts"][what]

    def assert_same_map(self, name):
        ours, whole = self.objects(name), self.objects("whole")
        print("%s: %d objects, %d in one run; least overlap %.2f and %.2f" % (
            name, len(ours), len(whole), find_least_overlap(whole, ours), find_least_overlap(ours, whole)))
        self.assertEqual(find_lost(whole, ours), [])
        self.assertEqual(find_lost(ours, whole), [])
        self.assertEqual(len(ours), len(whole))
        self.assertEqual(self.count(name, "rooms"), self.count("whole", "rooms"))
        self.assertAlmostEqual(self.count(name, "places"), self.count("whole", "places"),
                               delta=0.1 * self.count("whole", "places"))

    def test_neither_half_has_all_objects(self):
        """Else the comparisons below would show nothing."""
        whole = self.objects("whole")
        self.assertGreaterEqual(len(whole), 30)
        for half in ("a", "b"):
            self.assertGreaterEqual(len(find_lost(whole, self.objects(half))), 3, half)

    def test_going_on_from_the_first_half_gives_the_map_of_one_run(self):
        self.assert_same_map("went_on")

    def test_both_halves_merged_give_the_map_of_one_run(self):
        self.assert_same_map("merged")

    def test_the_way_of_the_camera_is_that_of_one_run(self):
        ways = {name: (self.folder / name / "trajectory.txt").read_text() for name in ("whole", "went_on", "merged")}
        self.assertEqual(sum(not line.startswith("#") for line in ways["whole"].splitlines()), NUM_FRAMES)
        self.assertEqual(ways["went_on"], ways["whole"])
        self.assertEqual(ways["merged"], ways["whole"])

    def test_objects_of_the_first_half_keep_their_ids(self):
        """But for those that became one."""
        tasks = {name: {thing["id"]: thing["task"] for room in
                        json.loads((self.folder / name / "summary.json").read_text())["rooms"]
                        for thing in room["objects"]} for name in ("a", "went_on", "merged")}
        for name in ("went_on", "merged"):
            kept = [number for number in tasks["a"] if tasks[name].get(number) == tasks["a"][number]]
            print("%s: %d of %d objects of the first half have their ids" % (name, len(kept), len(tasks["a"])))
            self.assertGreaterEqual(len(kept), 0.9 * len(tasks["a"]))


if __name__ == "__main__":
    unittest.main()
