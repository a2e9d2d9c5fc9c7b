// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/loops/map_alignment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "task_scene_graph/loops/loop_closer.h"
#include "task_scene_graph/map/merge.h"
#include "task_scene_graph/mapping/moved_voxels.h"
#include "task_scene_graph/scene_graph/scoring.h"
#include "task_scene_graph/trajectory/se3.h"

namespace tsg::loops {
namespace {

constexpr double kSpacing_m = 2.0;  ///< between scenes along the way
constexpr double kReach_m = 4.0;    ///< of a scene
constexpr double kPlaceReach_m = 2.0;
constexpr std::size_t kMostAlike = 8;     ///< scenes of the other map, by their images
constexpr std::size_t kMostTried = 4;     ///< ... of them, by their landmarks
constexpr double kScorePerPair = 0.03;    ///< of a constellation: as much as so much cosine
constexpr double kSame_m = 0.3;           ///< two estimates that differ by less, and ...
constexpr double kSameTurn_rad = 0.0524;  ///< ... 3 degrees, say the same
constexpr double kSameThing_m = 0.5;
constexpr std::size_t kLeastPairs = 3;
constexpr std::size_t kLeastPlaces = 2;
constexpr std::size_t kLeastThings = 5;      ///< fewer say nothing
constexpr double kLeastShareThere = 0.2;     ///< of them
constexpr std::size_t kLeastPairsAlone = 6;  ///< where surfaces alone speak
constexpr std::size_t kLeastPlacesAlone = 3;

struct MapScene {
  Eigen::Vector3d eye_m;
  Points points;  ///< from the eye, axes of the map
  std::vector<Landmark> landmarks;
  Embedding image;  ///< empty if no place near the eye has one
};

/// What one pair of scenes says.
struct Estimate {
  Pose T_a_b;
  Eigen::Vector3d eye_m;  ///< of the scene of b
  double overlap;
};

void requireParts(const map::Map& map, const std::string& name) {
  const auto refuse = [&](const std::string& what) {
    throw std::runtime_error("maps not aligned: " + name + " has no " + what);
  };
  if (map.trajectory() == nullptr || map.trajectory()->isEmpty()) refuse("trajectory");
  if (map.meshBlocks().empty()) refuse("mesh");
}

std::vector<Eigen::Vector3d> chooseEyes(const Trajectory& way) {
  std::vector<Eigen::Vector3d> eyes_m;
  for (const auto& [ns, pose] : way.poses()) {
    const Eigen::Vector3d p_m = pose.translation();
    const bool is_far = std::all_of(eyes_m.begin(), eyes_m.end(), [&](const auto& eye_m) {
      return (eye_m - p_m).norm() >= kSpacing_m;
    });
    if (is_far) eyes_m.push_back(p_m);
  }
  return eyes_m;
}

/// Middles of the triangles that face the eye: what it may have seen.
void addFacing(const Mesh& mesh, const Eigen::Vector3d& eye_m, Points& points) {
  const Eigen::Vector3f eye = eye_m.cast<float>();
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.vertices[triangle[0]];
    const Eigen::Vector3f& b = mesh.vertices[triangle[1]];
    const Eigen::Vector3f& c = mesh.vertices[triangle[2]];
    const Eigen::Vector3f middle = (a + b + c) / 3.0F - eye;
    if (middle.norm() > static_cast<float>(kReach_m)) continue;
    if ((b - a).cross(c - a).dot(middle) < 0.0F) points.push_back(middle);
  }
}

Points collectPoints(const map::Map& map, const Eigen::Vector3d& eye_m, float voxel_m) {
  const double side_m = map.meshVoxelSize() * mapping::kBlockSide;
  Points points;
  for (const auto& block : map.meshBlocks()) {
    const Eigen::Vector3d middle_m = mapping::computeBlockMiddle(block.block, map.meshVoxelSize());
    if ((middle_m - eye_m).norm() > kReach_m + side_m) continue;
    addFacing(*block.mesh, eye_m, points);
  }
  return downsample(points, voxel_m);
}

bool isLandmark(const ObjectPrimitive& primitive, double largest_m) {
  return hasDirection(primitive.embedding) && primitive.box.sizes().maxCoeff() <= largest_m;
}

std::vector<Landmark> collectLandmarks(const map::Map& map, const Eigen::Vector3d& eye_m,
                                       double largest_m) {
  std::vector<Landmark> landmarks;
  for (const ObjectPrimitivePtr& primitive : map.primitives()) {
    const Eigen::Vector3d from_eye_m = primitive->box.center() - eye_m;
    if (from_eye_m.norm() > kReach_m || !isLandmark(*primitive, largest_m)) continue;
    landmarks.push_back({from_eye_m, primitive->embedding});
  }
  return landmarks;
}

Embedding computeImage(const map::Map& map, const Eigen::Vector3d& eye_m) {
  scene_graph::EmbeddingMean mean;
  for (const Place& place : map.places()->places) {
    if ((place.position_m - eye_m).norm() > kPlaceReach_m || !place.embedding.hasDirection())
      continue;
    mean.add(place.embedding);
  }
  return mean.mean();
}

std::vector<MapScene> makeScenes(const map::Map& map, const LoopCloserConfig& config) {
  std::vector<MapScene> scenes;
  for (const Eigen::Vector3d& eye_m : chooseEyes(*map.trajectory())) {
    scenes.push_back(
        {eye_m, collectPoints(map, eye_m, static_cast<float>(config.registration.voxel_m)),
         collectLandmarks(map, eye_m, config.scene.max_landmark_m), computeImage(map, eye_m)});
  }
  return scenes;
}

/// A scene of a that may be the one of b.
struct Candidate {
  std::size_t scene;
  double score;
  Constellation constellation;
};

template <typename Items>
void keepBest(std::size_t count, Items& items) {
  std::stable_sort(items.begin(), items.end(),
                   [](const auto& x, const auto& y) { return x.score > y.score; });
  if (items.size() > count)
    items.erase(items.begin() + static_cast<std::ptrdiff_t>(count), items.end());
}

std::vector<Candidate> findCandidates(const std::vector<MapScene>& scenes, const MapScene& query,
                                      const ConstellationConfig& config) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Embedding& image = scenes[i].image;
    const bool has_images = image.size() > 0 && image.size() == query.image.size();
    candidates.push_back({i, has_images ? computeCosine(image, query.image) : 0.0, {}});
  }
  keepBest(kMostAlike, candidates);
  for (Candidate& candidate : candidates) {
    candidate.constellation =
        matchConstellation(scenes[candidate.scene].landmarks, query.landmarks, config);
    candidate.score += kScorePerPair * static_cast<double>(candidate.constellation.pairs.size());
  }
  keepBest(kMostTried, candidates);
  return candidates;
}

