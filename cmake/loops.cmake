# tsg_loops: places seen again by a robot that has only odometry.
find_package(PCL REQUIRED COMPONENTS common features registration search)
file(GLOB TSG_LOOPS_SOURCES CONFIGURE_DEPENDS src/loops/*.cpp)
add_library(tsg_loops SHARED ${TSG_LOOPS_SOURCES})
target_include_directories(tsg_loops SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
target_link_libraries(tsg_loops PUBLIC tsg_core tsg_trajectory PRIVATE ${PCL_LIBRARIES} tsg_warnings)
# GCC 12 sees faults in Eigen where PCL's templates instantiate it with -O3 (array-bounds, use-after-free).
set_source_files_properties(src/loops/registration.cpp PROPERTIES COMPILE_OPTIONS -Wno-error)
list(APPEND TSG_INSTALL_LIBRARIES tsg_loops)
