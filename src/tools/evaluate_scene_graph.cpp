// SPDX-License-Identifier: BSD-3-Clause
// Scores the objects of a scene graph against the things that are there.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "goal_report.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/evaluation/calibration.h"
#include "task_scene_graph/evaluation/class_scores.h"
#include "task_scene_graph/evaluation/map_regions.h"
#include "task_scene_graph/evaluation/mesh_scores.h"
#include "task_scene_graph/evaluation/object_scores.h"
#include "task_scene_graph/evaluation/object_truth.h"
#include "task_scene_graph/language/text_encoder.h"
#include "task_scene_graph/scene_graph/file_objects.h"
#include "task_scene_graph/scene_graph/tasks.h"
#include "task_scene_graph/segmentation/model_set.h"

namespace options = boost::program_options;
namespace fs = std::filesystem;
using namespace tsg;
using evaluation::ObjectScores;
using evaluation::ScoreMode;
using scene_graph::FileObject;

namespace {

constexpr double kBinWidth = 0.02;    ///< of cosines, for the calibration
constexpr double kCurveStep = 0.005;  ///< likewise, for precision and recall

struct Arguments {
  std::string map;
  std::string truth;
  std::string tasks;
  std::string models;
  std::string json;
  std::string rooms;
  std::string labels;
  std::string true_mesh;
  double label_distance_m = 0.1;
  scene_graph::FileLayer layer = scene_graph::FileLayer::kObjects;
  scene_graph::BoxSource boxes = scene_graph::BoxSource::kFile;
  evaluation::TruthExtent extent = evaluation::TruthExtent::kSeen;
  std::vector<ScoreMode> modes;
  std::optional<double> min_cosine;
  bool is_named = false;
};

/// The value of an option that is one of some words.
template <typename Value>
Value choose(const char* option, const std::string& word,
             const std::vector<std::pair<std::string, Value>>& choices) {
  std::string names;
  for (const auto& [name, value] : choices) {
    if (name == word) return value;
    names += (names.empty() ? "" : ", ") + name;
  }
  throw options::error("--" + std::string(option) + " is '" + word + "', expected one of " + names);
}

constexpr const char* kUsage =
    "Scores a map's objects against the true things: recall, precision and F1 (strict and "
    "relaxed)\nand IoU of boxes, as the Clio paper's Table I does.\n"
    "usage: evaluate_scene_graph --map MAP --truth TRUTH --tasks TASKS [options]\noptions";

/// Nothing if only help was asked for.
std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments arguments;
  std::string layer = "objects", boxes = "file", extent = "seen", mode = "both";
  options::options_description description(kUsage);
  description.add_options()("help,h", "print this")(
      "map", tools::pathOption(arguments.map)->required(),
      "map folder, or a scene graph in spark_dsg's JSON (of any system)")(
      "truth", tools::pathOption(arguments.truth)->required(),
      "task -> boxes, as Clio's datasets have them (YAML); or the folder of simulate_apartment's "
      "ground truth or of a rendered house")(
      "tasks", tools::pathOption(arguments.tasks)->required(),
      "task file with the embedding of each task of the truth, or with names and --models")(
      "models", tools::pathOption(arguments.models),
      "model set whose text encoder encodes tasks that have no embedding")(
      "layer", options::value(&layer), "objects, or segments: the primitives (objects)")(
      "boxes", options::value(&boxes), "file, or mesh: fitted to each node's mesh (file)")(
      "extent", options::value(&extent), "of a rendered house: seen, or all (seen)")(
      "mode", options::value(&mode), "paper, as_released or both (both)")(
      "min-cosine",
      options::value<double>()->notifier([&](double cosine) { arguments.min_cosine = cosine; }),
      "leaves out objects whose best cosine is not above this (the -task rows of the paper)")(
      "named", options::bool_switch(&arguments.is_named),
      "leaves out objects without a name: those that cluster_scene_graph gave to no task")(
      "rooms", tools::pathOption(arguments.rooms),
      "true rooms, for the regions: rooms.json of a generated world or a rendered house, or a YAML "
      "file as Hydra has it; the map must be a folder with ground plans")(
      "labels", tools::pathOption(arguments.labels),
      "PLY whose vertices have an int label, the number of a task of the truth (from 0) or -1: "
      "closed-set scores of mesh.ply of the map folder, whose tasks are the classes")(
      "label-distance", options::value(&arguments.label_distance_m),
      "farther than this from every vertex of the map a labelled one counts as missed, m (0.1)")(
      "true-mesh", tools::pathOption(arguments.true_mesh),
      "true surfaces (PLY), mesh.ply of a generated world or scene_mesh.ply of a rendered house: "
      "success of going to each task's best object by the map folder's places, from where its walk "
      "began, and how far the map's mesh is off")("json", tools::pathOption(arguments.json),
                                                  "file to write all numbers to");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  using scene_graph::BoxSource;
  using scene_graph::FileLayer;
  using Modes = std::vector<ScoreMode>;
  arguments.layer = choose<FileLayer>(
      "layer", layer, {{"objects", FileLayer::kObjects}, {"segments", FileLayer::kSegments}});
  if (arguments.is_named && arguments.layer == FileLayer::kSegments) {
    throw options::error("--named goes with --layer objects; segments have no name");
  }
  arguments.boxes =
      choose<BoxSource>("boxes", boxes, {{"file", BoxSource::kFile}, {"mesh", BoxSource::kMesh}});
  arguments.extent = choose<evaluation::TruthExtent>(
      "extent", extent,
      {{"seen", evaluation::TruthExtent::kSeen}, {"all", evaluation::TruthExtent::kAll}});
  arguments.modes = choose<Modes>("mode", mode,
                                  {{"paper", {ScoreMode::kPaper}},
                                   {"as_released", {ScoreMode::kAsReleased}},
                                   {"both", {ScoreMode::kPaper, ScoreMode::kAsReleased}}});
  return arguments;
}

