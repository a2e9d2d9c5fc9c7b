# One gtest program per module: test/unit/<module>/*.cpp; shared helpers: test/support/*.
find_package(rostest REQUIRED)
find_package(tf2_ros REQUIRED)
file(GLOB TSG_SUPPORT_SOURCES CONFIGURE_DEPENDS test/support/*.cpp)
add_library(tsg_test_support STATIC EXCLUDE_FROM_ALL ${TSG_SUPPORT_SOURCES})
# src: headers that only their own module and its tests include.
target_include_directories(tsg_test_support PUBLIC test/support src)
target_compile_definitions(tsg_test_support PUBLIC TSG_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
target_link_libraries(tsg_test_support
  PUBLIC tsg_core tsg_simulation nlohmann_json::nlohmann_json ZLIB::ZLIB ${OCTOMAP_LIBRARIES}
  PRIVATE tsg_warnings)

add_custom_target(unit_tests)
function(tsg_add_unit_test module library)
  file(GLOB sources CONFIGURE_DEPENDS test/unit/${module}/*.cpp)
  if(NOT sources)
    return()
  endif()
  catkin_add_gtest(test_${module} ${sources}
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(test_${module} tsg_test_support ${library} gtest_main tsg_warnings)
  add_dependencies(unit_tests test_${module})
endfunction()

foreach(module ${TSG_CORE_MODULES})
  tsg_add_unit_test(${module} tsg_core)
endforeach()
tsg_add_unit_test(simulation tsg_simulation)
tsg_add_unit_test(evaluation tsg_evaluation)
tsg_add_unit_test(rviz tsg_core)  # what of the plugin needs neither rviz nor Qt
tsg_add_unit_test(trajectory tsg_trajectory)
target_link_libraries(test_trajectory ${CERES_LIBRARIES})
tsg_add_unit_test(loops tsg_loops)
if(TARGET tsg_ros)
  tsg_add_unit_test(ros tsg_ros)
endif()

# tsg_add_python_test(<name> <file>): a unittest file, run with the environment of the devel space.
function(tsg_add_python_test name file)
  catkin_run_tests_target(python ${name} python-${name}.xml
    COMMAND "${CMAKE_COMMAND} -E env TSG_BUILD_DIR=${CMAKE_BINARY_DIR} TSG_SOURCE_DIR=${CMAKE_CURRENT_SOURCE_DIR} TSG_INSTALL_PREFIX=${CMAKE_INSTALL_PREFIX} ${CMAKE_CURRENT_SOURCE_DIR}/test/support/run_unittest ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/python-${name}.xml ${CMAKE_CURRENT_SOURCE_DIR}/${file}"
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()

# Python tests of programs and files: test/system/<name>_test.py
file(GLOB TSG_SYSTEM_TESTS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS
  test/system/*_test.py)
foreach(file ${TSG_SYSTEM_TESTS})
  get_filename_component(name ${file} NAME_WE)
  tsg_add_python_test(${name} ${file})
endforeach()

# Rostests: test/ros/<name>.test, with the C++ test node test/ros/<name>.cpp where there is one.
file(GLOB TSG_ROSTESTS CONFIGURE_DEPENDS test/ros/*.test)
if(NOT TARGET tsg_rviz)
  list(FILTER TSG_ROSTESTS EXCLUDE REGEX "/rviz_(plugin|panel)\\.test$")
endif()
foreach(launch ${TSG_ROSTESTS})
  get_filename_component(name ${launch} NAME_WE)
  if(EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/test/ros/${name}.cpp)
    add_rostest_gtest(rostest_${name} test/ros/${name}.test test/ros/${name}.cpp)
    target_include_directories(rostest_${name} SYSTEM PRIVATE ${tf2_ros_INCLUDE_DIRS})
    target_link_libraries(rostest_${name} tsg_test_support tsg_ros ${tf2_ros_LIBRARIES} tsg_warnings)
  else()
    add_rostest(test/ros/${name}.test)
  endif()
endforeach()

foreach(test rostest_background rostest_corrections rostest_loop_closures)
  target_include_directories(${test} PRIVATE src/nodelets)
  target_link_libraries(${test} tsg_nodelets)
endforeach()

if(TARGET tsg_rviz)
  find_package(Qt5 REQUIRED COMPONENTS Test)
  foreach(test rostest_rviz_plugin rostest_rviz_panel)
    target_include_directories(${test} SYSTEM PRIVATE ${rviz_INCLUDE_DIRS})
    target_compile_definitions(${test} PRIVATE QT_NO_KEYWORDS)
    target_link_libraries(${test} ${rviz_LIBRARIES} Qt5::Core Qt5::Widgets Qt5::Test)
    add_dependencies(${test} tsg_rviz)
  endforeach()
endif()

# Benchmarks: test/benchmark/<name>_benchmark.cpp, built with the tests where google-benchmark is there.
find_package(benchmark QUIET)
if(benchmark_FOUND)
  file(GLOB TSG_BENCHMARKS CONFIGURE_DEPENDS test/benchmark/*_benchmark.cpp)
  foreach(source ${TSG_BENCHMARKS})
    get_filename_component(name ${source} NAME_WE)
    add_executable(${name} EXCLUDE_FROM_ALL ${source})
    target_link_libraries(${name} PRIVATE tsg_test_support benchmark::benchmark
      Boost::program_options tsg_warnings)
    add_dependencies(tests ${name})
  endforeach()
  target_link_libraries(messages_benchmark PRIVATE tsg_ros)
  target_link_libraries(tuning_benchmark PRIVATE tsg_ros)
  target_link_libraries(trajectory_benchmark PRIVATE tsg_trajectory)
endif()

# Programs that the documents show: test/examples/<name>.cpp; ros_<name>.cpp need roscpp and our messages alone.
file(GLOB TSG_EXAMPLES CONFIGURE_DEPENDS test/examples/*.cpp)
foreach(source ${TSG_EXAMPLES})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} EXCLUDE_FROM_ALL ${source})
  if(name MATCHES "^ros_")
    target_include_directories(${name} PRIVATE include)
    target_include_directories(${name} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
    target_link_libraries(${name} PRIVATE ${catkin_LIBRARIES} tsg_warnings)
    add_dependencies(${name} ${${PROJECT_NAME}_EXPORTED_TARGETS})
  else()
    target_link_libraries(${name} PRIVATE tsg_core tsg_warnings)
  endif()
  add_dependencies(tests ${name})
endforeach()

# Fuzzed readers: test/fuzz/fuzz_<reader>.cpp. Each test is a smoke run; docs/testing.md tells of more.
add_library(tsg_fuzz STATIC EXCLUDE_FROM_ALL test/fuzz/fuzzer.cpp test/fuzz/mutator.cpp)
target_include_directories(tsg_fuzz PUBLIC test/fuzz)
target_link_libraries(tsg_fuzz PUBLIC tsg_test_support tsg_warnings)
add_custom_target(fuzz_programs)
file(GLOB TSG_FUZZED CONFIGURE_DEPENDS test/fuzz/fuzz_*.cpp)
foreach(source ${TSG_FUZZED})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE tsg_fuzz tsg_ros tsg_warnings)
  add_dependencies(tests ${name})
  add_dependencies(fuzz_programs ${name})
  set(result ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/${name}.xml)
  catkin_run_tests_target(fuzz ${name} ${name}.xml
    COMMAND "$<TARGET_FILE:${name}> --findings ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME} --result ${result}"
    DEPENDENCIES ${name} WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
endforeach()

# Programs that score the package's results against a truth: test/evaluation/<name>.cpp.
file(GLOB TSG_EVALUATIONS CONFIGURE_DEPENDS test/evaluation/*.cpp)
foreach(source ${TSG_EVALUATIONS})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} EXCLUDE_FROM_ALL ${source})
  target_link_libraries(${name} PRIVATE tsg_evaluation tsg_test_support Boost::program_options
    tsg_warnings)
  add_dependencies(tests ${name})
endforeach()
target_link_libraries(evaluate_loops PRIVATE tsg_loops)

# Whether the thread sanitizer still sees what our own callbacks do wrong.
if(TSG_SANITIZE STREQUAL "thread")
  add_executable(unguarded_callbacks EXCLUDE_FROM_ALL test/sanitizers/unguarded_callbacks.cpp)
  target_include_directories(unguarded_callbacks SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(unguarded_callbacks PRIVATE ${catkin_LIBRARIES} tsg_warnings)
  add_dependencies(unit_tests unguarded_callbacks)
  add_test(NAME sanitizer_sees_callbacks COMMAND unguarded_callbacks)
  set_tests_properties(sanitizer_sees_callbacks PROPERTIES
    PASS_REGULAR_EXPRESSION "WARNING: ThreadSanitizer: data race")
endif()
