// SPDX-License-Identifier: BSD-3-Clause
#include "bag_set.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "bag_records.h"

namespace tsg::ros_interface {
namespace {

constexpr auto kMagic = "#ROSBAG V2.0";

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("cannot read bag '" + path + "': " + what);
}

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

/// What the first bytes say, before a library fails on them.
void checkFile(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) fail(path, "there is no such file");
  if (fs::is_directory(status)) {
    fail(path, fs::exists(fs::path(path) / "metadata.yaml")
                   ? "it is a bag of ROS 2; convert it with rosbags-convert (PyPI: rosbags)"
                   : "it is a folder; expected a file (several may be given; for folders of images "
                     "see scripts/dataset_to_bag)");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "it cannot be opened (permissions?)");
  std::string head(16, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  if (head.empty()) fail(path, "the file is empty");
  if (startsWith(head, kMagic)) return;
  if (startsWith(head, "SQLite format 3") || startsWith(head, "\x89MCAP")) {
    fail(path, "it is a bag of ROS 2; convert it with rosbags-convert (PyPI: rosbags)");
  }
  if (startsWith(head, "#ROSBAG V1") || startsWith(head, "#ROSRECORD")) {
    fail(path, "its format is from before 2010; convert it with 'rosbag fix'");
  }
  if (startsWith(head, "\x1f\x8b") || startsWith(head, "BZh") || startsWith(head, "PK")) {
    fail(path, "it is a compressed archive; unpack it first");
  }
  fail(path, "it is no rosbag (it does not begin with '" + std::string(kMagic) + "')");
}

std::unique_ptr<rosbag::Bag> open(const std::string& path) {
  checkFile(path);
  try {
    checkBagRecords(path);
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    fail(path, "it was not closed (the recorder was killed); run 'rosbag reindex " + path + "'");
  } catch (const std::exception& e) {
    fail(path, "it is cut short or damaged; run 'rosbag reindex " + path + "' (" + e.what() + ")");
  }
}

}  // namespace

BagSet::BagSet(const std::vector<std::string>& paths) {
  for (const auto& path : paths) {
    bags_.push_back(open(path));
    name_ += (name_.empty() ? "'" : ", '") + path + "'";
  }
  if (paths.empty()) throw std::runtime_error("no bag is given");
  name_ = (paths.size() == 1 ? "bag " : "bags ") + name_;
}

void BagSet::addTo(rosbag::View& view, const std::vector<std::string>& topics) {
  for (const auto& bag : bags_) view.addQuery(*bag, rosbag::TopicQuery(topics));
}

void BagSet::forEach(const std::vector<std::string>& topics, const OnMessage& on_message) {
  rosbag::View view;
  addTo(view, topics);
  for (const rosbag::MessageInstance& message : view) {
    if (!on_message(BagMessage(message))) return;
  }
}

std::size_t BagSet::count(const std::string& topic) {
  rosbag::View view;
  addTo(view, {topic});
  return view.size();
}

std::string BagSet::typeOf(const std::string& topic) {
  rosbag::View view;
  addTo(view, {topic});
  const auto connections = view.getConnections();
  return connections.empty() ? "" : connections.front()->datatype;
}

void BagSet::requireVersion(const std::string& topic, const std::string& type,
                            const std::string& md5, const std::string& remedy) {
  rosbag::View view;
  addTo(view, {topic});
  for (const auto* connection : view.getConnections()) {
    if (connection->datatype == type && connection->md5sum == md5) continue;
    const bool is_other_type = connection->datatype != type;
    throw std::runtime_error(
        name_ + ": topic '" + topic + "' holds " + connection->datatype +
        (is_other_type ? "" : " of another version (md5 " + connection->md5sum + ")") +
        ", expected " + type + (is_other_type ? "" : " (md5 " + md5 + ")") + remedy);
  }
}

std::map<std::string, std::string> BagSet::mapTypes() {
  rosbag::View view;
  for (const auto& bag : bags_) view.addQuery(*bag);
  std::map<std::string, std::string> types;
  for (const auto* connection : view.getConnections()) {
    types[connection->topic] = connection->datatype;
  }
  return types;
}

std::vector<std::string> BagSet::findTopics(const std::vector<std::string>& types) {
  std::vector<std::string> topics;
  for (const auto& [topic, type] : mapTypes()) {
    if (std::find(types.begin(), types.end(), type) != types.end()) topics.push_back(topic);
  }
  return topics;
}

std::string BagSet::listTopics() {
  std::string text;
  for (const auto& [topic, type] : mapTypes()) text += "\n  " + topic + " (" + type + ")";
  return text;
}

}  // namespace tsg::ros_interface
