# SPDX-License-Identifier: BSD-3-Clause
"""kill -9 of the live chain at random moments, while it maps and saves again and again: the last complete map always
loads, and what was left half done is gone after the next save."""
import os
import pathlib
import random
import re
import shutil
import sys
import tempfile
import time
import unittest

from map_folders import run
from ros_session import PROGRAMS, Session, wait_until

NUM_KILLS = 20
SCENE_GRAPH = "/task_scene_graph/scene_graph"
# As the launch file remaps them.
REMAPS = ["__ns:=/task_scene_graph"] + ["%s:=/%s" % (name, name) for name in (
    "camera/color/image_raw", "camera/aligned_depth_to_color/image_raw", "camera/color/camera_info", "segmentation")]

# Calls a service again and again, whoever serves it; says when a call was answered.
CALLER = """
import sys, time
import rospy
from task_scene_graph.srv import MergeMap
from std_srvs.srv import Trigger
rospy.init_node(sys.argv[1], disable_signals=True)
kind, request = (MergeMap, {"folder": sys.argv[3]}) if len(sys.argv) > 3 else (Trigger, {})
while True:
    try:
        answer = rospy.ServiceProxy(sys.argv[2], kind)(**request)
        print("%s %.6f %s" % ("done" if answer.success else "failed", time.time(), answer.message.splitlines()),
              flush=True)
    except (rospy.ServiceException, rospy.ROSException) as error:
        print("gone", flush=True)
        time.sleep(0.02)
"""


def list_unfinished(folder):
    return {path.name for path in folder.glob(".sav*")}


