# SPDX-License-Identifier: BSD-3-Clause
import rospy
from task_scene_graph_client import SceneGraphClient

rospy.init_node("fetch")
scene = SceneGraphClient(rospy.get_param("~stage", "/task_scene_graph/scene_graph"))
plant = scene.find("potted plant")  # None if nothing in the map reaches alpha
print("plant at x %.1f, score %.2f" % (plant.pose.position.x, plant.score))
path = scene.go_to(plant)  # plans, and sends the path's end to move_base; path_to() only plans
print("drives %.1f m" % path.length_m)
print([task.name for task in scene.add_tasks(["potted plant"]).object_tasks])
