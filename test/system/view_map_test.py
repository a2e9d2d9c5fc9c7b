# SPDX-License-Identifier: BSD-3-Clause
"""A saved map shown by view_map: what rviz, its panel and robot programs ask of a running chain, without one."""
import json
import pathlib
import re
import tempfile
import unittest

import yaml
from ros_session import PROGRAMS, SOURCE, Session, wait_until

CHAIN = "/task_scene_graph"
STAGE = CHAIN + "/scene_graph"


class ViewMap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.temporary.name)
        cls.map = folder / "map"
        cls.session = Session(folder)
        cls.make_map(folder)
        cls.session.start(["roslaunch", "task_scene_graph", "view_map.launch", "map:=%s" % cls.map, "rviz:=false"],
                          "view_map")
        wait_until(lambda: STAGE + "/explain" in cls.session.run("rosservice", "list").stdout.split(),
                   "the map's services")

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        cls.temporary.cleanup()

    @classmethod
    def make_map(cls, folder):
        bag = folder / "home.bag"
        for command in (["simulate_apartment", "--output", bag, "--seed", "3", "--width", "160", "--height", "120",
                         "--duration", "12", "--rate", "8"],
                        ["process_bag", "--bag", bag, "--object-tasks", folder / "home.object_tasks.yaml", "--output",
                         cls.map]):
            done = cls.session.run(PROGRAMS / command[0], *command[1:])
            assert done.returncode == 0, done.stderr

    def read_objects(self):
        summary = json.loads((self.map / "summary.json").read_text())
        return {thing["id"]: thing for room in summary["rooms"] for thing in room["objects"]}

    def echo(self, topic):
        """A field of the topic's latched message."""
        done = self.session.run("rostopic", "echo", "-n", "1", topic)
        self.assertEqual(done.returncode, 0, topic + done.stderr)
        return yaml.safe_load(done.stdout.split("\n---")[0])

    def test_the_graph_is_that_of_the_folder(self):
        shown = self.echo(CHAIN + "/scene_graph/objects")
        self.assertGreater(len(shown), 3)
        self.assertEqual({thing["id"]: thing["task"] for thing in shown},
                         {number: thing["task"] for number, thing in self.read_objects().items()})

    def test_the_view_is_that_of_a_running_chain_but_for_the_camera_s_pictures(self):
        shown, live = (yaml.safe_load((SOURCE / "rviz" / name).read_text()) for name in ("saved_map.rviz",
                                                                                         "default.rviz"))
        manager = live["Visualization Manager"]
        manager["Displays"] = [one for one in manager["Displays"] if one["Class"] != "rviz/Image"]
        for config, panels in ((live, ["Camera", "Segments", "QMainWindow State"]), (shown, ["QMainWindow State"])):
            for name in panels:
                del config["Window Geometry"][name]
        self.assertEqual(shown, live)

    def test_the_way_of_the_camera_and_where_it_was_last_are_shown(self):
        markers = self.echo(CHAIN + "/camera_markers/markers")
        self.assertEqual({marker["ns"] for marker in markers}, {"", "trajectory", "camera_axes"})
        last = (self.map / "trajectory.txt").read_text().splitlines()[-1].split()[1:4]
        axes = [marker for marker in markers if marker["ns"] == "camera_axes"][0]
        self.assertAlmostEqual(axes["points"][0]["x"], float(last[0]))

    def test_reasons_and_tasks_are_told(self):
        number = min(self.read_objects())
        done = self.session.run("rosrun", "task_scene_graph", "ask", "--explain", "object", str(number), "--stage",
                                STAGE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("object %d" % number, done.stdout)
        tasks = self.session.run("rosrun", "task_scene_graph", "tasks", "--stage", STAGE)
        self.assertEqual(tasks.returncode, 0, tasks.stderr)
        self.assertIn(self.read_objects()[number]["task"], tasks.stdout)

    def test_a_path_leads_from_the_camera_to_an_object(self):
        refused = []
        for number in self.read_objects():  # some stand where no way leads
            path = self.session.run("rosrun", "task_scene_graph", "plan_path", str(number))
            if path.returncode == 0:
                self.assertIn("path of", path.stdout)
                return
            refused.append(path.stdout + path.stderr)
        self.fail(refused)

    def test_alpha_can_be_turned(self):
        def alpha():
            settings = {setting["name"]: setting["value"] for setting in self.echo(STAGE + "/settings/settings")}
            return settings["object_alpha"]

        before = alpha()
        for value in ("0.875", before):
            done = self.session.run("rosrun", "dynamic_reconfigure", "dynparam", "set", STAGE, "object_alpha", value)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(float(alpha()), float(value))

    def test_the_mesh_is_given_as_points_that_name_their_objects(self):
        done = self.session.run("rosservice", "call", STAGE + "/get_mesh", "{}")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("success: True", done.stdout[:100])
        vertices = re.search(rb"element vertex (\d+)", (self.map / "mesh.ply").read_bytes()).group(1).decode()
        self.assertRegex(done.stdout, r"\n  width: %s\n" % vertices)

    def test_what_it_cannot_do_is_said(self):
        done = self.session.run("rosrun", "task_scene_graph", "ask", "coffee", "mug", "--stage", STAGE)
        self.assertEqual(done.returncode, 2)
        self.assertIn("text encoder", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
