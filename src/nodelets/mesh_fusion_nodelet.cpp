// SPDX-License-Identifier: BSD-3-Clause
#include <task_scene_graph/GetMesh.h>
#include <task_scene_graph/LoadMap.h>
#include <task_scene_graph/SaveMapPart.h>

#include <filesystem>
#include <map>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <utility>

#include "background_stage.h"
#include "correction_stage.h"
#include "loop_stage.h"
#include "mesh_fusion_config.h"
#include "mesh_points.h"
#include "navigation_stage.h"
#include "object_stage.h"
#include "stage_nodelet.h"
#include "task_scene_graph/map/files.h"
#include "task_scene_graph/ros/epoch.h"
#include "task_scene_graph/ros/flush.h"
#include "task_scene_graph/ros/frame_matcher.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/rgbd_input.h"

namespace tsg::nodelets {
namespace {

/// @throws std::runtime_error unless there is an object for each primitive.
std::map<PrimitiveId, std::int32_t> pairObjects(const std::vector<std::uint64_t>& primitives,
                                                const std::vector<std::int32_t>& objects) {
  if (primitives.size() != objects.size()) {
    throw std::runtime_error(
        "primitives and objects differ in number: " + std::to_string(primitives.size()) + " and " +
        std::to_string(objects.size()));
  }
  std::map<PrimitiveId, std::int32_t> object_of_primitive;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    object_of_primitive[PrimitiveId{primitives[i]}] = objects[i];
  }
  return object_of_primitive;
}

}  // namespace

/// Every frame -> the background stage; segmented frames and tracks -> the object stage. Each has a
/// thread, and objects are reconstructed on a pool of lower priority: none waits for another.
class MeshFusionNodelet : public StageNodelet {
 public:
  ~MeshFusionNodelet() override;

 private:
  using Match = ros_interface::FrameMatcher::Match;

  void start() override;
  void startStages();
  void startCorrections();
  void subscribe();
  void check() override;
  msg::FlushResponse flush(const msg::FlushRequest& request,
                           const ros_interface::Patience& patience) override;
  void finishLoops(ros_interface::Patience patience);
  std::string reset() override;

  void onFrame(const RgbdFramePtr& frame);
  void onSegmentation(const msg::SegmentationConstPtr& message);
  void onTracks(const msg::TracksConstPtr& message);
  void onJumpBack();
  void handMatch(const std::optional<Match>& match);
  bool saveMesh(msg::SaveMeshRequest& request, msg::SaveMeshResponse& response);
  bool savePart(msg::SaveMapPartRequest& request, msg::SaveMapPartResponse& response);
  bool serveLoad(msg::LoadMapRequest& request, msg::LoadMapResponse& response);
  /// All but the primitives, which are returned. @throws as map::loadMap(); nothing has changed
  /// then.
  std::vector<ObjectPrimitivePtr> loadMap(const std::filesystem::path& folder);
  bool serveMesh(msg::GetMesh::Request& request, msg::GetMesh::Response& response);
  /// @throws std::runtime_error if there is nothing to be saved.
  Stamp requireFrames();
  /// Into a map folder all at once, else each file for itself.
  std::vector<WrittenFile> writeFiles(const std::filesystem::path& folder);
  /// What depth images made, and, where it is asked for, what to go on from.
  std::vector<WrittenFile> writePart(const std::filesystem::path& folder,
                                     map::BackgroundFiles what);

  MeshFusionNodeletConfig config_;
  std::map<PrimitiveId, std::int32_t>
      object_of_primitive_;  ///< as last told; of the services' thread
  Stamp saved_frame_;  ///< newest one that a call at the end has saved; of the services' thread
  ros::ServiceServer save_server_;
  ros::ServiceServer part_server_;
  ros::ServiceServer load_server_;
  ros::ServiceServer mesh_server_;
  std::unique_ptr<NavigationStage> navigation_;  ///< outlives the stage that tells it of places
  std::unique_ptr<BackgroundStage> background_;
  std::unique_ptr<ObjectStage> objects_;
  std::unique_ptr<CorrectionStage> corrections_;  ///< between the input and the stages above
  std::unique_ptr<LoopStage> loops_;              ///< null unless it is to correct the map
  ros_interface::EpochFollower segmentations_epoch_;
  std::unique_ptr<ros_interface::FrameMatcher> matcher_;
  std::unique_ptr<ros_interface::RgbdInput> input_;
  ros::Subscriber segmentation_subscriber_;
  ros::Subscriber tracks_subscriber_;
  std::size_t segmentation_topic_ = 0;  ///< their numbers among those that are watched
  std::size_t tracks_topic_ = 0;
};

