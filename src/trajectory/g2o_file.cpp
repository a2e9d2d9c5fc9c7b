// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/trajectory/g2o_file.h"

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace tsg::trajectory {
namespace {

constexpr double kMinQuaternionNorm = 1e-6;

/// Words of a line, one after the other.
class Line {
 public:
  explicit Line(const std::string& text) : stream_(text.substr(0, text.find('#'))) {}

  std::string readWord() {
    std::string word;
    stream_ >> word;
    return word;
  }
  KeyframeId readId() {
    const std::string word = readWord();
    const bool is_number = !word.empty() && word.size() < 19 &&
                           word.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number) throw std::invalid_argument("'" + word + "' is no id, expected 0, 1, 2, ...");
    return {std::stoull(word) + 1};
  }
  double readNumber() {
    const std::string word = readWord();
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0') {
      throw std::invalid_argument("'" + word + "' where a number was expected");
    }
    return value;
  }
  Pose readPose() {
    std::array<double, 7> v{};
    for (double& value : v) value = readNumber();
    const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    if (rotation.norm() < kMinQuaternionNorm) {
      throw std::invalid_argument("the quaternion has no length");
    }
    Pose pose = Pose::Identity();
    pose.linear() = rotation.normalized().toRotationMatrix();
    pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    return pose;
  }
  Matrix6d readInformation() {
    Matrix6d information;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        const double scale = (row < 3 ? 1.0 : 0.5) * (column < 3 ? 1.0 : 0.5);
        information(row, column) = information(column, row) = scale * readNumber();
      }
    }
    return information;
  }
  void requireEnd() {
    const std::string word = readWord();
    if (!word.empty()) throw std::invalid_argument("'" + word + "' where the line should end");
  }

 private:
  std::istringstream stream_;
};

PoseEdge readEdge(Line& line) {
  PoseEdge edge;
  edge.a = line.readId();
  edge.b = line.readId();
  edge.T_a_b = line.readPose();
  edge.information = line.readInformation();
  edge.kind = edge.b.value == edge.a.value + 1 ? EdgeKind::kOdometry : EdgeKind::kLoop;
  return edge;
}

/// Edges may stand before their vertices.
void readLine(const std::string& text, PoseGraph& graph, std::vector<PoseEdge>& edges) {
  Line line(text);
  const std::string kind = line.readWord();
  if (kind.empty()) return;
  if (kind == "VERTEX_SE3:QUAT") {
    const KeyframeId id = line.readId();
    graph.addKeyframe(id, line.readPose());
  } else if (kind == "EDGE_SE3:QUAT") {
    edges.push_back(readEdge(line));
  } else if (kind == "FIX") {
    line.readId();
  } else {
    throw std::invalid_argument("'" + kind +
                                "' is not known, expected VERTEX_SE3:QUAT, "
                                "EDGE_SE3:QUAT or FIX");
  }
  line.requireEnd();
}

}  // namespace

PoseGraph loadG2o(const std::string& path, const PoseGraphConfig& config) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("pose graph '" + path + "' cannot be opened");
  PoseGraph graph(config);
  std::vector<PoseEdge> edges;
  std::vector<int> lines;
  int line = 0;
  try {
    for (std::string text; std::getline(file, text);) {
      ++line;
      readLine(text, graph, edges);
      lines.resize(edges.size(), line);
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
      line = lines[i];
      graph.addEdge(edges[i]);
    }
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("pose graph '" + path + "', line " + std::to_string(line) + ": " +
                             error.what());
  }
  if (graph.keyframes().empty()) {
    throw std::runtime_error("pose graph '" + path + "' holds no VERTEX_SE3:QUAT");
  }
  return graph;
}

}  // namespace tsg::trajectory