scene_graph::TaskList readTasks(const Arguments& arguments) {
  scene_graph::TaskList tasks = scene_graph::loadTasks(arguments.tasks);
  if (tasks.hasEmbeddings() || tasks.size() == 0) return tasks;
  if (arguments.models.empty()) {
    throw std::invalid_argument("tasks '" + arguments.tasks + "': task '" + tasks.names.front() +
                                "' has no embedding; expected one per task, or --models");
  }
  const language::TextEncoder encoder(segmentation::loadModelSet(arguments.models), {});
  tasks.embeddings = encoder.encodeTasks(tasks.names);
  return tasks;
}

/// The embeddings of the truth's tasks, a row each, of unit length.
EmbeddingMatrix pickEmbeddings(const scene_graph::TaskList& tasks,
                               const std::vector<evaluation::TaskTruth>& truth,
                               const std::string& path) {
  EmbeddingMatrix picked(static_cast<Eigen::Index>(truth.size()), tasks.embeddings.cols());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto found = std::find(tasks.names.begin(), tasks.names.end(), truth[i].task);
    if (found == tasks.names.end()) {
      throw std::invalid_argument("tasks '" + path + "' have no '" + truth[i].task +
                                  "', which is in the truth; expected all of its tasks");
    }
    picked.row(static_cast<Eigen::Index>(i)) =
        tasks.embeddings.row(found - tasks.names.begin()).normalized();
  }
  return picked;
}

fs::path findGraph(const std::string& map) {
  return fs::is_directory(map) ? fs::path(map) / "scene_graph.json" : fs::path(map);
}

std::vector<evaluation::Estimate> makeEstimates(const std::vector<FileObject>& objects,
                                                const EmbeddingMatrix& tasks,
                                                const Arguments& arguments) {
  std::vector<evaluation::Estimate> estimates;
  for (const FileObject& object : objects) {
    if (arguments.is_named && object.name.empty()) continue;
    if (object.embedding.size() != tasks.cols()) {
      throw std::invalid_argument("map '" + arguments.map + "' has an object whose embedding has " +
                                  std::to_string(object.embedding.size()) +
                                  " numbers, expected the tasks' " + std::to_string(tasks.cols()));
    }
    const Eigen::VectorXd cosines =
        tasks.cast<double>() * object.embedding.cast<double>().normalized();
    if (arguments.min_cosine && !(cosines.maxCoeff() > *arguments.min_cosine)) continue;
    estimates.push_back({object.box, cosines});
  }
  return estimates;
}

const char* getName(ScoreMode mode) { return mode == ScoreMode::kPaper ? "paper" : "as_released"; }

nlohmann::json toJson(const evaluation::DetectionScores& scores) {
  return {{"recall", scores.recall}, {"precision", scores.precision}, {"f1", scores.f1}};
}

/// Objects for tasks that nothing in the world serves.
std::size_t countFalse(const ObjectScores& scores) {
  std::size_t num_false = 0;
  for (const auto& row : scores.tasks) num_false += row.num_true == 0 ? row.num_kept : 0;
  return num_false;
}

