# Offline programs: src/tools/<name>.cpp needs no ROS, src/tools/ros/<name>.cpp does.
file(GLOB TSG_TOOL_SOURCES CONFIGURE_DEPENDS src/tools/*.cpp)
foreach(source ${TSG_TOOL_SOURCES})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE tsg_core Boost::program_options
    nlohmann_json::nlohmann_json tsg_warnings)
  list(APPEND TSG_INSTALL_PROGRAMS ${name})
endforeach()

file(GLOB TSG_ROS_TOOL_SOURCES CONFIGURE_DEPENDS src/tools/ros/*.cpp)
foreach(source ${TSG_ROS_TOOL_SOURCES})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE tsg_ros Boost::program_options
    nlohmann_json::nlohmann_json tsg_warnings)
  list(APPEND TSG_INSTALL_PROGRAMS ${name})
endforeach()

target_link_libraries(close_loops PRIVATE tsg_loops)
target_link_libraries(concept_graphs PRIVATE tsg_evaluation)
target_link_libraries(correct_map PRIVATE tsg_trajectory)
target_link_libraries(merge_maps PRIVATE tsg_loops)
target_link_libraries(evaluate_scene_graph PRIVATE tsg_evaluation)
target_link_libraries(export_openlex3d PRIVATE tsg_evaluation)
target_link_libraries(render_apartments PRIVATE tsg_simulation)
target_link_libraries(degrade_segments PRIVATE tsg_simulation)
target_link_libraries(simulate_apartment PRIVATE tsg_simulation)
target_link_libraries(view_map PRIVATE tsg_nodelets)
