// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "task_scene_graph/ros/client.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "fetch_cpp");
  tsg::SceneGraphClient scene(
      ros::param::param<std::string>("~stage", "/task_scene_graph/scene_graph"));
  const auto plant = scene.find("potted plant");  // none if nothing in the map reaches alpha
  if (!plant) return 1;
  std::cout << "plant at x " << plant->pose.position.x << ", score " << plant->score << "\n";
  std::cout << scene.explain(tsg::msg::ExplainRequest::PRIMITIVE, plant->id) << "\n";
  const auto path = scene.goTo(*plant);  // plans, and sends the path's end to move_base
  std::cout << "drives " << path.length_m << " m\n";
  std::cout << scene.addTasks({"potted plant"}).object_tasks.size() << " tasks\n";
}
