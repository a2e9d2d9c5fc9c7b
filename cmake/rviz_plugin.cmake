# tsg_rviz: the rviz display task_scene_graph/Mesh and the panel task_scene_graph/SceneGraph, where rviz and the Qt it was built with are found.
find_package(rviz QUIET)
find_package(Qt5 QUIET COMPONENTS Core Widgets)
if(rviz_FOUND AND Qt5_FOUND)
  file(GLOB TSG_RVIZ_SOURCES CONFIGURE_DEPENDS src/rviz/*.cpp src/rviz/*.h)
  add_library(tsg_rviz SHARED ${TSG_RVIZ_SOURCES})
  set_target_properties(tsg_rviz PROPERTIES AUTOMOC ON)
  target_compile_definitions(tsg_rviz PRIVATE QT_NO_KEYWORDS)
  target_include_directories(tsg_rviz SYSTEM PRIVATE ${rviz_INCLUDE_DIRS})
  # Debian 11's rviz names OpenGL's libraries without depending on their -dev packages; librviz finds them.
  list(FILTER rviz_LIBRARIES EXCLUDE REGEX "^-l(OpenGL|GLX|GLU)$")
  target_link_libraries(tsg_rviz
    PRIVATE tsg_ros ${rviz_LIBRARIES} Qt5::Core Qt5::Widgets tsg_warnings)
  list(APPEND TSG_INSTALL_LIBRARIES tsg_rviz)
else()
  message(STATUS "rviz or Qt 5 was not found: building without the rviz display "
    "task_scene_graph/Mesh (rviz then shows the mesh as markers, topic `mesh`) and without the panel")
endif()
