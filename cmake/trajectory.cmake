# tsg_trajectory: keyframes, pose graphs, loop closures, and how a map follows a corrected trajectory.
find_package(Ceres REQUIRED)
file(GLOB TSG_TRAJECTORY_SOURCES CONFIGURE_DEPENDS src/trajectory/*.cpp)
add_library(tsg_trajectory SHARED ${TSG_TRAJECTORY_SOURCES})
target_include_directories(tsg_trajectory SYSTEM PRIVATE ${CERES_INCLUDE_DIRS})
target_link_libraries(tsg_trajectory PUBLIC tsg_core PRIVATE ${CERES_LIBRARIES} tsg_warnings)
list(APPEND TSG_INSTALL_LIBRARIES tsg_trajectory)
