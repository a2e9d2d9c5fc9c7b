# SPDX-License-Identifier: BSD-3-Clause
"""The scene graph for robot programs, in a few lines:

    import rospy
    from task_scene_graph_client import SceneGraphClient

    rospy.init_node("fetch")
    scene = SceneGraphClient()
    mug = scene.find("coffee mug")          # None if there is none
    if mug is not None:
        print(mug.pose.position, mug.score, mug.region_task)
        path = scene.path_to(mug).path      # nav_msgs/Path; go_to(mug) also sends its end to move_base
    scene.add_tasks(["water the plants"])   # clustered for at once, nothing is mapped anew

Every call raises SceneGraphError, which says what is wrong, where the graph refuses; and
rospy.ROSException where nobody serves it within `timeout_s`.
"""
import time

import rospy
from geometry_msgs.msg import Point, PoseStamped
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from task_scene_graph.msg import Answer, Task, TasksInForce
from task_scene_graph.srv import (Ask, AskRequest, ChangeTasks, ChangeTasksRequest, Explain, ExplainRequest,
                                  GraspPixel, GraspPixelRequest, PlanPath, PlanPathRequest)

from .changes import SceneGraphFollower, SceneGraphReader, apply_changes  # noqa: F401

GOAL_GRACE_S = 2.0


class SceneGraphError(Exception):
    """The scene graph could not do what was asked; the map is as it was."""


def make_task(name, embedding=()):
    """A task from words alone, or with its embedding (a sequence of floats)."""
    return Task(name=name, embedding=list(embedding))


def make_image(rgb):
    """A picture to ask with, out of an array of H x W x 3 bytes (numpy), red first."""
    height, width, channels = rgb.shape
    if channels != 3 or rgb.dtype.itemsize != 1:
        raise ValueError("picture is %s of %s, expected H x W x 3 bytes" % (rgb.shape, rgb.dtype))
    return Image(height=height, width=width, encoding="rgb8", step=3 * width, data=rgb.tobytes())


def make_point(point):
    """A Point, from one or from three numbers, metres."""
    return point if isinstance(point, Point) else Point(*map(float, point))