nlohmann::json toJson(const ObjectScores& scores) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& row : scores.tasks) {
    rows.push_back({{"task", row.task},
                    {"num_true", row.num_true},
                    {"found_strict", row.found_strict},
                    {"found_relaxed", row.found_relaxed},
                    {"iou_sum", row.iou_sum},
                    {"num_kept", row.num_kept},
                    {"correct_strict", row.correct_strict},
                    {"correct_relaxed", row.correct_relaxed}});
  }
  return {{"strict", toJson(scores.strict)},
          {"relaxed", toJson(scores.relaxed)},
          {"iou", scores.iou},
          {"center_error_m",
           scores.center_error_m ? nlohmann::json(*scores.center_error_m) : nlohmann::json()},
          {"num_objects", scores.num_objects},
          {"num_true", scores.num_true},
          {"num_kept", scores.num_kept},
          {"num_false", countFalse(scores)},
          {"tasks", rows}};
}

void printTasks(const ObjectScores& scores) {
  std::printf("%-32s %5s %6s %7s %5s %5s %6s %7s\n", "task", "true", "strict", "relaxed", "IoU",
              "kept", "strict", "relaxed");
  for (const auto& row : scores.tasks) {
    const double iou = row.num_true > 0 ? row.iou_sum / static_cast<double>(row.num_true) : 0.0;
    std::printf("%-32.32s %5zu %6zu %7zu %5.2f %5zu %6zu %7zu\n", row.task.c_str(), row.num_true,
                row.found_strict, row.found_relaxed, iou, row.num_kept, row.correct_strict,
                row.correct_relaxed);
  }
}

void printLine(const char* name, const evaluation::DetectionScores& scores) {
  std::printf("  %-8s osR %.3f  osP %.3f  F1 %.3f\n", name, scores.recall, scores.precision,
              scores.f1);
}

void print(ScoreMode mode, const ObjectScores& scores) {
  std::printf("\nmode %s\n", getName(mode));
  printTasks(scores);
  printLine("strict", scores.strict);
  printLine("relaxed", scores.relaxed);
  std::printf(
      "  IoU %.3f, of %zu true things; middles off by %.3f m (median); kept %zu of %zu objects; "
      "%zu "
      "for tasks that nothing serves\n",
      scores.iou, scores.num_true, scores.center_error_m.value_or(std::nan("")), scores.num_kept,
      scores.num_objects, countFalse(scores));
}

nlohmann::json toJson(const std::vector<evaluation::CurvePoint>& curve) {
  nlohmann::json points = nlohmann::json::array();
  for (const auto& point : curve) {
    points.push_back({{"min_cosine", point.min_score},
                      {"precision", point.precision},
                      {"recall", point.recall}});
  }
  return points;
}

/// How often objects of a cosine are right.
nlohmann::json reportCalibration(const std::vector<evaluation::ScoredObject>& objects) {
  const auto calibration = evaluation::computeCalibration(objects, kBinWidth);
  nlohmann::json bins = nlohmann::json::array();
  std::printf("\n%-16s %7s %6s %6s\n", "cosine with task", "objects", "right", "share");
  for (const auto& bin : calibration.bins) {
    const double share = static_cast<double>(bin.num_right) / static_cast<double>(bin.num_objects);
    std::printf("%6.2f to %5.2f  %7zu %6zu %6.2f\n", bin.low, bin.low + kBinWidth, bin.num_objects,
                bin.num_right, share);
    bins.push_back({{"low", bin.low},
                    {"num_objects", bin.num_objects},
                    {"num_right", bin.num_right},
                    {"mean_score", bin.mean_score}});
  }
  std::printf("  a right object has a higher cosine than a wrong one: %.3f of the pairs\n",
              calibration.separation);
  return {{"bins", bins}, {"separation", calibration.separation}};
}

nlohmann::json reportRegions(const Arguments& arguments) {
  const auto floors = evaluation::loadFloors(arguments.map);
  if (floors.empty()) {
    throw std::invalid_argument("map '" + arguments.map +
                                "' has no floor_0.yaml; --rooms needs a map folder");
  }
  const auto scores =
      evaluation::scoreRegions(evaluation::loadMapRegions(findGraph(arguments.map).string()),
                               floors, evaluation::loadRoomTruth(arguments.rooms));
  std::printf("\nregions\n  %zu regions, %zu rooms: precision %.3f  recall %.3f  F1 %.3f\n",
              scores.region_precisions.size(), scores.room_recalls.size(), scores.precision,
              scores.recall, scores.f1);
  return {{"precision", scores.precision},
          {"recall", scores.recall},
          {"f1", scores.f1},
          {"total_precision", scores.total_precision},
          {"total_recall", scores.total_recall},
          {"num_regions", scores.region_precisions.size()},
          {"num_rooms", scores.room_recalls.size()}};
}

