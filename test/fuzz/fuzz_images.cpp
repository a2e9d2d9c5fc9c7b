// SPDX-License-Identifier: BSD-3-Clause
// Raw and compressed images, as colour and as depth.
#include "fuzzer.h"
#include "message_mutator.h"
#include "records.h"
#include "sample_messages.h"
#include "task_scene_graph/ros/image_conversions.h"
#include "task_scene_graph/ros/source_image.h"

namespace {

namespace fuzz = tsg::fuzz;
namespace ros_interface = tsg::ros_interface;

std::string makeRaw(fuzz::Mutator& mutator) {
  static const std::vector<sensor_msgs::Image> corpus{
      fuzz::makeImage("rgb8", fuzz::makeColor()),
      fuzz::makeImage("bgr8", fuzz::makeColor()),
      fuzz::makeImage("mono8", cv::Mat::ones(fuzz::kHeight, fuzz::kWidth, CV_8UC1)),
      fuzz::makeImage("rgba8", cv::Mat::ones(fuzz::kHeight, fuzz::kWidth, CV_8UC4)),
      fuzz::makeImage("16UC1", fuzz::makeDepth()),
      fuzz::makeImage("32FC1", cv::Mat::ones(fuzz::kHeight, fuzz::kWidth, CV_32FC1))};
  return fuzz::makeMutated(mutator, mutator.pickFrom(corpus));
}

std::string makeCompressed(fuzz::Mutator& mutator) {
  const auto png = fuzz::encodeImage(".png", fuzz::makeDepth());
  static const std::vector<sensor_msgs::CompressedImage> corpus{
      fuzz::makeCompressed("rgb8; jpeg compressed bgr8",
                           fuzz::encodeImage(".jpg", fuzz::makeColor())),
      fuzz::makeCompressed("png", fuzz::encodeImage(".png", fuzz::makeColor())),
      fuzz::makeCompressed("16UC1; png compressed", png),
      fuzz::makeCompressed("16UC1; compressedDepth png", png, 12),
      fuzz::makeCompressed("32FC1; compressedDepth png", png, 12),
      fuzz::makeCompressed("16UC1; compressedDepth rvl", fuzz::makeRvl(), 12)};
  auto message = mutator.pickFrom(corpus);
  if (!mutator.isOneIn(3)) {
    std::string bytes(message.data.begin(), message.data.end());
    mutator.mutateBytes({}, bytes);
    message.data.assign(bytes.begin(), bytes.end());
  }
  if (mutator.isOneIn(3)) fuzz::mutateMessage(mutator, message);
  return fuzz::toBytes(message);
}

std::string make(fuzz::Mutator& mutator) {
  if (mutator.isOneIn(3)) return fuzz::joinRecords({{'r', makeRaw(mutator)}});
  return fuzz::joinRecords({{'c', makeCompressed(mutator)}});
}

ros_interface::SourceImage toSource(char type, const std::string& bytes) {
  if (type == 'r') return ros_interface::SourceImage(fuzz::fromBytes<sensor_msgs::Image>(bytes));
  return ros_interface::SourceImage(fuzz::fromBytes<sensor_msgs::CompressedImage>(bytes));
}

/// Every pixel can be read. Each form of use may refuse it.
void readInput(const std::string& input) {
  for (const auto& [type, bytes] : fuzz::splitRecords(input)) {
    const auto source = toSource(type, bytes);
    const auto message = source.decode("/camera/image");
    const bool is_color = message->encoding.find('8') != std::string::npos;
    const cv::Mat image = is_color ? ros_interface::toColorImage(message, "/camera/image").image
                                   : ros_interface::toDepthImage(message, "/camera/image").image;
    cv::sum(image);
    ros_interface::checkStamp(source.header().stamp, "/camera/image");
  }
}

}  // namespace

int main(int argc, char** argv) {
  return fuzz::runFuzzer(argc, argv, {"images", "/camera/image", make, readInput});
}