MeshFusionNodelet::~MeshFusionNodelet() {
  stopCallbacks();
  save_server_.shutdown();
  part_server_.shutdown();
  load_server_.shutdown();
  mesh_server_.shutdown();
  if (background_ == nullptr || objects_ == nullptr) return;
  tracks_subscriber_.shutdown();
  segmentation_subscriber_.shutdown();
  input_.reset();
  if (corrections_ != nullptr) corrections_->stop();
  if (loops_ != nullptr) loops_->stop();
  background_->stop();
  objects_->stop();
  const Stamp newest = background_->newestFrame();
  const bool is_saved = newest != Stamp{} && newest == saved_frame_;
  ros_interface::EndReport end{getName(), is_saved ? "" : config_.output, {}, "", ""};
  if (newest == Stamp{}) end.reason = report().describeInput("colour image");
  try {
    if (end.reason.empty() && !end.folder.empty()) end.files = writeFiles(config_.output);
  } catch (const std::exception& e) {
    end.problem = std::string("mesh not saved: ") + e.what();
  }
  ros_interface::reportEnd(end);
}

void MeshFusionNodelet::start() {
  config_ = loadConfig<MeshFusionNodeletConfig>();
  ros_interface::checkInputFiles(config_.input);
  checkCorrections(config_.corrections);
  matcher_ =
      std::make_unique<ros_interface::FrameMatcher>(static_cast<std::size_t>(config_.frame_cache));
  startStages();
  if (!config_.map.empty()) objects_->begin(loadMap(config_.map));
  subscribe();
}

void MeshFusionNodelet::startStages() {
  ros::NodeHandle& handle = topicHandle();
  const std::string& world_frame = config_.input.world_frame;
  planning::PlannerConfig planner = config_.planner;
  planner.max_step_m = config_.background_fusion.places.max_step_m;
  navigation_ = std::make_unique<NavigationStage>(
      handle, NavigationStage::Options{planner, world_frame}, report());
  background_ = std::make_unique<BackgroundStage>(
      handle,
      BackgroundStageOptions{config_.background_fusion, world_frame, config_.mesh_period_s,
                             config_.octomap_period_s, static_cast<std::size_t>(config_.queue_size),
                             1000000U * static_cast<std::size_t>(config_.queue_megabytes),
                             [this](const PlaceGraph& graph, const places::GroundPlan& plan) {
                               navigation_->setMap(graph, plan);
                             }},
      report());
  objects_ = std::make_unique<ObjectStage>(
      handle,
      ObjectStageOptions{config_.object_fusion, world_frame,
                         static_cast<std::size_t>(config_.object_queue_size),
                         config_.input.tf_timeout_s + 1.0},
      report());
  startCorrections();
  save_server_ = serviceHandle().advertiseService("save_mesh", &MeshFusionNodelet::saveMesh, this);
  part_server_ =
      serviceHandle().advertiseService("save_map_part", &MeshFusionNodelet::savePart, this);
  load_server_ = serviceHandle().advertiseService("load_map", &MeshFusionNodelet::serveLoad, this);
  mesh_server_ = serviceHandle().advertiseService("get_mesh", &MeshFusionNodelet::serveMesh, this);
}

void MeshFusionNodelet::startCorrections() {
  CorrectionStage::Callbacks callbacks;
  callbacks.apply = [this](const MapCorrectionPtr& correction) {
    background_->correct(correction);
    objects_->correct(correction);
  };
  callbacks.camera_frame = [this] { return input_ == nullptr ? "" : input_->cameraFrame(); };
  corrections_ = std::make_unique<CorrectionStage>(
      topicHandle(), CorrectionStage::Options{config_.corrections, config_.input.world_frame},
      report(), callbacks);
  const CorrectionConfig& config = config_.corrections;
  if (!config.close_loops) return;
  LoopStage::Options options{loops::makeLoopCloserConfig(config.loops), config.odometry_frame,
                             config.loop_period_s};
  options.config.keyframes = config.outside.keyframes;
  loops_ = std::make_unique<LoopStage>(
      options, report(), [this](const LoopResult& result) { corrections_->follow(result); });
}