/// The classes of the map's vertices: the nearest task of the object that each belongs to.
evaluation::LabelledPoints classifyMesh(const std::string& map,
                                        const std::vector<FileObject>& objects,
                                        const EmbeddingMatrix& tasks) {
  constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << 56) - 1;  // below the layer's letter
  std::map<std::uint64_t, int> class_of_object;
  for (const FileObject& object : objects) {
    Eigen::Index task = 0;
    (tasks * object.embedding).maxCoeff(&task);
    class_of_object[object.id & kIndexMask] = static_cast<int>(task);
  }
  auto points = evaluation::loadLabelledPoints((fs::path(map) / "mesh.ply").string(), "object_id");
  for (int& label : points.classes) {
    const auto found = class_of_object.find(static_cast<std::uint64_t>(std::max(label, 0)));
    label = found == class_of_object.end() ? evaluation::kNoClass : found->second;
  }
  return points;
}

nlohmann::json reportClasses(const Arguments& arguments, const std::vector<FileObject>& objects,
                             const EmbeddingMatrix& tasks) {
  const auto truth = evaluation::loadLabelledPoints(arguments.labels, "label");
  const auto confusion =
      evaluation::computeConfusion(truth, classifyMesh(arguments.map, objects, tasks),
                                   static_cast<int>(tasks.rows()), arguments.label_distance_m);
  const auto scores = evaluation::computeClassScores(confusion);
  std::printf("\nclasses of vertices\n  %zu classes: mAcc %.3f  mIoU %.3f  F-mIoU %.3f\n",
              scores.num_classes, scores.mean_accuracy, scores.mean_iou, scores.weighted_iou);
  return {{"mean_accuracy", scores.mean_accuracy},
          {"mean_iou", scores.mean_iou},
          {"weighted_iou", scores.weighted_iou},
          {"num_classes", scores.num_classes},
          {"ious", scores.ious},
          {"recalls", scores.recalls}};
}

/// Null where the map's mesh has no faces.
nlohmann::json reportMesh(const std::string& map_mesh, const std::string& true_mesh) {
  const Mesh mesh = evaluation::loadMesh(map_mesh);
  if (mesh.isEmpty()) {
    std::printf("\nmesh\n  not scored: '%s' has no faces\n", map_mesh.c_str());
    return nullptr;
  }
  const evaluation::MeshScores scores =
      evaluation::computeMeshScores(mesh, evaluation::loadTrueMesh(true_mesh));
  std::printf(
      "\nmesh\n  %zu vertices: off the true surfaces by %.3f m (mean), %.3f m (root mean square), "
      "%.3f m (95 %%); %.3f of them by 0.05 m at most\n",
      scores.num_vertices, scores.mean_m, scores.rms_m, scores.percentile95_m, scores.right);
  return {{"num_vertices", scores.num_vertices},
          {"mean_m", scores.mean_m},
          {"rms_m", scores.rms_m},
          {"percentile95_m", scores.percentile95_m},
          {"right", scores.right}};
}

void run(const Arguments& arguments) {
  const auto truth = evaluation::loadObjectTruth(arguments.truth, arguments.extent);
  const auto tasks = pickEmbeddings(readTasks(arguments), truth, arguments.tasks);
  const auto read = scene_graph::loadFileObjects(findGraph(arguments.map).string(), arguments.layer,
                                                 arguments.boxes);
  for (const std::string& node : read.left_out) {
    std::cerr << "evaluate_scene_graph: map '" << arguments.map << "': left out: " << node << '\n';
  }
  if (read.objects.empty() && !read.left_out.empty()) {
    throw std::runtime_error("map '" + arguments.map + "' has no node that can be scored among " +
                             std::to_string(read.left_out.size()) + ", see above");
  }
  const auto estimates = makeEstimates(read.objects, tasks, arguments);
  nlohmann::json all = {{"map", arguments.map}, {"left_out", read.left_out.size()}};
  for (const ScoreMode mode : arguments.modes) {
    const ObjectScores scores = evaluation::computeObjectScores(truth, estimates, mode);
    print(mode, scores);
    all[getName(mode)] = toJson(scores);
  }
  all["calibration"] = reportCalibration(evaluation::judgeObjects(truth, estimates));
  all["precision_recall"] =
      toJson(evaluation::computePrecisionRecall(truth, estimates, kCurveStep));
  if (!arguments.rooms.empty()) all["regions"] = reportRegions(arguments);
  if (!arguments.labels.empty()) all["classes"] = reportClasses(arguments, read.objects, tasks);
  if (!arguments.true_mesh.empty()) {
    all["goals"] = tools::reportGoals({arguments.map, arguments.true_mesh}, truth, estimates);
    const fs::path mesh = fs::path(arguments.map) / "mesh.ply";
    if (fs::exists(mesh)) all["mesh"] = reportMesh(mesh.string(), arguments.true_mesh);
  }
  if (arguments.json.empty()) return;
  writeFileAtomically(arguments.json, [&](std::ostream& out) { out << all.dump(1) << '\n'; });
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("evaluate_scene_graph", argc, argv, parseArguments, run);
}
