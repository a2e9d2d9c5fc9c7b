# ONNX Runtime's headers. Its library is opened at run time (dlopen), so nothing links to it, and
# without the headers everything else still builds: the segmenter then says so when it is started.
# Looked for in $ONNXRUNTIME_ROOT, build/onnxruntime, scripts/install_engine's folder, the system.
if(DEFINED ENV{XDG_CACHE_HOME})
  set(TSG_CACHE_FOLDER $ENV{XDG_CACHE_HOME}/task_scene_graph)
else()
  set(TSG_CACHE_FOLDER $ENV{HOME}/.cache/task_scene_graph)
endif()
find_path(ONNXRUNTIME_INCLUDE_DIR onnxruntime_cxx_api.h
  HINTS $ENV{ONNXRUNTIME_ROOT} ${ONNXRUNTIME_ROOT} ${CMAKE_BINARY_DIR}/onnxruntime
    ${TSG_CACHE_FOLDER}/onnxruntime
  PATH_SUFFIXES include include/onnxruntime include/onnxruntime/core/session onnxruntime
    onnxruntime/core/session)

add_library(tsg_onnxruntime INTERFACE)
if(ONNXRUNTIME_INCLUDE_DIR)
  # The folder above include/ is the first place where the library is looked for.
  string(REGEX REPLACE "/include(/.*)?$" "" ONNXRUNTIME_HOME "${ONNXRUNTIME_INCLUDE_DIR}")
  message(STATUS "ONNX Runtime headers: ${ONNXRUNTIME_INCLUDE_DIR}")
  target_include_directories(tsg_onnxruntime SYSTEM INTERFACE ${ONNXRUNTIME_INCLUDE_DIR})
  target_compile_definitions(tsg_onnxruntime INTERFACE TSG_WITH_ONNXRUNTIME=1
    TSG_ONNXRUNTIME_HOME="${ONNXRUNTIME_HOME}")
else()
  message(WARNING "No ONNX Runtime headers: building without the segmenter's networks. "
    "scripts/install_engine gets them, or set ONNXRUNTIME_ROOT to an unpacked release.")
endif()
