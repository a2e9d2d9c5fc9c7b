// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/rgbd_bag.h"

#include <sensor_msgs/CameraInfo.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <stdexcept>

#include "bag_set.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/pose_source.h"

namespace tsg::ros_interface {
namespace {

// A recorded segmentation may follow its image by as much as inference took.
constexpr double kSegmentationWait_s = 10.0;
// tf keeps everything: no recording is longer, and stamps plus this still fit ROS's 32 bits.
constexpr double kTfMemory_s = 2e8;

struct PendingFrame {
  AssembledFrame assembled;
  SegmentationPtr segmentation;
};

/// Topics of bags are absolute.
std::string toAbsolute(const std::string& topic) {
  return topic.empty() || topic.front() == '/' ? topic : "/" + topic;
}

}  // namespace

class RgbdBag::Implementation {
 public:
  Implementation(const std::vector<std::string>& paths, const InputConfig& config,
                 bool use_recorded_segmentation)
      : config_(withAbsoluteTopics(config)),
        bags_(paths),
        tf_(::ros::Duration(kTfMemory_s)),
        tf_history_(kTfMemory_s),
        poses_(config_, tf_, &tf_history_) {
    topics_.color = requireImages(config_.color_topic, "color");
    topics_.depth = requireImages(config_.depth_topic, "depth");
    topics_.camera_info = config_.camera_info_topic;
    if (config_.intrinsics.isEmpty()) {
      requireTopic(config_.camera_info_topic,
                   "; --camera-info-topic names another, --intrinsics "
                   "gives the numbers");
    }
    num_color_ = bags_.count(topics_.color);
    has_segmentation_ = use_recorded_segmentation && bags_.count(config_.segmentation_topic) > 0;
    if (has_segmentation_) {
      bags_.requireVersion<msg::Segmentation>(
          config_.segmentation_topic,
          ": it cannot be read. Record it anew, or let networks look at the images: --models with "
          "--ignore-recorded-segmentation");
    }
    readTransforms();
    if (poses_.usesTopic()) readPoses();
    startAssembler();
  }

  std::size_t numColorImages() const { return num_color_; }
  bool hasRecordedSegmentation() const { return has_segmentation_; }
  std::string segmentationTopic() const { return config_.segmentation_topic; }
  const std::map<std::string, Drops>& drops() const { return drops_; }
  const FrameAssembler::Counters& counters() const { return assembler_->counters(); }
  const FrameAssembler::FrameIds& frameIds() const { return assembler_->frameIds(); }

  std::vector<std::string> warnings() const {
    std::vector<std::string> texts;
    for (const auto& [key, text] : warnings_) texts.push_back(text);
    if (const std::string note = poses_.note(); !note.empty()) texts.push_back(note);
    return texts;
  }

  void forEachFrame(const OnFrame& on_frame, const std::function<void(std::size_t)>& on_progress) {
    drops_ = drops_at_start_;
    pending_.clear();
    segmentations_.clear();
    newest_ = {};
    startAssembler();
    std::vector<std::string> topics{topics_.color, topics_.depth, topics_.camera_info};
    if (has_segmentation_) topics.push_back(config_.segmentation_topic);
    std::size_t num_read = 0;
    bool goes_on = true;
    bags_.forEach(topics, [&](const BagMessage& message) {
      read(message, [&] { assemble(message); });
      if (message.getTopic() == topics_.color) on_progress(++num_read);
      goes_on = release(false, on_frame);
      return goes_on;
    });
    if (!goes_on) return;
    assembler_->flush();
    if (release(true, on_frame)) dropSegmentations({std::numeric_limits<std::int64_t>::max()});
  }

 private:
  static InputConfig withAbsoluteTopics(InputConfig config) {
    checkInput(config);
    for (auto* topic : {&config.color_topic, &config.depth_topic, &config.camera_info_topic,
                        &config.segmentation_topic, &config.pose_topic}) {
      *topic = toAbsolute(*topic);
    }
    return config;
  }

  void requireTopic(const std::string& topic, const std::string& remedy) {
    if (bags_.count(topic) > 0) return;
    throw std::runtime_error(bags_.name() + ": no messages on topic '" + topic + "'" + remedy +
                             ". Topics there are:" + bags_.listTopics());
  }