void MeshFusionNodelet::subscribe() {
  ros::NodeHandle& handle = topicHandle();
  ros_interface::InputConfig input = config_.input;
  if (corrections_->isOn()) input.world_frame = config_.corrections.odometry_frame;
  const auto& tsdf = config_.background_fusion.background.tsdf;
  input_ = std::make_unique<ros_interface::RgbdInput>(
      handle, input, report(),
      ros_interface::RgbdInput::Callbacks{[this](const RgbdFramePtr& frame) { onFrame(frame); },
                                          [this] { onJumpBack(); }},
      plausibility::PlausibilityConfig{tsdf.min_range_m, tsdf.max_range_m});
  segmentation_subscriber_ = handle.subscribe(config_.input.segmentation_topic, 100,
                                              &MeshFusionNodelet::onSegmentation, this);
  tracks_subscriber_ =  // no bound: none may drop
      handle.subscribe("tracks", 0, &MeshFusionNodelet::onTracks, this);
  ros_interface::TopicWatch& watch = input_->watch();
  segmentation_topic_ = watch.add(segmentation_subscriber_, config_.input.segmentation_topic,
                                  "task_scene_graph/Segmentation");
  tracks_topic_ = watch.add(tracks_subscriber_, "tracks");
}

void MeshFusionNodelet::onFrame(const RgbdFramePtr& frame) {
  if (isPaused()) return;
  corrections_->placeNew(frame, [this](const RgbdFramePtr& placed) {
    navigation_->setCamera(placed->T_world_camera.translation());
    background_->addFrame(placed);
  });
  handMatch(matcher_->addFrame(frame));
}

void MeshFusionNodelet::onSegmentation(const msg::SegmentationConstPtr& message) {
  input_->watch().noteMessage(segmentation_topic_);
  try {
    const SegmentationPtr segmentation =
        ros_interface::fromMessage(message, segmentation_subscriber_.getTopic());
    const std::uint32_t epoch = segmentations_epoch_.follow(message->epoch, segmentation->stamp);
    handMatch(matcher_->addSegmentation(segmentation, epoch));
  } catch (const std::exception& e) {
    report().countDropped("unusable segmentation", e.what());
  }
}

void MeshFusionNodelet::onTracks(const msg::TracksConstPtr& message) {
  input_->watch().noteMessage(tracks_topic_);
  objects_->addTracks(message);
}

void MeshFusionNodelet::onJumpBack() {
  segmentations_epoch_.startEpoch();
  matcher_->startEpoch(segmentations_epoch_.epoch());
  corrections_->startEpoch();
  if (loops_ != nullptr) loops_->end();
  objects_->startEpoch();
}

void MeshFusionNodelet::handMatch(const std::optional<Match>& match) {
  if (!match) return;
  if (loops_ != nullptr) loops_->addFrame(match->frame, match->segmentation);
  corrections_->placeAgain(match->frame, [&](const RgbdFramePtr& placed) {
    background_->addView(placed, match->segmentation);
    objects_->addFrame(placed, match->segmentation);
  });
}

void MeshFusionNodelet::check() {
  input_->check();
  background_->check();
  objects_->check();
  corrections_->check();
  if (loops_ != nullptr) loops_->check();
  report().set("frames that wait for a segmentation", std::to_string(matcher_->numFrames()));
}

msg::FlushResponse MeshFusionNodelet::flush(const msg::FlushRequest& request,
                                            const ros_interface::Patience& patience) {
  msg::FlushResponse response;
  input_->flush();
  if (request.mode == msg::FlushRequest::END) finishLoops(patience);
  corrections_->hold();
  objects_->flush(request, patience, response);
  for (const auto& line : background_->flush(patience)) response.missing.push_back(line);
  response.place_sequence = background_->placeSequence();
  return response;
}

/// A quarter of the time at most: the map itself goes first.
void MeshFusionNodelet::finishLoops(ros_interface::Patience patience) {
  if (loops_ == nullptr) return;
  const auto now = ros_interface::Patience::Clock::now();
  patience.deadline = now + (patience.deadline - now) / 4;
  if (loops_->finish(patience)) return;
  report().warn("loop closure", "not all keyframes were looked at for loop closures in time");
}

std::string MeshFusionNodelet::reset() {
  const std::size_t num_primitives = objects_->primitives().size();
  matcher_->clear();
  corrections_->restart({});
  if (loops_ != nullptr) loops_->restart();
  background_->reset();
  objects_->reset();
  navigation_->forgetCamera();
  return "the mesh, the places and " + std::to_string(num_primitives) +
         " object primitives are forgotten";
}

