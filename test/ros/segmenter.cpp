// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <sstream>

#include "../unit/segmentation/networks.h"
#include "support.h"
#include "synthetic_robot.h"

namespace tsg::test {
namespace {

/// The small segmenter (red, green and blue regions) and the small encoder (mean colour).
void writeModelSet(const std::string& path, const std::string& segmenter) {
  std::ofstream file(path);
  file << "name: small\nsegmenter: " << segmentation::findNetwork(segmenter)
       << "\nsegmenter_score_threshold: 0.25\nsegmenter_iou_threshold: 0.99\n"
       << "segmenter_input_size_px: 64\nimage_encoder: " << segmentation::findNetwork("encoder")
       << "\nimage_encoder_input_size_px: 8\ntext_encoder: ''\ntokenizer: ''\nembedding_size: 4\n"
       << "image_mean: [0.5, 0.4, 0.3]\nimage_std: [0.2, 0.3, 0.4]\nalpha: 0.2\n";
}

sensor_msgs::ImagePtr makeImage(double stamp_s) {
  cv::Mat image(48, 64, CV_8UC3, cv::Scalar(20, 20, 20));
  image(cv::Rect(8, 8, 20, 24)).setTo(cv::Scalar(230, 10, 10));
  return ros_interface::toImageMessage(image, "rgb8", Stamp::fromSeconds(stamp_s), "camera");
}

class SegmenterNodelet : public ::testing::Test {
 protected:
  void startSegmenter(const std::string& network) {
    const std::string path = (folder_.path() / "models.yaml").string();
    writeModelSet(path, network);
    ros::param::set("/segmenter/models", path);
    ASSERT_TRUE(load(loader_, "segmenter", "Segmenter"));
    images_ = ros::NodeHandle().advertise<sensor_msgs::Image>("camera/color/image_raw", 100);
    ASSERT_TRUE(waitUntil([&] { return images_.getNumSubscribers() > 0; }));
    ASSERT_TRUE(segmentations_.waitForPublisher());
  }
  bool waitForSegmentation(const sensor_msgs::Image& image) {
    return segmentations_.waitFor([&](const msg::Segmentation& message) {
      return message.header.stamp == image.header.stamp;
    });
  }