  /// The topic's name, or that of its compressed form.
  std::string requireImages(const std::string& topic, const std::string& option) {
    std::string found = topic;
    for (const char* ending : {"/compressedDepth", "/compressed"}) {
      if (bags_.count(topic) == 0 && bags_.count(topic + ending) > 0) found = topic + ending;
    }
    requireTopic(found, "; --" + option + "-topic names another");
    const std::string type = bags_.typeOf(found);
    if (type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage") return found;
    throw std::runtime_error(bags_.name() + ": topic '" + found + "' has type " + type +
                             ", expected sensor_msgs/Image or sensor_msgs/CompressedImage. Topics "
                             "there are:" +
                             bags_.listTopics());
  }

  /// /tf and /tf_static, or, where there are none, those of a robot's namespace.
  std::vector<std::string> findTransforms() {
    auto topics = bags_.findTopics({"tf2_msgs/TFMessage", "tf/tfMessage"});
    const auto is_global = [](const std::string& t) { return t == "/tf" || t == "/tf_static"; };
    if (std::any_of(topics.begin(), topics.end(), is_global)) topics = {"/tf", "/tf_static"};
    return topics;
  }

  void readTransforms() {
    const auto topics = findTransforms();
    if (topics.empty()) return;
    bags_.forEach(topics, [this](const BagMessage& message) {
      read(message, [&] {
        const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
        if (!transforms) return;
        const std::string& topic = message.getTopic();
        const bool is_static = topic.substr(topic.rfind('/')) == "/tf_static";
        for (const auto& transform : transforms->transforms) addTransform(transform, is_static);
      });
      return true;
    });
    drops_at_start_ = drops_;
  }

  void addTransform(const geometry_msgs::TransformStamped& transform, bool is_static) {
    if (!is_static) {
      checkStamp(transform.header.stamp, "/tf");
      tf_history_.add(transform);
    }
    tf_.setTransform(transform, "bag", is_static);
  }

  void readPoses() {
    requireTopic(config_.pose_topic, "; --pose-topic names another");
    bags_.forEach({config_.pose_topic}, [this](const BagMessage& message) {
      read(message, [&] { poses_.add(message); });
      return true;
    });
    drops_at_start_ = drops_;
  }

  /// One bad message is counted, the others are read.
  template <typename Action>
  void read(const BagMessage& message, const Action& action) {
    try {
      action();
    } catch (const InputError& e) {
      drop(e.reason(), std::string("ignored a message: ") + e.what(), 1);
    } catch (const std::exception& e) {
      drop("unreadable message",
           "a message on " + message.getTopic() + " recorded at " +
               std::to_string(message.getTime().toSec()) + " s cannot be read: " + e.what(),
           1);
    }
  }

  void startAssembler() {
    FrameAssembler::Callbacks callbacks;
    callbacks.on_frame = [this](AssembledFrame frame) { addFrame(std::move(frame)); };
    callbacks.on_drop = [this](const std::string& reason, const std::string& text,
                               std::uint64_t count) { drop(reason, text, count); };
    callbacks.on_warning = [this](const std::string& key, const std::string& text) {
      warnings_[key] = text;
    };
    callbacks.on_jump_back = [this] { newest_ = {}; };
    callbacks.on_image = [](bool, const void*) {};
    assembler_ = std::make_unique<FrameAssembler>(config_, topics_, std::move(callbacks));
    if (!config_.intrinsics.isEmpty()) return;
    // The first camera_info holds for the images before it, too.
    bags_.forEach({topics_.camera_info}, [this](const BagMessage& message) {
      sensor_msgs::CameraInfoConstPtr info;
      try {
        info = message.instantiate<sensor_msgs::CameraInfo>();
        if (info) checkCameraInfo(*info, topics_.camera_info);
      } catch (const std::exception&) {
        return true;  // counted when it is its turn
      }
      if (!info) return true;
      assembler_->addCameraInfo(info);
      return false;
    });
  }

  void assemble(const BagMessage& message) {
    const std::string& topic = message.getTopic();
    if (topic == topics_.color) {
      if (const auto image = toSource(message)) assembler_->addColor(*image);
    } else if (topic == topics_.depth) {
      if (const auto image = toSource(message)) assembler_->addDepth(*image);
    } else if (topic == topics_.camera_info) {
      if (auto info = message.instantiate<sensor_msgs::CameraInfo>()) {
        assembler_->addCameraInfo(info);
      }
    } else if (auto segmentation = message.instantiate<msg::Segmentation>()) {
      segmentations_[toStamp(segmentation->header.stamp).ns] =
          fromMessage(segmentation, config_.segmentation_topic);
    }
  }

  static std::optional<SourceImage> toSource(const BagMessage& message) {
    if (auto raw = message.instantiate<sensor_msgs::Image>()) return SourceImage(raw);
    if (auto compressed = message.instantiate<sensor_msgs::CompressedImage>()) {
      return SourceImage(compressed);
    }
    return std::nullopt;
  }

  void addFrame(AssembledFrame frame) {
    newest_ = std::max(newest_, frame.frame->stamp, [](Stamp a, Stamp b) { return a < b; });
    pending_.push_back({std::move(frame), nullptr});
  }

  /// Hands out the frames at the front for which nothing more can come. False: stop.
  bool release(bool is_end, const OnFrame& on_frame) {
    while (!pending_.empty()) {
      const Stamp stamp = pending_.front().assembled.frame->stamp;
      const auto segmentation = segmentations_.find(stamp.ns);
      const bool is_there = segmentation != segmentations_.end();
      const bool is_late = secondsBetween(stamp, newest_) > kSegmentationWait_s;
      if (has_segmentation_ && !is_there && !is_late && !is_end) return true;
      PendingFrame frame = pending_.front();
      pending_.pop_front();
      if (is_there) {
        frame.segmentation = segmentation->second;
        segmentations_.erase(segmentation);
      }
      dropSegmentations(stamp);
      if (!emit(frame, on_frame)) return false;
    }
    return true;
  }

  bool emit(const PendingFrame& pending, const OnFrame& on_frame) {
    RgbdFrame& frame = *pending.assembled.frame;
    const auto answer = poses_.lookUp(pending.assembled.camera_frame, frame.stamp);
    if (!answer.T_world_camera) {
      drop(answer.reason, "dropped a frame: " + answer.why_not, 1);
      return true;
    }
    frame.T_world_camera = *answer.T_world_camera;
    try {
      frame.validate();
    } catch (const std::exception& e) {
      drop("unusable images", std::string("dropped a frame: ") + e.what(), 1);
      return true;
    }
    return on_frame(pending.assembled.frame, pending.segmentation);
  }

  /// Those before `end` have no frame, and none will come.
  void dropSegmentations(Stamp end) {
    while (!segmentations_.empty() && segmentations_.begin()->first < end.ns) {
      const Stamp stamp{segmentations_.begin()->first};
      drop("segmentation without a frame",
           "no frame has the stamp of a segmentation on " + config_.segmentation_topic + ", " +
               std::to_string(stamp.seconds()) + " s",
           1);
      segmentations_.erase(segmentations_.begin());
    }
  }

  void drop(const std::string& reason, const std::string& example, std::uint64_t count) {
    if (count == 0) return;
    auto& drops = drops_[reason];
    if (drops.example.empty()) drops.example = example;
    drops.count += count;
  }

  const InputConfig config_;
  BagSet bags_;
  tf2::BufferCore tf_;
  TransformHistory tf_history_;
  PoseSource poses_;
  InputTopics topics_;
  std::size_t num_color_ = 0;
  bool has_segmentation_ = false;
  std::unique_ptr<FrameAssembler> assembler_;
  std::deque<PendingFrame> pending_;
  std::map<std::int64_t, SegmentationPtr> segmentations_;  ///< by stamp, ns
  Stamp newest_;                                           ///< of all frames assembled
  std::map<std::string, Drops> drops_;
  std::map<std::string, Drops> drops_at_start_;  ///< of tf and poses
  std::map<std::string, std::string> warnings_;
};

RgbdBag::RgbdBag(const std::vector<std::string>& paths, const InputConfig& config,
                 bool use_recorded_segmentation)
    : implementation_(std::make_unique<Implementation>(paths, config, use_recorded_segmentation)) {}
RgbdBag::~RgbdBag() = default;
std::size_t RgbdBag::numColorImages() const { return implementation_->numColorImages(); }
bool RgbdBag::hasRecordedSegmentation() const { return implementation_->hasRecordedSegmentation(); }
std::string RgbdBag::segmentationTopic() const { return implementation_->segmentationTopic(); }
void RgbdBag::forEachFrame(const OnFrame& on_frame,
                           const std::function<void(std::size_t)>& on_progress) {
  implementation_->forEachFrame(on_frame, on_progress);
}
const std::map<std::string, RgbdBag::Drops>& RgbdBag::drops() const {
  return implementation_->drops();
}
std::vector<std::string> RgbdBag::warnings() const { return implementation_->warnings(); }
const FrameAssembler::Counters& RgbdBag::counters() const { return implementation_->counters(); }
const FrameAssembler::FrameIds& RgbdBag::frameIds() const { return implementation_->frameIds(); }

}  // namespace tsg::ros_interface