bool fits(const Registration& found, const LoopConfig& config) {
  return found.overlap >= config.min_overlap && found.rms_m <= config.max_rms_m &&
         found.least_eigenvalue >= config.min_eigenvalue &&
         map::computeTilt(found.T_target_source) <= map::kMaxTilt_rad;
}

std::vector<Estimate> compare(const std::vector<MapScene>& scenes_a,
                              const std::vector<MapScene>& scenes_b, const LoopCloserConfig& config,
                              MapAlignment& result) {
  std::vector<RegisteredCloud> clouds;
  for (const MapScene& scene : scenes_a) clouds.emplace_back(scene.points, config.registration);
  std::vector<Estimate> estimates;
  for (const MapScene& query : scenes_b) {
    const RegisteredCloud cloud(query.points, config.registration);
    for (const Candidate& candidate : findCandidates(scenes_a, query, config.constellation)) {
      ++result.num_tried;
      const RegisteredCloud& target = clouds[candidate.scene];
      std::vector<Pose> guesses;
      if (!candidate.constellation.pairs.empty()) guesses.push_back(candidate.constellation.T_a_b);
      Pose by_features;
      if (alignByFeatures(cloud, target, config.registration, by_features)) {
        guesses.push_back(by_features);
      }
      const Registration found = registerClouds(cloud, target, guesses, config.registration);
      if (!fits(found, config.loops)) continue;
      const Pose T_a_b = Eigen::Translation3d(scenes_a[candidate.scene].eye_m) *
                         found.T_target_source * Eigen::Translation3d(-query.eye_m);
      estimates.push_back({T_a_b, query.eye_m, found.overlap});
    }
  }
  result.num_fitting = estimates.size();
  return estimates;
}

