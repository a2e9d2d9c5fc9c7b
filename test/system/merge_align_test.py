# SPDX-License-Identifier: BSD-3-Clause
"""Two maps of one apartment in different coordinates become one without anybody saying how they lie."""
import json
import math
import pathlib
import re
import tempfile
import unittest

from map_folders import run, run_well
from ros_session import PROGRAMS, Session, wait_until

TURN = 2.2  # of the second map's coordinates, about the vertical
SHIFT = (7.0, -12.0, 0.3)


def turn(x, y, angle):
    return math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y


def move_pose(line):
    """A line of TUM's format in the second map's coordinates."""
    stamp, x, y, z, qx, qy, qz, qw = line.split()
    x, y = turn(float(x), float(y), TURN)
    qx, qy, qz, qw = map(float, (qx, qy, qz, qw))
    s, c = math.sin(TURN / 2), math.cos(TURN / 2)
    return " ".join([stamp] + ["%.9f" % v for v in (
        x + SHIFT[0], y + SHIFT[1], float(z) + SHIFT[2],
        c * qx - s * qy, c * qy + s * qx, c * qz + s * qw, c * qw - s * qz)]) + "\n"


class MergeAlign(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        for seed in (1, 2):
            run_well("simulate_apartment", "--seed", seed, "--width", 160, "--height", 120,
                     "--output", cls.folder / ("walk%d.bag" % seed))
        cls.make_map("first", 1, 0.0, 60.0, str)
        cls.make_map("second", 1, 40.0, 100.0, move_pose)
        cls.make_map("other", 2, 40.0, 100.0, move_pose)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def make_map(cls, name, seed, begin, end, change):
        walk = cls.folder / ("walk%d" % seed)
        poses = cls.folder / (name + ".tum")
        lines = pathlib.Path("%s.ground_truth/poses.txt" % walk).read_text().splitlines(True)
        poses.write_text("".join(change(line) for line in lines
                                 if not line.startswith("#") and begin <= float(line.split()[0]) <= end))
        run_well("process_bag", "--bag", "%s.bag" % walk, "--trajectory", poses, "--output", cls.folder / name,
                 "--object-tasks", "%s.object_tasks.yaml" % walk, "--place-tasks", "%s.place_tasks.yaml" % walk)

    def merge(self, a, b, out, *arguments):
        return run("merge_maps", self.folder / a, self.folder / b, self.folder / out, *arguments)

    def test_the_transform_is_found_and_used(self):
        done = self.merge("first", "second", "merged", "--align")
        self.assertEqual(done.returncode, 0, done.stderr)
        found = re.search(r"--transform ([-+.e0-9 ]+)", done.stdout)
        self.assertIsNotNone(found, done.stdout)
        x, y, z, qx, qy, qz, qw = map(float, found.group(1).split())
        angle = 2 * math.atan2(qz, qw)
        self.assertLess(abs(math.remainder(angle + TURN, 2 * math.pi)), 0.01)
        # Where the second map has what lies a few metres from the first one's origin.
        for p in ((0.0, 0.0), (5.0, 3.0)):
            moved = turn(*p, TURN)
            back = turn(moved[0] + SHIFT[0], moved[1] + SHIFT[1], angle)
            self.assertLess(math.hypot(back[0] + x - p[0], back[1] + y - p[1]), 0.15)
        self.assertLess(abs(z + SHIFT[2]), 0.05)
        by_hand = self.merge("first", "second", "by_hand", "--transform", *found.group(1).split())
        self.assertEqual(by_hand.returncode, 0, by_hand.stderr)
        objects = [re.search(r"(\d+) objects", text).group(1) for text in (done.stdout, by_hand.stdout)]
        self.assertEqual(objects[0], objects[1])

    def test_what_has_not_seen_the_same_is_refused(self):
        done = self.merge("first", "other", "wrong", "--align")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("maps not aligned", done.stderr)
        self.assertFalse((self.folder / "wrong").exists())

    def test_the_running_chain_finds_it_too(self):
        session = Session(self.folder)
        self.addCleanup(session.close)
        service = "/task_scene_graph/scene_graph/"
        for what in ("object_tasks", "place_tasks"):
            session.run("rosparam", "set", service + what, self.folder / ("walk1.%s.yaml" % what))
        session.start([PROGRAMS / "chain_node", "--recorded-segmentation", "__ns:=/task_scene_graph",
                       "__name:=manager"], "chain")

        def call(name, **request):
            done = session.run("rosservice", "call", service + name, json.dumps(request))
            return done.stdout + done.stderr

        wait_until(lambda: "load_map" in session.run("rosservice", "list").stdout, "the chain's services")
        loaded = call("load_map", folder=str(self.folder / "first"))
        self.assertIn("success: True", loaded)
        refused = call("merge_map", folder=str(self.folder / "other"), align=True)
        self.assertIn("success: False", refused)
        self.assertIn("maps not aligned", refused)
        refused = call("merge_map", folder=str(self.folder / "second"), align=True, has_transform=True)
        self.assertIn("expected one of them", refused)
        merged = call("merge_map", folder=str(self.folder / "second"), align=True)
        self.assertIn("success: True", merged)
        self.assertRegex(" ".join(merged.split()), r"things are in both\) say: --transform")
        done = self.merge("first", "second", "offline", "--align")
        counted = [int(re.search(r"(\d+) objects?", text).group(1)) for text in (merged, done.stdout)]
        self.assertEqual(counted[0], counted[1])

    def test_one_way_of_saying_it_is_enough(self):
        done = self.merge("first", "second", "both", "--align", "--transform", *"0000001")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("expected one of them", done.stderr)


if __name__ == "__main__":
    unittest.main()