class LiveKill(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(os.path.realpath(cls.temporary.name))
        cls.map = cls.folder / "map"
        cls.scratch = cls.folder / "tmp"
        cls.scratch.mkdir()
        cls.session = Session(cls.folder)
        cls.session.env["TMPDIR"] = str(cls.scratch)
        bag = cls.folder / "home.bag"
        done = run("simulate_apartment", "--output", bag, "--seed", "3", "--width", "160", "--height", "120",
                   "--duration", "12", "--rate", "10")
        assert done.returncode == 0, done.stderr
        for name, value in (("/use_sim_time", "true"), (SCENE_GRAPH + "/output", cls.map),
                            ("/task_scene_graph/mesh_fusion/output", cls.map),
                            (SCENE_GRAPH + "/object_tasks", cls.folder / "home.object_tasks.yaml")):
            done = cls.session.run("rosparam", "set", name, value)
            assert done.returncode == 0, done.stderr
        (cls.folder / "caller.py").write_text(CALLER)
        cls.player = cls.session.start(["rosbag", "play", "--clock", "--loop", "--quiet", bag], "player")

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        cls.temporary.cleanup()

    def setUp(self):
        random.seed(11)
        shutil.rmtree(str(self.map), ignore_errors=True)
        self.programs = []

    def tearDown(self):
        for program in self.programs:
            if program.is_running():
                program.kill()

    def start(self, command, name):
        program = self.session.start(command, name)
        self.programs.append(program)
        return program

    def start_chain(self):
        return self.start([PROGRAMS / "chain_node", "--recorded-segmentation", *REMAPS, "__name:=manager"], "chain")

    def start_caller(self, name, service, *arguments):
        return self.start([sys.executable, self.folder / "caller.py", name, SCENE_GRAPH + "/" + service, *arguments],
                          name)

    def count_saved(self, caller):
        return len(re.findall(r"^done ", caller.output(), re.M))

    def wait_saved(self, caller, count):
        wait_until(lambda: self.count_saved(caller) >= count, "save %d:\n%s" % (count, caller.output()[-2000:]))

    def newest_manifest_s(self):
        """When the map that counts was written."""
        for path in (self.map / ".saved" / "map.json", self.map / "map.json"):
            try:
                return path.stat().st_mtime
            except FileNotFoundError:
                pass
        return 0.0

    def assert_loads(self, message):
        asked = run("ask_map", "--map", self.map, "--explain", "primitive", "999999")
        self.assertIn("primitive 999999 is not in the map", asked.stderr, message)

    def assert_no_leftovers(self):
        self.assertEqual(list(self.scratch.iterdir()), [])
        self.assertEqual([path.name for path in self.map.rglob("*") if path.name.startswith(".") or ".tmp" in path.name],
                         [])

    def kill_amid_saves(self, num_kills, start, kill, excused):
        """Rounds of start, save again and again, kill. excused: what saves may be refused for."""
        caller = self.start_caller("saver", "save_map")
        num_amid = 0
        for number in range(num_kills):
            num_before, left_before = self.count_saved(caller), list_unfinished(self.map)
            programs = start()
            wait_until(lambda: self.count_saved(caller) > num_before or list_unfinished(self.map) != left_before,
                       "a save:\n" + "\n".join(program.output()[-2000:] for program in programs) +
                       caller.output()[-2000:])
            time.sleep(random.uniform(0.0, 0.8))
            is_answered, newest_s = self.count_saved(caller) > 0, self.newest_manifest_s()
            kill(programs)
            num_amid += bool(list_unfinished(self.map) - left_before)
            self.assertGreaterEqual(self.newest_manifest_s(), newest_s, number)
            if is_answered:
                self.assert_loads(number)
        print("%d saves; %d of %d kills were amid one" % (self.count_saved(caller), num_amid, num_kills),
              file=sys.stderr)
        self.assertGreaterEqual(self.count_saved(caller), num_kills / 2)
        self.assertGreater(num_amid, 0)
        for line in caller.output().splitlines():  # a map that lacks what mesh_fusion has is no success
            self.assertTrue(not line.startswith("done") or "/mesh_fusion: " in line, line)
        refused = [line for line in caller.output().splitlines() if line.startswith("failed")]
        self.assertEqual([line for line in refused if not re.search(excused, line)], [])
        caller.kill()

    def save_once_and_end(self):
        chain = self.start_chain()
        saver = self.start_caller("last_saver", "save_map")
        wait_until(lambda: self.count_saved(saver) > 0, "the last save:\n" + chain.output() + saver.output())
        saver.kill()
        self.assertEqual(chain.interrupt(), 0, chain.output())

    def test_the_last_complete_map_always_loads(self):
        self.kill_amid_saves(NUM_KILLS, lambda: [self.start_chain()], lambda programs: programs[0].kill(),
                             "neither primitives nor places")
        self.save_once_and_end()
        self.assert_no_leftovers()
        self.assert_loads("at the end")

    def test_where_one_of_several_processes_is_killed(self):
        """And started again, while the others go on."""
        running = {}

        def start():
            for name in ("tracker", "mesh_fusion", "scene_graph"):
                if name not in running or not running[name].is_running():
                    running[name] = self.start([PROGRAMS / (name + "_node"), *REMAPS, "__name:=" + name], name)
            return list(running.values())

        self.kill_amid_saves(8, start, lambda programs: running[random.choice(["mesh_fusion", "scene_graph"])].kill(),
                             "neither primitives nor places|missing: ")
        for program in running.values():
            program.kill()
        self.save_once_and_end()
        self.assert_no_leftovers()
        self.assert_loads("at the end")

    def test_what_a_killed_merge_left_is_gone_after_the_next(self):
        saver_chain = self.start_chain()
        saver = self.start_caller("saver", "save_map")
        wait_until(lambda: self.count_saved(saver) > 0, "a save:\n" + saver_chain.output())
        saver.kill()
        saver_chain.kill()
        other = self.folder / "other"
        shutil.copytree(str(self.map), str(other))
        merger = self.start_caller("merger", "merge_map", other)
        num_left = 0
        for _ in range(5):
            chain = self.start_chain()
            wait_until(lambda: any(self.scratch.iterdir()), "a merge:\n" + chain.output() + merger.output())
            time.sleep(random.uniform(0.0, 0.2))
            chain.kill()
            num_left += any(self.scratch.iterdir())
        self.assertGreater(num_left, 0)
        chain = self.start_chain()
        num_before = self.count_saved(merger)
        wait_until(lambda: self.count_saved(merger) > num_before, "the last merge:\n" + chain.output() +
                   merger.output())
        merger.kill()
        self.assertEqual(chain.interrupt(), 0, chain.output())
        self.assert_no_leftovers()
        self.assert_loads("at the end")


if __name__ == "__main__":
    unittest.main()
