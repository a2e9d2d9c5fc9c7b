# SPDX-License-Identifier: BSD-3-Clause
"""Tasks and questions in words, with the demo's text encoder, as a user and a robot program ask them."""
import os
import pathlib
import re
import sys
import tempfile
import unittest

from ros_session import SOURCE, Session, wait_until

STAGE = "/scene_graph"
MODELS = SOURCE / "models" / "demo" / "models.yaml"
THINGS = ["mug", "book", "chair", "potted plant"]  # of the demo models' vocabulary; in this order along x
EXAMPLES = SOURCE / "test" / "examples"
CLIENT = """
import rospy
from task_scene_graph_client import SceneGraphClient, SceneGraphError
rospy.init_node("fetch", disable_signals=True)
scene = SceneGraphClient("/scene_graph")
plant = scene.find("potted plant")
print("plant at %.1f, object %d" % (plant.pose.position.x, plant.object))
print("tasks", [task.name for task in scene.add_tasks(["potted plant"]).object_tasks])
print("object", scene.find("potted plant").task)
try:
    scene.remove_tasks(["pen"])
except SceneGraphError as error:
    print("refused:", error)
"""


class RobotInterface(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        folder = pathlib.Path(os.path.realpath(cls.temporary.name))
        cls.session = Session(folder)
        cls.session.env.setdefault("XDG_CACHE_HOME", str(pathlib.Path.home() / ".cache"))  # the vocabulary
        tasks = folder / "tasks.yaml"
        tasks.write_text("- mug\n- book\n")
        cls.node = cls.session.start(["rosrun", "task_scene_graph", "scene_graph_node", "_object_tasks:=%s" % tasks,
                                      "_models:=%s" % MODELS, "_object_alpha:=0.5"], "node")
        cls.publish_map(folder)

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        cls.temporary.cleanup()

    @classmethod
    def publish_map(cls, folder):
        """One primitive for each thing, its embedding that of its name."""
        words, embedded = folder / "words.yaml", folder / "embedded.yaml"
        words.write_text("".join("- %s\n" % thing for thing in THINGS))
        done = cls.session.run("rosrun", "task_scene_graph", "encode_tasks", "--models", MODELS, "--tasks", words,
                               "--output", embedded)
        assert done.returncode == 0, done.stderr
        script = folder / "publish.py"
        script.write_text(PUBLISHER)
        cls.publisher = cls.session.start([sys.executable, script, embedded], "publisher")
        wait_until(lambda: "object tasks" in cls.rosrun("tasks").stdout and
                   "mug: 1 object" in cls.rosrun("tasks").stdout, "the map in the graph")

    @classmethod
    def rosrun(cls, *words):
        return cls.session.run("rosrun", "task_scene_graph", *words, *(["--stage", STAGE] if "--stage" not in words
                                                                       else []))

    def setUp(self):
        self.assertEqual(self.rosrun("tasks", "set", "mug", "book").returncode, 0)

    def test_ask_finds_a_thing_that_serves_no_task(self):
        asked = self.rosrun("ask", "chair")
        self.assertEqual(asked.returncode, 0, asked.stdout + asked.stderr)
        self.assertRegex(asked.stdout.splitlines()[0], r"^'chair': .*primitive 3 at \(4\.50, 0\.50, 0\.50\) m")

    def test_ask_says_what_is_not_there(self):
        asked = self.rosrun("ask", "bathtub")
        self.assertEqual(asked.returncode, 1, asked.stdout)
        self.assertIn("nothing found: the best score is", asked.stdout)

    def test_tasks_change_while_the_graph_lives(self):
        added = self.rosrun("tasks", "add", "potted plant")
        self.assertEqual(added.returncode, 0, added.stderr)
        self.assertIn("potted plant: 1 object\n", added.stdout)
        renamed = self.rosrun("tasks", "rename", "potted plant", "water the plant")
        self.assertIn("water the plant: 1 object\n", renamed.stdout)
        removed = self.rosrun("tasks", "remove", "water the plant")
        self.assertNotIn("plant", removed.stdout)

    def test_reload_brings_back_the_tasks_of_the_file(self):
        self.assertIn("chair", self.rosrun("tasks", "set", "chair").stdout)
        reloaded = self.rosrun("tasks", "reload")
        self.assertEqual(reloaded.returncode, 0, reloaded.stderr)
        self.assertRegex(reloaded.stdout, r"mug: 1 object\n +\d+  book: 1 object\n")
        self.assertNotIn("chair", reloaded.stdout)

    def test_what_cannot_be_done_is_said(self):
        refused = self.rosrun("tasks", "add", "mug")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("task 'mug' is in force already", refused.stderr)
        unknown = self.rosrun("ask", "--explain", "object", "77")
        self.assertEqual(unknown.returncode, 2)
        self.assertIn("no object 77 is in the map", unknown.stderr)
        self.assertEqual(self.rosrun("ask").returncode, 2)
        self.assertIn("expected one of", self.rosrun("ask", "--explain", "thing", "1").stderr)
        silent = self.rosrun("ask", "mug", "--stage", "/nobody", "--timeout", "1")
        self.assertEqual(silent.returncode, 2)
        self.assertIn("/nobody/ask", silent.stderr)

    def test_explain_speaks_of_tasks(self):
        told = self.rosrun("ask", "--explain", "primitive", "1")
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("primitive 1: cosines 'mug' 1", told.stdout)

    def test_examples_find_go_and_change_tasks(self):
        done = self.session.run(sys.executable, EXAMPLES / "fetch_example.py", "_stage:=" + STAGE)
        self.assertEqual(done.stdout.splitlines(), ["plant at x 6.5, score 1.00", "drives 6.5 m",
                                                    "['mug', 'book', 'potted plant']"], done.stderr)
        self.assertEqual(self.rosrun("tasks", "set", "mug", "book").returncode, 0)
        done = self.session.run("rosrun", "task_scene_graph", "ros_fetch_example", "_stage:=" + STAGE)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        self.assertEqual((lines[0], lines[-2:]), ("plant at x 6.5, score 1", ["drives 6.5 m", "3 tasks"]), done.stderr)
        self.assertIn("primitive 4: cosines", lines[1])
        goals = wait_until(lambda: re.findall(r"goal (\S*) (\S+)", self.publisher.output())[1:2], "both goals")
        self.assertEqual(goals, [("world", "6.5")])

    def test_a_follower_has_the_graph_that_is_published_whole(self):
        script = pathlib.Path(self.temporary.name) / "follow.py"
        script.write_text(FOLLOWER)
        done = self.session.run(sys.executable, script)
        self.assertEqual(done.stdout.splitlines(), ["['mug', 'book'] True", "['mug', 'book', 'chair'] True",
                                                    "['book', 'chair'] True"], done.stderr)

    def test_path_to_takes_words_points_and_ids(self):
        script = pathlib.Path(self.temporary.name) / "paths.py"
        script.write_text(PATHS)
        done = self.session.run(sys.executable, script)
        self.assertEqual(done.stdout.splitlines()[:5], [
            "box 4.5", "point 1.5", "object 7", "region kitchen", "place 3 from 1.0"], done.stderr)
        self.assertIn("refused: no path to 'bathtub': 'bathtub': nothing found", done.stdout)
        self.assertIn("refused: no object has the id 99", done.stdout)
        self.assertIn("expected one of goal, object, region, place, got 2", done.stdout)

    def test_grasp_pixel_without_a_camera_is_refused(self):
        refused = self.rosrun("ask", "--grasp", "mug")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("what the camera sees now is known to the tracker", refused.stderr)

    def test_robot_program(self):
        script = pathlib.Path(self.temporary.name) / "client.py"
        script.write_text(CLIENT)
        done = self.session.run(sys.executable, script)
        self.assertEqual(done.stdout.splitlines()[:3], [
            "plant at 6.5, object 0", "tasks ['mug', 'book', 'potted plant']", "object potted plant"], done.stderr)
        self.assertIn("refused: tasks not changed", done.stdout)
        self.assertIn("no task 'pen'", done.stdout)


class SharedTopics(unittest.TestCase):
    def test_a_topic_that_two_robots_send_on_is_named(self):
        with tempfile.TemporaryDirectory() as temporary:
            session = Session(os.path.realpath(temporary))
            self.addCleanup(session.close)
            tracker = session.start(["rosrun", "task_scene_graph", "tracker_node", "_input/patience_s:=0.5"], "tracker")
            for number in range(2):
                session.start(["rostopic", "pub", "-r", "1", "/segmentation", "task_scene_graph/Segmentation", "{}"],
                              "segmenter_%d" % number)
            wait_until(lambda: "2 publishers send on /segmentation, expected one" in tracker.output(),
                       "a word on the second publisher")


PATHS = """
import rospy
from task_scene_graph_client import SceneGraphClient, SceneGraphError
rospy.init_node("paths", disable_signals=True)
scene = SceneGraphClient("/scene_graph")
for goal in [{"goal": "chair"}, {"goal": (1.5, 0, 0)}, {"object": 7}, {"region": "kitchen"},
             {"place": 3, "start": (1, 2, 0)}, {"goal": "bathtub"}, {"object": 99}]:
    try:
        print(scene.path_to(**goal).message)
    except SceneGraphError as error:
        print("refused:", error)
try:
    scene.path_to("chair", object=7)
except ValueError as error:
    print(error)
"""

FOLLOWER = """
import time
import rospy
from task_scene_graph.msg import SceneGraph
from task_scene_graph_client import SceneGraphClient, SceneGraphFollower
rospy.init_node("follow", disable_signals=True)
scene = SceneGraphClient("/scene_graph")
follower = SceneGraphFollower("/scene_graph_changes")
def is_same(graph, whole):  # but for the number that ROS itself gives each topic's messages
    if graph is not None:
        graph.header.seq = whole.header.seq = 0
    return graph == whole
for change in (lambda: None, lambda: scene.add_tasks(["chair"]), lambda: scene.remove_tasks(["mug"])):
    change()
    whole = rospy.wait_for_message("/scene_graph", SceneGraph, 10.0)
    deadline = time.monotonic() + 10.0
    while not is_same(follower.graph, whole) and time.monotonic() < deadline:
        time.sleep(0.02)
    print(whole.object_tasks, is_same(follower.graph, whole))
"""

PUBLISHER = """
import sys
import rospy, yaml
from geometry_msgs.msg import PoseStamped
from task_scene_graph.msg import ObjectPrimitive, ObjectPrimitives
from task_scene_graph.srv import PlanPath, PlanPathRequest, PlanPathResponse
rospy.init_node("publisher")


def plan(request):  # a straight way along x, and what was asked for
    if request.id == 99:
        return PlanPathResponse(message="no object has the id 99")
    x = request.box.pose.position.x if request.goal_kind == PlanPathRequest.BOX else request.point.x
    kind = ["point", "place", "object", "region", "box"][request.goal_kind]
    what = request.name or (request.id if kind in ("place", "object", "region") else "%.1f" % x)
    said = "%s %s" % (kind, what)
    if request.has_start:
        said += " from %.1f" % request.start.x
    response = PlanPathResponse(success=True, length_m=x, message=said)
    response.path.header.frame_id = "world"
    response.path.poses = [PoseStamped(), PoseStamped()]
    response.path.poses[1].pose.position.x = x
    return response


rospy.Service("plan_path", PlanPath, plan)
rospy.Subscriber("/move_base_simple/goal", PoseStamped,
                 lambda goal: print("goal", goal.header.frame_id, goal.pose.position.x, flush=True))
message = ObjectPrimitives(sequence=1)
message.header.frame_id = "world"
for i, task in enumerate(yaml.safe_load(open(sys.argv[1]))["tasks"]):
    primitive = ObjectPrimitive(id=i + 1, track_id=i + 1, embedding=task["embedding"])
    for box in (primitive.box, primitive.oriented_box):
        box.pose.position.x, box.pose.position.y, box.pose.position.z = 2 * i + 0.5, 0.5, 0.5
        box.pose.orientation.w = 1
        box.size.x = box.size.y = box.size.z = 1
    primitive.first_seen = primitive.last_seen = rospy.Time(10)
    message.primitives.append(primitive)
publisher = rospy.Publisher("object_primitives", ObjectPrimitives, queue_size=1, latch=True)
publisher.publish(message)
rospy.spin()
"""

if __name__ == "__main__":
    unittest.main()