/// At the places where both were made.
bool saySame(const Estimate& x, const Estimate& y) {
  if (trajectory::computeAngle(x.T_a_b.inverse() * y.T_a_b) > kSameTurn_rad) return false;
  const auto difference_m = [&](const Eigen::Vector3d& p_m) {
    return (x.T_a_b * p_m - y.T_a_b * p_m).norm();
  };
  return std::min(difference_m(x.eye_m), difference_m(y.eye_m)) <= kSame_m;
}

using Set = std::vector<Estimate>;

/// Those that say the same as one of them: the largest such set, by the sum of overlaps.
Set findLargestSet(const std::vector<Estimate>& estimates) {
  Set best;
  double best_overlap = 0.0;
  for (const Estimate& seed : estimates) {
    Set set;
    double overlap = 0.0;
    for (const Estimate& other : estimates) {
      if (!saySame(seed, other)) continue;
      set.push_back(other);
      overlap += other.overlap;
    }
    if (overlap <= best_overlap) continue;
    best = std::move(set);
    best_overlap = overlap;
  }
  return best;
}

std::size_t countPlaces(const Set& set) {
  std::vector<Eigen::Vector3d> eyes_m;
  for (const Estimate& estimate : set) {
    if (std::find(eyes_m.begin(), eyes_m.end(), estimate.eye_m) == eyes_m.end()) {
      eyes_m.push_back(estimate.eye_m);
    }
  }
  return eyes_m.size();
}

/// Of least squares over what each says of points around its eye.
Pose computeMean(const Set& set) {
  Eigen::Matrix3Xd in_a(3, static_cast<Eigen::Index>(4 * set.size()));
  Eigen::Matrix3Xd in_b = in_a;
  Eigen::Index column = 0;
  for (const Estimate& estimate : set) {
    for (int axis = -1; axis < 3; ++axis, ++column) {
      Eigen::Vector3d p_m = estimate.eye_m;
      if (axis >= 0) p_m += Eigen::Vector3d::Unit(axis) * kReach_m;
      in_b.col(column) = p_m;
      in_a.col(column) = estimate.T_a_b * p_m;
    }
  }
  Pose mean;
  mean.matrix() = Eigen::umeyama(in_b, in_a, false);
  return mean;
}

/// Whether the map has what looks so near to there.
bool hasThing(const map::Map& map, const Landmark& thing, double min_cosine) {
  return std::any_of(map.primitives().begin(), map.primitives().end(),
                     [&](const ObjectPrimitivePtr& other) {
                       return (other->box.center() - thing.position_m).norm() <= kSameThing_m &&
                              other->embedding.size() == thing.embedding.size() &&
                              computeCosine(other->embedding, thing.embedding) >= min_cosine;
                     });
}