bool MeshFusionNodelet::saveMesh(msg::SaveMeshRequest& request, msg::SaveMeshResponse& response) {
  const ros_interface::FlushGuard guard;
  try {
    const std::filesystem::path folder =
        request.folder.empty() ? config_.output : std::filesystem::path(request.folder);
    if (folder.empty()) throw std::runtime_error("parameter 'output' is not set");
    requireFrames();
    for (const auto& file : writeFiles(folder)) {
      response.files.push_back(file.name);
      response.contents.push_back(file.content);
    }
    response.message = (folder / "mesh.ply").string();
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = std::string("mesh not saved: ") + e.what();
    response.success = 0;
  }
  return true;
}

bool MeshFusionNodelet::savePart(msg::SaveMapPartRequest& request,
                                 msg::SaveMapPartResponse& response) {
  const ros_interface::FlushGuard guard;
  try {
    const Stamp newest = requireFrames();
    object_of_primitive_ = pairObjects(request.primitives, request.objects);
    response.since = ros_interface::toRosTime(background_->firstFrame());
    for (const auto& file : writePart(request.folder, map::BackgroundFiles::kAll)) {
      response.files.push_back(file.name);
      response.contents.push_back(file.content);
    }
    response.success = 1;
    if (request.is_end != 0) saved_frame_ = newest;
  } catch (const std::exception& e) {
    response.message = std::string("mesh not saved: ") + e.what();
  }
  corrections_->release();
  return true;
}

Stamp MeshFusionNodelet::requireFrames() {
  const Stamp newest = background_->newestFrame();
  if (newest == Stamp{}) throw std::runtime_error(report().describeInput("colour image"));
  return newest;
}

bool MeshFusionNodelet::serveMesh(msg::GetMesh::Request& request,
                                  msg::GetMesh::Response& response) {
  try {
    requireFrames();
    map::Map map = background_->makeMap();
    map.addPrimitives(objects_->primitives());
    response.points = makeMeshPoints(map, pairObjects(request.primitives, request.objects));
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = e.what();
  }
  return true;
}

std::vector<WrittenFile> MeshFusionNodelet::writeFiles(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  if (!std::filesystem::exists(map::locateFile(folder, map::kManifestName))) {
    return writePart(folder, map::BackgroundFiles::kForOthers);
  }
  std::vector<WrittenFile> files;
  map::replaceFiles(folder, std::nullopt, [&](const std::filesystem::path& to) {
    files = writePart(to, map::BackgroundFiles::kAll);
    return map::OtherFiles::kKeep;
  });
  return files;
}

std::vector<WrittenFile> MeshFusionNodelet::writePart(const std::filesystem::path& folder,
                                                      map::BackgroundFiles what) {
  map::Map map = background_->makeMap();
  map.addPrimitives(objects_->primitives());
  return map::writeBackgroundPart(folder, map, object_of_primitive_, navigation_->storeys(), what);
}

bool MeshFusionNodelet::serveLoad(msg::LoadMapRequest& request, msg::LoadMapResponse& response) {
  try {
    objects_->restore(loadMap(request.folder));
    const auto patience = ros_interface::Patience::from(60.0, 30.0);
    objects_->waitHandled(patience);
    background_->waitForPlaces(patience.deadline);
    response.sequence = objects_->sequence();
    response.place_sequence = background_->placeSequence();
    response.message = formatCount(objects_->primitives().size(), "object primitive");
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = e.what();
  }
  return true;
}

std::vector<ObjectPrimitivePtr> MeshFusionNodelet::loadMap(const std::filesystem::path& folder) {
  const auto& fusion = config_.background_fusion;
  map::MapUse use;
  use.world_frame = config_.input.world_frame;
  use.mesh_voxel_size_m = fusion.background.tsdf.voxel_size_m;
  use.free_space_voxel_size_m = fusion.free_space.tsdf.voxel_size_m;
  map::LoadedMap loaded = map::loadMap(folder, use);
  if (fusion.occupancy.enabled) {
    loaded.map.setOccupancy(map::readOccupancy(folder, fusion.occupancy));
  }
  matcher_->clear();
  corrections_->restart(*loaded.map.trajectory());
  if (loops_ != nullptr) loops_->restart();
  background_->restore(loaded.map);
  return loaded.map.primitives();
}

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::MeshFusionNodelet, nodelet::Nodelet)
