# tsg_simulation: generated apartments, walks through them and what a camera sees there, for the demo, for
# training its models and for tests. The chain itself does not link it.
file(GLOB TSG_SIMULATION_SOURCES CONFIGURE_DEPENDS src/simulation/*.cpp)
add_library(tsg_simulation SHARED ${TSG_SIMULATION_SOURCES})
target_link_libraries(tsg_simulation PUBLIC tsg_core PRIVATE tsg_warnings)
list(APPEND TSG_INSTALL_LIBRARIES tsg_simulation)
