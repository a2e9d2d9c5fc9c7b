// SPDX-License-Identifier: BSD-3-Clause
// Renders views of generated apartments with their true labels: training data for the demo models.

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <thread>

#include "command_line.h"
#include "task_scene_graph/core/files.h"
#include "task_scene_graph/simulation/apartment.h"
#include "task_scene_graph/simulation/renderer.h"
#include "task_scene_graph/simulation/variation.h"

namespace fs = std::filesystem;
namespace options = boost::program_options;
using nlohmann::json;
using namespace tsg;
using namespace tsg::simulation;

namespace {

struct Arguments {
  std::string output;
  int first_seed = 1;
  int apartments = 1;
  int views = 20;
  int width_px = 640;
  int height_px = 480;
  int num_threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::string surfaces = "own";
};

/// Nothing if only help was asked for.
std::optional<Arguments> parseArguments(int argc, char** argv) {
  Arguments a;
  options::options_description description(
      "Renders random views of generated apartments, with true labels and phrases.\n"
      "Writes DIR/SEED_VIEW.color.png, DIR/SEED_VIEW.labels.png (16 bit, instance id, 0 =\n"
      "structure) and DIR/SEED.json (instances and views).\n"
      "usage: render_apartments --output DIR [options]\noptions");
  description.add_options()("help,h", "print this")(
      "output", tools::pathOption(a.output)->required(), "folder, made if absent")(
      "first-seed", options::value(&a.first_seed)->default_value(a.first_seed),
      "seed of the first apartment; the others follow")(
      "apartments", options::value(&a.apartments)->default_value(a.apartments), "how many")(
      "views", options::value(&a.views)->default_value(a.views), "of each apartment")(
      "width", options::value(&a.width_px)->default_value(a.width_px), "of the images, px")(
      "height", options::value(&a.height_px)->default_value(a.height_px), "of the images, px")(
      "threads", options::value(&a.num_threads)->default_value(a.num_threads),
      "the result does not depend on it")(
      "surfaces", options::value(&a.surfaces)->default_value(a.surfaces),
      "own: as simulate_apartment shows them; training or held_out: drawn from that set");
  if (!tools::parseOptions(argc, argv, description)) return std::nullopt;
  if (a.surfaces != "own" && a.surfaces != "training" && a.surfaces != "held_out") {
    throw options::error("surfaces '" + a.surfaces + "', expected own, training or held_out");
  }
  if (a.apartments < 1 || a.views < 1) {
    throw options::error("apartments " + std::to_string(a.apartments) + ", views " +
                         std::to_string(a.views) + ", expected at least 1: nothing to render");
  }
  return a;
}

void writeImage(const fs::path& path, const cv::Mat& image) {
  if (!cv::imwrite(path.string(), image, {cv::IMWRITE_PNG_COMPRESSION, 1})) {
    throw std::runtime_error("cannot write '" + path.string() + "'");
  }
}

json describeInstances(const Apartment& apartment) {
  json instances = json::array();
  for (const Instance& instance : apartment.instances) {
    instances.push_back({{"id", instance.id},
                         {"phrase", instance.phrase},
                         {"color", instance.color_name},
                         {"room", instance.room}});
  }
  return instances;
}

/// Share of the view's pixels that show each room, by its phrase.
json describeRooms(const Apartment& apartment, const RenderedView& view) {
  json rooms = json::object();
  const auto total = static_cast<double>(view.labels.total());
  for (std::size_t i = 1; i < view.room_pixels.size(); ++i) {
    if (view.room_pixels[i] > 0) rooms[apartment.rooms[i - 1].phrase] = view.room_pixels[i] / total;
  }
  return rooms;
}

void writeView(const fs::path& stem, const RenderedView& view) {
  cv::Mat bgr(view.color.size(), CV_8UC3);
  cv::mixChannels({view.color}, {bgr}, {0, 2, 1, 1, 2, 0});
  writeImage(stem.string() + ".color.png", bgr);
  writeImage(stem.string() + ".labels.png", view.labels);
}

void renderApartment(const Arguments& a, int seed) {
  ApartmentConfig config;
  config.seed = seed;
  config.num_rooms = 5 + seed % 4;
  Apartment apartment = buildApartment(config);
  const auto bits = static_cast<std::uint64_t>(seed);
  if (a.surfaces == "training") varySurfaces(apartment, SurfaceSet::kTraining, bits);
  if (a.surfaces == "held_out") varySurfaces(apartment, SurfaceSet::kHeldOut, bits);
  const Renderer renderer(apartment, a.num_threads);
  const CameraModel camera = makeDefaultCamera(a.width_px, a.height_px);
  Random random(combineSeeds(bits, hashText("views")));
  json views = json::array();
  for (const Pose& T_world_camera : pickRandomViews(apartment, a.views, random)) {
    const RenderedView view = renderer.render(camera, T_world_camera);
    const std::string name = std::to_string(seed) + "_" + std::to_string(views.size());
    writeView(fs::path(a.output) / name, view);
    views.push_back({{"name", name}, {"rooms", describeRooms(apartment, view)}});
  }
  const json truth{{"seed", seed}, {"instances", describeInstances(apartment)}, {"views", views}};
  writeFileAtomically(fs::path(a.output) / (std::to_string(seed) + ".json"),
                      [&](std::ostream& out) { out << truth << '\n'; });
}

void renderAll(const Arguments& arguments) {
  fs::create_directories(arguments.output);
  for (int i = 0; i < arguments.apartments; ++i) {
    renderApartment(arguments, arguments.first_seed + i);
  }
  const auto count = [](int number, const char* what) {
    return formatCount(static_cast<std::size_t>(number), what);
  };
  std::cout << "[render_apartments] "
            << describeWritten(arguments.output, {{count(arguments.apartments, "apartment"),
                                                   count(arguments.views, "view") + " of each"}})
            << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runProgram("render_apartments", argc, argv, parseArguments, renderAll);
}
