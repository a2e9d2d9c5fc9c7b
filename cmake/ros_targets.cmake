# tsg_ros: conversions, parameters, markers. tsg_nodelets: the plugins.
file(GLOB TSG_ROS_SOURCES CONFIGURE_DEPENDS src/ros/*.cpp)
if(TSG_ROS_SOURCES)
  add_library(tsg_ros SHARED ${TSG_ROS_SOURCES})
  add_dependencies(tsg_ros ${${PROJECT_NAME}_EXPORTED_TARGETS})
  target_include_directories(tsg_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
  target_link_libraries(tsg_ros PUBLIC tsg_core ${catkin_LIBRARIES} PRIVATE tsg_warnings)
  list(APPEND TSG_INSTALL_LIBRARIES tsg_ros)
endif()

file(GLOB TSG_NODELET_SOURCES CONFIGURE_DEPENDS src/nodelets/*_nodelet.cpp
  src/nodelets/*_report.cpp)
if(TSG_NODELET_SOURCES)
  add_library(tsg_nodelets SHARED ${TSG_NODELET_SOURCES})
  target_link_libraries(tsg_nodelets PUBLIC tsg_ros PRIVATE tsg_warnings)
  list(APPEND TSG_INSTALL_LIBRARIES tsg_nodelets)
endif()

# Each nodelet is also a node of its own: src/nodelets/<name>_node.cpp.
file(GLOB TSG_NODE_SOURCES CONFIGURE_DEPENDS src/nodelets/*_node.cpp)
set(TSG_INSTALL_PROGRAMS "")
foreach(source ${TSG_NODE_SOURCES})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE tsg_ros tsg_warnings)
  list(APPEND TSG_INSTALL_PROGRAMS ${name})
endforeach()
