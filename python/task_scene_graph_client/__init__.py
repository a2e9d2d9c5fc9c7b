# SPDX-License-Identifier: BSD-3-Clause
"""The scene graph for robot programs, in a few lines:

    import rospy
    from task_scene_graph_client import SceneGraphClient

    rospy.init_node("fetch")
    scene = SceneGraphClient()
    mug = scene.find("coffee mug")          # None if there is none
    if mug is not None:
        print(mug.pose.position, mug.score, mug.region_task)
    scene.add_tasks(["water the plants"])   # clustered for at once, nothing is mapped anew

Every call raises SceneGraphError, which says what is wrong, where the graph refuses; and
rospy.ROSException where nobody serves it within `timeout_s`.
"""
import rospy
from std_srvs.srv import Trigger
from task_scene_graph.msg import Task, TasksInForce
from task_scene_graph.srv import (Ask, AskRequest, ChangeTasks, ChangeTasksRequest, Explain,
                                  ExplainRequest)


class SceneGraphError(Exception):
    """The scene graph could not do what was asked; the map is as it was."""


def make_task(name, embedding=()):
    """A task from words alone, or with its embedding (a sequence of floats)."""
    return Task(name=name, embedding=list(embedding))


class SceneGraphClient:
    """Calls the services of the scene graph stage.

    stage: its name, as in `rosnode list` or launch files.
    timeout_s: how long a service is waited for that is not there yet.
    """

    def __init__(self, stage="/task_scene_graph/scene_graph", timeout_s=10.0):
        self.stage = stage
        self.timeout_s = timeout_s

    def ask(self, words="", embedding=(), max_answers=5, with_thumbnails=False):
        """All answers, each kind by score: AskResponse. Words, or the embedding of anything."""
        return self._call("ask", Ask, AskRequest(
            words=words, embedding=list(embedding), max_answers=max_answers,
            with_thumbnails=with_thumbnails))

    def find(self, words="", embedding=(), with_thumbnail=False):
        """The object or, where that fits better, the primitive meant: an Answer, in the frame of the
        map; None if nothing there reaches alpha."""
        answers = self.ask(words, embedding, 1, with_thumbnail)
        things = [thing for thing in answers.objects + answers.primitives
                  if thing.score >= answers.alpha]
        return max(things, key=lambda thing: thing.score, default=None)

    def find_region(self, words="", embedding=()):
        """The region that fits best, an Answer; None without regions."""
        regions = self.ask(words, embedding, 1).regions
        return regions[0] if regions else None

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

    def _change(self, action, tasks, for_places, new_names=()):
        tasks = [make_task(task) if isinstance(task, str) else task for task in tasks]
        layer = ChangeTasksRequest.PLACES if for_places else ChangeTasksRequest.OBJECTS
        return self._call("change_tasks", ChangeTasks, ChangeTasksRequest(
            action=action, layer=layer, tasks=tasks, new_names=list(new_names))).in_force

    def _call(self, name, service_type, *request):
        service = self.stage + "/" + name
        rospy.wait_for_service(service, self.timeout_s)
        response = rospy.ServiceProxy(service, service_type)(*request)
        if not response.success:
            raise SceneGraphError(response.message)
        return response
