# tsg_evaluation: metrics, readers of ground truth, and the baselines that this package is compared with. The
# chain itself does not link it.
file(GLOB TSG_EVALUATION_SOURCES CONFIGURE_DEPENDS src/evaluation/*.cpp)
add_library(tsg_evaluation SHARED ${TSG_EVALUATION_SOURCES})
target_link_libraries(tsg_evaluation PUBLIC tsg_core PRIVATE nlohmann_json::nlohmann_json tsg_warnings)
list(APPEND TSG_INSTALL_LIBRARIES tsg_evaluation)