  TemporaryFolder folder_;
  Recorder<msg::Segmentation> segmentations_{"segmentation"};
  Recorder<diagnostic_msgs::DiagnosticArray> diagnostics_{"/diagnostics"};
  nodelet::Loader loader_{false};
  ros::Publisher images_;
};

TEST_F(SegmenterNodelet, SegmentsTheMessageItselfAndKeepsStampAndFrame) {
  TSG_REQUIRE_ENGINE();
  ASSERT_NO_FATAL_FAILURE(startSegmenter("segmenter"));
  const auto image = makeImage(5.0);
  images_.publish(sensor_msgs::ImageConstPtr(image));
  ASSERT_TRUE(waitForSegmentation(*image));
  const auto message = segmentations_.messages().back();
  EXPECT_EQ(message->header.frame_id, "camera");
  EXPECT_EQ(message->labels.width, 64U);
  EXPECT_EQ(message->embedding_size, 4U);
  EXPECT_EQ(message->image_embedding.size(), 4U);
  EXPECT_GT(message->confidences.size(), 0U);
  std::ostringstream expected;
  expected << static_cast<const void*>(image->data.data());
  EXPECT_TRUE(waitUntil([&] {
    auto lines = findDiagnostics(diagnostics_, "segmenter");
    return lines["pixels of the last image"] == expected.str() && lines["images copied"] == "0";
  }));
}

TEST_F(SegmenterNodelet, APictureIsEmbeddedAsTheBoxAroundASegmentIs) {
  TSG_REQUIRE_ENGINE();
  ASSERT_NO_FATAL_FAILURE(startSegmenter("segmenter"));
  ASSERT_TRUE(ros::service::waitForService("/segmenter/embed_image", ros::Duration(30.0)));
  const auto embed = [](const sensor_msgs::Image& image) {
    msg::EmbedImage call;
    call.request.image = image;
    EXPECT_TRUE(ros::service::call("/segmenter/embed_image", call));
    return call.response;
  };
  const auto image = makeImage(5.0);
  const auto picture = embed(*image);
  EXPECT_TRUE(picture.success) << picture.message;
  images_.publish(sensor_msgs::ImageConstPtr(image));
  ASSERT_TRUE(waitForSegmentation(*image));
  const auto whole = segmentations_.messages().back()->image_embedding;
  ASSERT_EQ(picture.embedding.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_NEAR(picture.embedding[i], whole[i], 1e-5F);
  }
  sensor_msgs::Image broken = *image;
  broken.data.resize(10);
  EXPECT_FALSE(embed(broken).success);
  EXPECT_FALSE(embed({}).success);
  EXPECT_FALSE(embed({}).message.empty());
}

TEST_F(SegmenterNodelet, AnOverlayIsDrawnForThoseWhoSubscribe) {
  TSG_REQUIRE_ENGINE();
  Recorder<sensor_msgs::Image> overlays("segmentation_overlay");
  ASSERT_NO_FATAL_FAILURE(startSegmenter("segmenter"));
  ASSERT_TRUE(overlays.waitForPublisher());
  const auto image = makeImage(7.0);
  images_.publish(sensor_msgs::ImageConstPtr(image));
  ASSERT_TRUE(overlays.waitFor([&](const sensor_msgs::Image& message) {
    return message.header.stamp == image->header.stamp;
  }));
  const auto overlay = overlays.messages().back();
  EXPECT_EQ(overlay->header.frame_id, "camera");
  EXPECT_EQ(overlay->encoding, "rgb8");
  ASSERT_EQ(overlay->data.size(), image->data.size());
  const auto pixel = [](const sensor_msgs::Image& message, std::size_t u, std::size_t v) {
    const std::size_t i = v * message.step + 3 * u;
    return std::vector<int>(message.data.begin() + static_cast<std::ptrdiff_t>(i),
                            message.data.begin() + static_cast<std::ptrdiff_t>(i) + 3);
  };
  EXPECT_EQ(pixel(*overlay, 60, 44), pixel(*image, 60, 44));  // no segment
  EXPECT_NE(pixel(*overlay, 18, 20), pixel(*image, 18, 20));  // inside the red one
}

TEST_F(SegmenterNodelet, NewestImageWinsAndDropsAreCounted) {
  TSG_REQUIRE_ENGINE();
  ASSERT_NO_FATAL_FAILURE(startSegmenter("segmenter"));
  constexpr int kNumImages = 200;
  sensor_msgs::ImagePtr last;
  for (int i = 0; i < kNumImages; ++i) {
    last = makeImage(10.0 + i);
    images_.publish(sensor_msgs::ImageConstPtr(last));
  }
  ASSERT_TRUE(waitForSegmentation(*last));
  EXPECT_LT(segmentations_.messages().size(), static_cast<std::size_t>(kNumImages));
  // What was not segmented was dropped in the subscriber's queue of one image or by the stage.
  ASSERT_TRUE(waitUntil([&] {
    auto lines = findDiagnostics(diagnostics_, "segmenter");
    const auto number = [&](const std::string& key) {
      return lines.count(key) > 0 ? std::stoi(lines[key]) : 0;
    };
    return number("inputs") > 0 &&
           number("inputs") == number("processed") + number("dropped: a newer image came");
  }));
}

TEST_F(SegmenterNodelet, WrongEncodingIsNamedAndTheStageLivesOn) {
  TSG_REQUIRE_ENGINE();
  Recorder<rosgraph_msgs::Log> log("/rosout");
  ASSERT_TRUE(log.waitForPublisher());
  ASSERT_NO_FATAL_FAILURE(startSegmenter("segmenter"));
  const auto bad = makeImage(1000.0);
  bad->encoding = "yuv422";
  images_.publish(sensor_msgs::ImageConstPtr(bad));
  EXPECT_TRUE(waitForLog(log, {"/camera/color/image_raw has encoding 'yuv422'"}));
  const auto good = makeImage(1001.0);
  images_.publish(sensor_msgs::ImageConstPtr(good));
  EXPECT_TRUE(waitForSegmentation(*good));
}

}  // namespace
}  // namespace tsg::test

int main(int argc, char** argv) { return tsg::test::runRosTests(argc, argv, "segmenter_test"); }