class SceneGraphClient:
    """Calls the services of the scene graph stage.

    stage: its name, as in `rosnode list` or launch files.
    timeout_s: how long a service is waited for that is not there yet.
    """

    def __init__(self, stage="/task_scene_graph/scene_graph", timeout_s=10.0):
        self.stage = stage
        self.chain = stage.rstrip("/").rpartition("/")[0]  # the namespace of all stages
        self.timeout_s = timeout_s
        self._goals = {}  # topic -> publisher

    def ask(self, words="", embedding=(), max_answers=5, with_thumbnails=False, image=None):
        """All answers, each kind by score: AskResponse. Words, the embedding of anything, or a picture
        that shows little else (sensor_msgs/Image; make_image() makes one of an array)."""
        return self._call("ask", Ask, AskRequest(
            words=words, embedding=list(embedding), image=image or Image(), max_answers=max_answers,
            with_thumbnails=with_thumbnails))

    def find(self, words="", embedding=(), with_thumbnail=False, image=None):
        """The object or, where that fits better, the primitive meant: an Answer, in the frame of the
        map; None if nothing there reaches alpha."""
        return _choose_thing(self.ask(words, embedding, 1, with_thumbnail, image))

    def find_region(self, words="", embedding=(), image=None):
        """The region that fits best, an Answer; None without regions."""
        regions = self.ask(words, embedding, 1, image=image).regions
        return regions[0] if regions else None

    def grasp_pixel(self, words="", embedding=(), image=None, max_age_s=0.0):
        """Where to reach for what the camera sees now: GraspPixelResponse with the pixel (u, v) and its
        point in the map; None if no segment reaches alpha."""
        grasp = self._call("grasp_pixel", GraspPixel, GraspPixelRequest(
            words=words, embedding=list(embedding), image=image or Image(), max_age_s=max_age_s))
        return grasp if grasp.is_found else None

    def path_to(self, goal="", object=0, region=0, place=0, start=None, robot_radius_m=0.0):
        """A path for the robot: PlanPathResponse, whose `path` is a nav_msgs/Path on the floor. The goal is
        one of

        goal: words (of the things and regions that reach alpha, the one of the highest score), an
            Answer, or a point at or above the floor (a Point or three numbers, metres)
        object, place: an id; region: an id, or a place task

        start: a point at or above the floor that the robot stands on; None: where the camera is.
        robot_radius_m: 0: the planner's own.
        """
        request = self._make_path_request(goal, object, region, place)
        request.robot_radius_m = robot_radius_m
        if start is not None:
            request.has_start, request.start = True, make_point(start)
        return self._call(self.chain + "/plan_path", PlanPath, request)

    def go_to(self, goal="", topic="/move_base_simple/goal", **options):
        """Plans as path_to() and sends the path's last pose to whoever drives the robot: move_base takes
        goals on that topic. Returns the path."""
        response = self.path_to(goal, **options)
        if not response.path.poses:
            raise SceneGraphError("go_to: the robot is there already")
        self._send_goal(response.path.poses[-1].pose, response.path.header.frame_id, topic)
        return response

    def tasks(self):
        """The tasks in force: TasksInForce."""
        return rospy.wait_for_message(self.stage + "/tasks", TasksInForce, self.timeout_s)

    def set_tasks(self, tasks, for_places=False):
        """Replaces all tasks by these: names, or Tasks with embeddings. Returns those in force."""
        return self._change(ChangeTasksRequest.SET, tasks, for_places)

    def add_tasks(self, tasks, for_places=False):
        return self._change(ChangeTasksRequest.ADD, tasks, for_places)

    def remove_tasks(self, names, for_places=False):
        return self._change(ChangeTasksRequest.REMOVE, names, for_places)

    def rename_task(self, name, new_name, for_places=False):
        """What the task looks for stays."""
        return self._change(ChangeTasksRequest.RENAME, [name], for_places, [new_name])

    def reload_tasks(self):
        """Those of the task files again. Returns those in force."""
        self._call("reload_tasks", Trigger)
        return self.tasks()

    def explain(self, what, first, second=0):
        """Why things are clustered as they are, in words; what: ExplainRequest.OBJECT, ..."""
        return self._call("explain", Explain, ExplainRequest(what=what, a=first, b=second)).message

    def save_map(self):
        """Writes the map of now; returns what the stages say, first the folder."""
        return self._call("save_map", Trigger).message

    def _make_path_request(self, goal, object, region, place):
        given = [bool(goal) if isinstance(goal, str) else goal is not None, bool(object), bool(region), bool(place)]
        if sum(given) != 1:
            raise ValueError("path_to: expected one of goal, object, region, place, got %d" % sum(given))
        if object:
            return PlanPathRequest(goal_kind=PlanPathRequest.OBJECT, id=object)
        if place:
            return PlanPathRequest(goal_kind=PlanPathRequest.PLACE, id=place)
        if region:
            name, number = (region, 0) if isinstance(region, str) else ("", region)
            return PlanPathRequest(goal_kind=PlanPathRequest.REGION, name=name, id=number)
        if isinstance(goal, str):
            goal = self._find_goal(goal)
        if isinstance(goal, Answer):
            return _make_answer_request(goal)
        return PlanPathRequest(goal_kind=PlanPathRequest.POINT, point=make_point(goal))

    def _find_goal(self, words):
        answers = self.ask(words, max_answers=1)
        regions = [region for region in answers.regions if region.score >= answers.place_alpha]
        best = max([thing for thing in [_choose_thing(answers)] if thing] + regions,
                   key=lambda answer: answer.score, default=None)
        if best is None:
            raise SceneGraphError("no path to '%s': %s" % (words, answers.message))
        return best

    def _send_goal(self, pose, frame, topic):
        if not self._goals:
            rospy.on_shutdown(self._let_goal_arrive)
        if topic not in self._goals:
            self._goals[topic] = rospy.Publisher(topic, PoseStamped, queue_size=1)
        deadline = time.monotonic() + self.timeout_s
        while self._goals[topic].get_num_connections() == 0:
            if time.monotonic() > deadline:
                raise SceneGraphError("nobody takes goals on %s: is move_base running?" % topic)
            time.sleep(0.02)
        goal = PoseStamped(pose=pose)
        goal.header.frame_id = frame
        goal.header.stamp = rospy.Time.now()
        self._goals[topic].publish(goal)
        self._goal_sent = time.monotonic()

    def _let_goal_arrive(self):
        """A program that ends takes with it what its listeners have not read: ROS confirms no message."""
        time.sleep(max(0.0, self._goal_sent + GOAL_GRACE_S - time.monotonic()))

    def _change(self, action, tasks, for_places, new_names=()):
        tasks = [make_task(task) if isinstance(task, str) else task for task in tasks]
        layer = ChangeTasksRequest.PLACES if for_places else ChangeTasksRequest.OBJECTS
        return self._call("change_tasks", ChangeTasks, ChangeTasksRequest(
            action=action, layer=layer, tasks=tasks, new_names=list(new_names))).in_force

    def _call(self, name, service_type, *request):
        service = name if "/" in name else self.stage + "/" + name
        rospy.wait_for_service(service, self.timeout_s)
        response = rospy.ServiceProxy(service, service_type)(*request)
        if not response.success:
            raise SceneGraphError(response.message)
        return response


def _choose_thing(answers):
    things = [thing for thing in answers.objects + answers.primitives if thing.score >= answers.alpha]
    return max(things, key=lambda thing: thing.score, default=None)


def _make_answer_request(answer):
    """Before a thing's box; to the position of what has none."""
    if max(answer.size.x, answer.size.y, answer.size.z) <= 0.0:
        return PlanPathRequest(goal_kind=PlanPathRequest.POINT, point=answer.pose.position)
    request = PlanPathRequest(goal_kind=PlanPathRequest.BOX)
    request.box.pose, request.box.size = answer.pose, answer.size
    return request