/// Of the things around the places that agree: how many are in a too, and how many there are.
std::pair<std::size_t, std::size_t> countThings(const map::Map& a, const map::Map& b,
                                                const Set& set, const Pose& T_a_b,
                                                const LoopCloserConfig& config) {
  std::size_t num_there = 0;
  std::size_t num_things = 0;
  for (const ObjectPrimitivePtr& thing : b.primitives()) {
    const Eigen::Vector3d middle_m = thing->box.center();
    const bool is_near = std::any_of(set.begin(), set.end(), [&](const Estimate& estimate) {
      return (estimate.eye_m - middle_m).norm() <= kPlaceReach_m;
    });
    if (!is_near || !isLandmark(*thing, config.scene.max_landmark_m)) continue;
    ++num_things;
    const Landmark in_a{T_a_b * middle_m, thing->embedding};
    if (hasThing(a, in_a, config.constellation.min_cosine)) ++num_there;
  }
  return {num_there, num_things};
}

[[noreturn]] void refuse(const MapAlignment& found, const std::string& why) {
  throw std::runtime_error("maps not aligned: " + std::to_string(found.num_tried) +
                           " pairs of places were compared, " + std::to_string(found.num_fitting) +
                           " lie on each other, " + std::to_string(found.num_agreeing) +
                           " of them say the same; " + why);
}

void describe(const map::Map& a, const map::Map& b, const Set& set, const LoopCloserConfig& config,
              MapAlignment& result) {
  result.T_a_b = computeMean(set);
  for (const Estimate& estimate : set) {
    result.overlap += estimate.overlap / static_cast<double>(set.size());
  }
  std::tie(result.num_there, result.num_things) = countThings(a, b, set, result.T_a_b, config);
}

void requireEnough(const Set& set, const MapAlignment& result) {
  const bool has_things = result.num_things >= kLeastThings;
  const std::size_t least_pairs = has_things ? kLeastPairs : kLeastPairsAlone;
  const std::size_t least_places = has_things ? kLeastPlaces : kLeastPlacesAlone;
  if (set.size() < least_pairs || countPlaces(set) < least_places) {
    refuse(result, "expected at least " + std::to_string(least_pairs) + ", from " +
                       std::to_string(least_places) + " places: have both seen the same?");
  }
  if (!has_things || static_cast<double>(result.num_there) >=
                         kLeastShareThere * static_cast<double>(result.num_things)) {
    return;
  }
  refuse(result, std::to_string(result.num_there) + " of " + std::to_string(result.num_things) +
                     " things around them are in both, expected one in five at least");
}

void requireOneAnswer(const std::vector<Estimate>& estimates, const Set& best,
                      const MapAlignment& result) {
  std::vector<Estimate> others;
  for (const Estimate& estimate : estimates) {
    const bool is_same = std::any_of(best.begin(), best.end(),
                                     [&](const Estimate& one) { return saySame(one, estimate); });
    if (!is_same) others.push_back(estimate);
  }
  const std::size_t num_others = findLargestSet(others).size();
  if (2 * num_others < best.size()) return;
  refuse(result, std::to_string(num_others) +
                     " say something else, expected less than half as many: places look alike");
}

}  // namespace

MapAlignment alignMaps(const map::Map& a, const map::Map& b) {
  requireParts(a, "the first map");
  requireParts(b, "the second map");
  const LoopCloserConfig config;
  MapAlignment result;
  const std::vector<Estimate> estimates =
      compare(makeScenes(a, config), makeScenes(b, config), config, result);
  const Set best = findLargestSet(estimates);
  result.num_agreeing = best.size();
  if (!best.empty()) describe(a, b, best, config, result);
  requireEnough(best, result);
  requireOneAnswer(estimates, best, result);
  return result;
}

std::string toText(const MapAlignment& alignment) {
  const Eigen::Vector3d t = alignment.T_a_b.translation();
  const Eigen::Quaterniond q(alignment.T_a_b.linear());
  std::ostringstream text;
  text << alignment.num_agreeing << " of " << alignment.num_tried
       << " pairs of places (surfaces overlap by " << alignment.overlap << ", "
       << alignment.num_there << " of " << alignment.num_things
       << " things are in both) say: --transform " << t.x() << ' ' << t.y() << ' ' << t.z() << ' '
       << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w();
  return text.str();
}

}  // namespace tsg::loops
