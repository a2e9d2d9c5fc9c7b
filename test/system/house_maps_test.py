# SPDX-License-Identifier: BSD-3-Clause
"""A walk through a house (house_a). In two halves: going on from the map of the first, and both merged, give the map of
one run. With other tasks and thresholds while the chain runs: the objects are those of a run that had them from the
start."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import yaml

from map_folders import compute_iou, cut_bag, find_lost, read_objects, run
from ros_session import PROGRAMS, SOURCE, Session, wait_until

HOUSE = pathlib.Path(os.environ.get("TSG_SHARED") or SOURCE.parent / "shared") / "data" / "house_a"
STRIDE = 2  # 200 of the 400 images: 5 Hz, as segmenters run
NUM_FRAMES = 200
HALF_S = 20.0
CHAIN = "/task_scene_graph"
STAGE = CHAIN + "/scene_graph"

# Tasks of a file, by their embeddings: what a robot program does that has an encoder of its own.
CHANGER = """
import sys
import rospy, yaml
from task_scene_graph_client import SceneGraphClient, make_task
rospy.init_node("changer", disable_signals=True)
tasks = yaml.safe_load(open(sys.argv[1]))["tasks"]
in_force = SceneGraphClient(timeout_s=60.0).set_tasks([make_task(task["name"], task["embedding"]) for task in tasks])
print(sum(task.count for task in in_force.object_tasks))
"""


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
    def process(cls, name, *bags_and_options, tasks="house_a.object_tasks.yaml"):
        done = run("process_bag", "--object-tasks", cls.folder / tasks, "--place-tasks",
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

    # The chain with the map of one run, and what is turned while it lives.

    def start_chain(self):
        folder = self.folder / "live"
        folder.mkdir(exist_ok=True)
        session = Session(folder)
        self.addCleanup(session.close)
        for name, value in ((STAGE + "/output", folder / "map"), (CHAIN + "/mesh_fusion/output", folder / "map"),
                            (STAGE + "/map", self.folder / "whole"), (CHAIN + "/mesh_fusion/map", self.folder / "whole"),
                            (STAGE + "/object_tasks", self.folder / "house_a.object_tasks.yaml"),
                            (STAGE + "/place_tasks", self.folder / "house_a.place_tasks.yaml")):
            done = session.run("rosparam", "set", name, value)
            self.assertEqual(done.returncode, 0, done.stderr)
        chain = session.start([PROGRAMS / "chain_node", "--recorded-segmentation", "__ns:=" + CHAIN, "__name:=manager"],
                              "chain")
        wait_until(lambda: STAGE + "/save_map" in session.run("rosservice", "list").stdout.split(),
                   "the chain:\n" + chain.output())
        return session

    def save(self, session):
        """The objects of now; primitives are what they were."""
        saved = session.run("rosservice", "call", STAGE + "/save_map")
        self.assertIn("success: True", saved.stdout, saved.stdout + saved.stderr)
        live = self.folder / "live" / "map"
        primitives = [(folder / "state" / "primitives.bin").read_bytes() for folder in (live, self.folder / "whole")]
        self.assertEqual(*primitives)
        return sorted(read_objects(live))

    def tune(self, session, **values):
        done = session.run("rosrun", "dynamic_reconfigure", "dynparam", "set", STAGE, json.dumps(values))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_other_tasks_give_the_objects_of_a_run_that_had_them_from_the_start(self):
        tasks = yaml.safe_load((self.folder / "house_a.object_tasks.yaml").read_text())["tasks"]
        others = self.folder / "others.yaml"
        others.write_text(yaml.safe_dump({"tasks": tasks[len(tasks) // 2:] + tasks[:3]}))
        self.process("with_others", self.first, self.second, tasks=others)
        session = self.start_chain()
        before = self.save(session)
        self.assertEqual(before, sorted(self.objects("whole")))
        (self.folder / "changer.py").write_text(CHANGER)
        for file, name in ((others, "with_others"), (self.folder / "house_a.object_tasks.yaml", "whole")):
            changed = session.run(sys.executable, self.folder / "changer.py", file)
            self.assertEqual(changed.returncode, 0, changed.stderr)
            self.assertEqual(self.save(session), sorted(self.objects(name)))
            self.assertEqual(int(changed.stdout), len(self.objects(name)))
        self.assertNotEqual(sorted(self.objects("with_others")), before)

    def test_other_thresholds_give_the_objects_of_a_run_that_had_them_from_the_start(self):
        before = sorted(self.objects("whole"))
        session = self.start_chain()
        for number, values in enumerate(({"object_alpha": 0.29}, {"object_alpha": 0.23, "object_delta": 0.1})):
            config = self.folder / "tuned.yaml"
            config.write_text(yaml.safe_dump({"scene_graph": values}))
            self.process("tuned_%d" % number, self.first, self.second, "--config", config)
            self.tune(session, **values)
            tuned = sorted(self.objects("tuned_%d" % number))
            self.assertNotEqual(tuned, before, values)
            self.assertEqual(self.save(session), tuned, values)
        self.tune(session, object_delta=1e-5)
        self.assertEqual(self.save(session), before)


if __name__ == "__main__":
    unittest.main()
