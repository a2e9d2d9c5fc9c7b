// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <boost/make_shared.hpp>
#include <cstdint>
#include <pluginlib/class_list_macros.hpp>

#include "segmenter_config.h"
#include "stage_nodelet.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/image_subscriber.h"
#include "task_scene_graph/ros/message_conversions.h"
#include "task_scene_graph/ros/stamp_order.h"
#include "task_scene_graph/ros/topic_watch.h"
#include "task_scene_graph/ros/worker.h"
#include "task_scene_graph/segmentation/overlay.h"
#include "task_scene_graph/segmentation/segmenter.h"

namespace tsg::nodelets {

/// input/color_topic -> input/segmentation_topic and, while somebody looks at it,
/// `segmentation_overlay`. Always works on the newest image there is.
class SegmenterNodelet : public StageNodelet {
 public:
  ~SegmenterNodelet() override {
    stopCallbacks();
    if (segmenter_ != nullptr) segmenter_->cancel();
  }

 private:
  struct Item {
    ros_interface::SourceImage image;
    std::uint32_t epoch = 1;
  };

  void start() override;
  void check() override;
  msg::FlushResponse flush(const msg::FlushRequest& request,
                           const ros_interface::Patience& patience) override;
  std::string reset() override;

  void onImage(const ros_interface::SourceImage& image);
  void process(const Item& item);
  bool serveEmbed(msg::EmbedImageRequest& request, msg::EmbedImageResponse& response);
  void publishOverlay(const ColorImage& color, const Segmentation& segmentation,
                      const std::string& frame);

  std::unique_ptr<segmentation::Segmenter> segmenter_;
  ros_interface::StampOrder order_;
  std::atomic<std::uint32_t> epoch_{1};     ///< raised when stamps jump back
  std::atomic<std::uint64_t> sequence_{0};  ///< of the newest message
  ros::Publisher publisher_;
  ros::Publisher overlay_publisher_;
  ros::ServiceServer embed_server_;
  std::unique_ptr<ros_interface::TopicWatch> watch_;
  std::unique_ptr<ros_interface::Worker<Item>> worker_;
  std::unique_ptr<ros_interface::ImageSubscriber> subscriber_;
};

void SegmenterNodelet::start() {
  const auto config = loadConfig<SegmenterNodeletConfig>();
  if (config.models.empty()) {
    throw std::runtime_error(
        "parameter '" + getPrivateNodeHandle().resolveName("models") +
        "' is not set: it names the YAML file of a model set (launch argument models:=...). The "
        "README says where models come from and how to export them. A bag that holds a recorded "
        "segmentation needs none: recorded_segmentation:=true");
  }
  segmenter_ = std::make_unique<segmentation::Segmenter>(
      segmentation::loadModelSet(config.models.string()), config.segmenter);
  publisher_ = topicHandle().advertise<msg::Segmentation>(config.input.segmentation_topic, 100);
  overlay_publisher_ = topicHandle().advertise<sensor_msgs::Image>("segmentation_overlay", 2);
  embed_server_ =
      serviceHandle().advertiseService("embed_image", &SegmenterNodelet::serveEmbed, this);
  worker_ =
      std::make_unique<ros_interface::Worker<Item>>(1, [this](const Item& item) { process(item); });
  watch_ = std::make_unique<ros_interface::TopicWatch>(report(), config.input.patience_s);
  subscriber_ = std::make_unique<ros_interface::ImageSubscriber>(
      topicHandle(), config.input.color_topic, 1,
      [this](const ros_interface::SourceImage& image) { onImage(image); });
  watch_->add(subscriber_->subscriber(), config.input.color_topic, "sensor_msgs/Image");
}

void SegmenterNodelet::onImage(const ros_interface::SourceImage& image) {
  watch_->noteMessage(0);
  if (isPaused()) return;
  report().countInput();
  try {
    ros_interface::checkStamp(image.header().stamp, subscriber_->topic());
  } catch (const ros_interface::InputError& e) {
    report().countDropped(e.reason(), std::string("dropped an image: ") + e.what());
    return;
  }
  const auto kind = order_.update(image.stamp());
  if (kind == ros_interface::StampOrder::Kind::kDuplicate) {
    report().countDropped("repeated stamp");
    return;
  }
  if (kind == ros_interface::StampOrder::Kind::kJumpBack) ++epoch_;
  report().countDropped("a newer image came", "", worker_->push({image, epoch_}));
}

void SegmenterNodelet::process(const Item& item) {
  const ros_interface::SourceImage& image = item.image;
  try {
    const ros_interface::StageTimer timer;
    const auto message = image.decode(subscriber_->topic());
    ColorImage color = ros_interface::toColorImage(message, subscriber_->topic());
    color.stamp = image.stamp();
    const bool is_shared = !image.isCompressed() && ros_interface::isShared(color.image, *message);
    report().countImage(is_shared, color.image.data);
    const Segmentation segmentation = segmenter_->segment(color);
    const msg::SegmentationPtr result =
        ros_interface::toMessage(segmentation, message->header.frame_id);
    result->sequence = ++sequence_;
    result->epoch = item.epoch;
    publisher_.publish(result);
    report().countProcessed(timer.elapsedMs());
    publishOverlay(color, segmentation, message->header.frame_id);
  } catch (const std::exception& e) {
    report().countDropped("error", std::string("dropped an image: ") + e.what());
  }
}

bool SegmenterNodelet::serveEmbed(msg::EmbedImageRequest& request,
                                  msg::EmbedImageResponse& response) {
  try {
    const auto image = boost::make_shared<sensor_msgs::Image>(request.image);
    const ColorImage color = ros_interface::toColorImage(image, "embed_image");
    response.embedding = ros_interface::toFloats(segmenter_->embed(color));
    response.success = 1;
  } catch (const std::exception& e) {
    response.message = e.what();
  }
  return true;
}

void SegmenterNodelet::publishOverlay(const ColorImage& color, const Segmentation& segmentation,
                                      const std::string& frame) {
  if (overlay_publisher_.getNumSubscribers() == 0) return;
  const bool is_rgb = color.order == ColorOrder::kRgb;
  overlay_publisher_.publish(ros_interface::toImageMessage(
      segmentation::drawSegments(color.image, segmentation.labels, color.order),
      is_rgb ? "rgb8" : "bgr8", color.stamp, frame));
}

void SegmenterNodelet::check() {
  if (watch_->numMessages(0) == 0) {
    const std::string change = subscriber_->switchToCompressed();
    if (!change.empty()) {
      report().warn(change, change);
      watch_->replace(0, subscriber_->subscriber());
    }
  }
  watch_->check();
}

msg::FlushResponse SegmenterNodelet::flush(const msg::FlushRequest&,
                                           const ros_interface::Patience& patience) {
  msg::FlushResponse response;
  if (!worker_->waitHandled(patience)) response.missing.push_back("an image is still segmented");
  response.sequence = sequence_;
  response.content = std::to_string(sequence_) + " images segmented";
  return response;
}

std::string SegmenterNodelet::reset() { return "it keeps nothing"; }

}  // namespace tsg::nodelets

PLUGINLIB_EXPORT_CLASS(tsg::nodelets::SegmenterNodelet, nodelet::Nodelet)
