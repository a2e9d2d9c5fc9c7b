# TSG_SANITIZE=address|thread: everything of this package is built with GCC's sanitizers, and with the
# assertions of the libraries in use (no NDEBUG); scripts/test --sanitize builds so, in folders of its
# own.
set(TSG_SANITIZE "" CACHE STRING "Sanitizers: address (and undefined behaviour), thread, or empty")
if(TSG_SANITIZE STREQUAL "address")
  # Conversions of what does not fit (NaN to int) are undefined as well, but not in GCC's group. vptr
  # needs the type information of ROS's own libraries, which are linked without.
  set(TSG_SANITIZERS address,undefined,float-cast-overflow)
  # With this sanitizer Eigen pads what malloc gives, PCL's libraries, built without it, do not: what they allocate in a
  # template of both would be freed another way.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
elseif(TSG_SANITIZE STREQUAL "thread")
  set(TSG_SANITIZERS thread)
elseif(TSG_SANITIZE)
  message(FATAL_ERROR "TSG_SANITIZE is '${TSG_SANITIZE}', expected address or thread")
endif()
if(TSG_SANITIZE)
  set(CMAKE_BUILD_TYPE Sanitize)
  # GCC takes what it instruments itself for uninitialised.
  set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1 -fno-omit-frame-pointer -fsanitize=${TSG_SANITIZERS} -Wno-maybe-uninitialized")
  if(TSG_SANITIZE STREQUAL "address")
    string(APPEND CMAKE_CXX_FLAGS_SANITIZE " -fno-sanitize=vptr")
  endif()
endif()
