// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/ros/message_conversions.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <boost/make_shared.hpp>
#include <boost/weak_ptr.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/image_conversions.h"

namespace tsg::ros_interface {
namespace {

template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

/// What a subscriber in another process gets.
template <typename Message>
boost::shared_ptr<const Message> sendOverTheWire(const Message& message) {
  const auto bytes = ::ros::serialization::serializeMessage(message);
  auto received = boost::make_shared<Message>();
  ::ros::serialization::deserializeMessage(bytes, *received);
  return received;
}

template <typename Message>
bool isSame(const Message& a, const Message& b) {
  const auto bytes_a = ::ros::serialization::serializeMessage(a);
  const auto bytes_b = ::ros::serialization::serializeMessage(b);
  return bytes_a.num_bytes == bytes_b.num_bytes &&
         std::equal(bytes_a.buf.get(), bytes_a.buf.get() + bytes_a.num_bytes, bytes_b.buf.get());
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double min, double max) {
    return std::uniform_real_distribution<double>(min, max)(engine_);
  }
  std::uint64_t integer(std::uint64_t min, std::uint64_t max) {
    return std::uniform_int_distribution<std::uint64_t>(min, max)(engine_);
  }
  Stamp stamp() { return {static_cast<std::int64_t>(integer(1, 4000000000ULL * 1000000000ULL))}; }
  Eigen::Vector3d vector() { return {number(-9, 9), number(-9, 9), number(-9, 9)}; }
  Embedding embedding(Eigen::Index size) {
    return Embedding::NullaryExpr(size, [this] { return static_cast<float>(number(-1, 1)); });
  }
  Mesh mesh() {
    Mesh mesh;
    const std::size_t num_vertices = integer(3, 20);
    for (std::size_t i = 0; i < num_vertices; ++i) {
      mesh.vertices.push_back(vector().cast<float>());
      mesh.colors.push_back({static_cast<std::uint8_t>(integer(0, 255)), 7, 8});
    }
    const auto index = [&] { return static_cast<std::uint32_t>(integer(0, num_vertices - 1)); };
    for (int i = 0; i < 5; ++i) mesh.triangles.push_back({index(), index(), index()});
    return mesh;
  }

 private:
  std::mt19937_64 engine_;
};

Segmentation makeSegmentation(Random& random) {
  Segmentation segmentation;
  segmentation.stamp = random.stamp();
  segmentation.labels = cv::Mat(6, 9, CV_16UC1);
  for (int v = 0; v < 6; ++v) {
    for (int u = 0; u < 9; ++u) {
      segmentation.labels.at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(random.integer(0, 4));
    }
  }
  segmentation.embeddings.resize(4, 7);
  for (int row = 0; row < 4; ++row) segmentation.embeddings.row(row) = random.embedding(7);
  segmentation.confidences = {0.1F, 0.2F, 0.3F, 0.4F};
  segmentation.image_embedding = random.embedding(7);
  return segmentation;
}

TEST(SegmentationConversion, SurvivesTheWire) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Segmentation sent = makeSegmentation(random);
    const auto received = fromMessage(sendOverTheWire(*toMessage(sent, "camera")), "/segmentation");
    EXPECT_EQ(received->stamp, sent.stamp);
    EXPECT_EQ(cv::norm(received->labels, sent.labels, cv::NORM_INF), 0.0);
    EXPECT_EQ(received->embeddings, sent.embeddings);
    EXPECT_EQ(received->confidences, sent.confidences);
    EXPECT_EQ(received->image_embedding, sent.image_embedding);
  }
}

TEST(SegmentationConversion, LabelsBorrowTheMessageAndKeepItAlive) {
  Random random(2);
  const Segmentation sent = makeSegmentation(random);
  msg::SegmentationConstPtr message = toMessage(sent, "camera");
  const auto received = fromMessage(message, "/segmentation");
  EXPECT_TRUE(isShared(received->labels, message->labels));
  const boost::weak_ptr<const msg::Segmentation> watch = message;
  message.reset();
  EXPECT_FALSE(watch.expired());
  EXPECT_EQ(cv::norm(received->labels, sent.labels, cv::NORM_INF), 0.0);
}

TEST(SegmentationConversion, EmptySegmentationIsAllowed) {
  Segmentation sent;
  sent.labels = cv::Mat::zeros(3, 4, CV_16UC1);
  const auto received = fromMessage(sendOverTheWire(*toMessage(sent, "camera")), "/segmentation");
  EXPECT_EQ(received->numSegments(), 0U);
  EXPECT_EQ(received->image_embedding.size(), 0);
}

TEST(SegmentationConversion, ErrorsNameTopicAndValues) {
  Random random(3);
  auto message = toMessage(makeSegmentation(random), "camera");
  message->embeddings.pop_back();
  const std::string sizes = messageOf([&] { fromMessage(message, "/my/segmentation"); });
  EXPECT_NE(sizes.find("/my/segmentation has 27 embedding values, expected 4 segments x 7"),
            std::string::npos)
      << sizes;
  message = toMessage(makeSegmentation(random), "camera");
  message->labels.encoding = "8UC2";
  const std::string type = messageOf([&] { fromMessage(message, "/my/segmentation"); });
  EXPECT_NE(type.find("expected CV_16UC1"), std::string::npos) << type;
}

TEST(TracksConversion, RoundTripGivesTheSameMessage) {
  Random random(4);
  TrackedFrame tracked;
  tracked.stamp = random.stamp();
  tracked.segment_tracks = {{5}, {0}, {7}};
  tracked.live = {{5}, {7}};
  for (std::uint64_t id = 1; id < 4; ++id) {
    Track track{{id}, random.stamp(), random.stamp(), random.embedding(id == 2 ? 0 : 5), {}, {}};
    track.views = {{random.stamp(), 3}, 1234, 2.5, 1.25, 0.5};
    for (int i = 0; i < 3; ++i) {
      track.observations.push_back({random.stamp(), static_cast<std::uint16_t>(i + 1)});
    }
    tracked.finished.push_back(track);
  }
  const auto message = sendOverTheWire(*toMessage(tracked, "camera"));
  const TrackedFrame received = fromMessage(*message);
  ASSERT_EQ(received.finished.size(), 3U);
  EXPECT_EQ(received.finished[2].id, tracked.finished[2].id);
  EXPECT_EQ(received.finished[2].embedding, tracked.finished[2].embedding);
  EXPECT_EQ(received.finished[1].embedding.size(), 0);
  EXPECT_EQ(received.finished[0].observations[1].stamp, tracked.finished[0].observations[1].stamp);
  EXPECT_EQ(received.finished[1].views.best.stamp, tracked.finished[1].views.best.stamp);
  EXPECT_EQ(received.finished[1].views.best.segment, 3);
  EXPECT_EQ(received.finished[1].views.best_pixels, 1234U);
  EXPECT_EQ(received.finished[1].views.mean_distance_m, 2.5);
  EXPECT_EQ(received.finished[1].views.min_distance_m, 1.25);
  EXPECT_EQ(received.finished[1].views.spread_rad, 0.5);
  EXPECT_EQ(received.segment_tracks, tracked.segment_tracks);
  EXPECT_TRUE(isSame(*message, *toMessage(received, "camera")));
}

ObjectPrimitivePtr makePrimitive(Random& random, std::uint64_t id) {
  auto primitive = std::make_shared<ObjectPrimitive>();
  primitive->id = {id};
  primitive->track = {id + 10};
  primitive->mesh = random.mesh();
  primitive->box = primitive->mesh.computeBounds();
  primitive->embedding = random.embedding(6);
  primitive->first_seen = random.stamp();
  primitive->last_seen = random.stamp();
  primitive->num_observations = 12;
  primitive->oriented_box = {random.vector(), {3, 1, 2}, random.number(-0.78, 0.78)};
  primitive->views = {{random.stamp(), 9}, 77, 1.5, 0.75, 0.25};
  if (id % 2 == 0) {
    primitive->thumbnail.image = cv::Mat(3, 5, CV_8UC3, cv::Scalar(random.number(0, 255), 2, 3));
  }
  return primitive;
}

TEST(PrimitiveConversion, SurvivesTheWire) {
  Random random(5);
  for (std::uint64_t id = 1; id <= 20; ++id) {
    const auto sent = makePrimitive(random, id);
    const auto received = fromMessage(*sendOverTheWire(toMessage(*sent)));
    EXPECT_EQ(received->id, sent->id);
    EXPECT_EQ(received->track, sent->track);
    EXPECT_EQ(received->mesh.vertices, sent->mesh.vertices);
    EXPECT_EQ(received->mesh.colors, sent->mesh.colors);
    EXPECT_EQ(received->mesh.triangles, sent->mesh.triangles);
    EXPECT_TRUE(received->box.isApprox(sent->box, 1e-12));
    EXPECT_EQ(received->embedding, sent->embedding);
    EXPECT_EQ(received->first_seen, sent->first_seen);
    EXPECT_EQ(received->last_seen, sent->last_seen);
    EXPECT_EQ(received->num_observations, sent->num_observations);
    EXPECT_EQ(received->oriented_box.center_m, sent->oriented_box.center_m);
    EXPECT_EQ(received->oriented_box.size_m, sent->oriented_box.size_m);
    EXPECT_NEAR(received->oriented_box.yaw_rad, sent->oriented_box.yaw_rad, 1e-12);
    EXPECT_EQ(received->views.best.stamp, sent->views.best.stamp);
    EXPECT_EQ(received->views.best_pixels, sent->views.best_pixels);
    ASSERT_EQ(received->thumbnail.image.size(), sent->thumbnail.image.size());
    if (id % 2 == 0) {
      EXPECT_EQ(cv::norm(received->thumbnail.image, sent->thumbnail.image, cv::NORM_INF), 0.0);
    }
  }
}

TEST(PrimitiveConversion, TriangleWithoutVertexIsAnError) {
  Random random(6);
  auto message = toMessage(*makePrimitive(random, 1));
  message.mesh.triangles[4] = 1000;
  const std::string error = messageOf([&] { fromMessage(message); });
  EXPECT_NE(error.find("vertex 1000"), std::string::npos) << error;
}

TEST(PrimitiveConversion, WhatIsBrokenIsNamedWithTheTopic) {
  Random random(8);
  const auto message =
      toMessage({makePrimitive(random, 1), makePrimitive(random, 7)}, {5}, "world");
  EXPECT_EQ(fromMessage(*message, "/my/objects").size(), 2U);
  auto bad_mesh = *message;
  bad_mesh.primitives[1].mesh.vertices.pop_back();
  auto bad_turn = *message;
  bad_turn.primitives[1].box.pose.orientation.w = std::nan("");
  auto far = *message;
  far.primitives[1].box.pose.position.x = 1e300;
  for (const auto& bad : {bad_mesh, bad_turn, far}) {
    const std::string error = messageOf([&] { fromMessage(bad, "/my/objects"); });
    EXPECT_NE(error.find("object primitive 7 on /my/objects"), std::string::npos) << error;
  }
}

TEST(PlaceConversion, PlacesThatAreNowhereAreNamedWithTheTopic) {
  msg::PlaceGraph good;
  good.places.resize(2);
  good.places[1].id = 9;
  EXPECT_EQ(fromMessage(good, "/my/places")->places.size(), 2U);
  auto nowhere = good;
  nowhere.places[1].position.y = std::nan("");
  auto boundless = good;
  boundless.places[1].clearance = std::numeric_limits<float>::infinity();
  auto far = good;
  far.places[1].position.z = -1e10;
  for (const auto& bad : {nowhere, boundless, far}) {
    const std::string error = messageOf([&] { fromMessage(bad, "/my/places"); });
    EXPECT_NE(error.find("place 9 on /my/places"), std::string::npos) << error;
  }
}

TEST(PlaceConversion, SharesEmbeddingsThatHaveNotChangedWithAFormerGraph) {
  Random random(9);
  PlaceGraph sent;
  for (std::uint64_t id = 1; id < 6; ++id) {
    sent.places.push_back({{id}, random.vector(), 0.5, random.embedding(id == 3 ? 0 : 4), 2});
  }
  const auto former = fromMessage(*toMessage(sent, "world"));
  sent.places[1].embedding = random.embedding(4);
  sent.places[3].embedding = Embedding();
  sent.places.erase(sent.places.begin());
  const auto now = fromMessage(*toMessage(sent, "world"), *former);
  ASSERT_EQ(now->places.size(), 4U);
  for (std::size_t i = 0; i < now->places.size(); ++i) {
    EXPECT_EQ(now->places[i].embedding, sent.places[i].embedding);
  }
  EXPECT_EQ(&*now->places[3].embedding, &*former->places[4].embedding);
  EXPECT_NE(&*now->places[0].embedding, &*former->places[1].embedding);
}

TEST(PlaceConversion, SurvivesTheWire) {
  Random random(7);
  PlaceGraph sent;
  sent.stamp = random.stamp();
  for (std::uint64_t id = 1; id < 6; ++id) {
    sent.places.push_back({{id}, random.vector(), 0.5, random.embedding(id == 3 ? 0 : 4), 2});
  }
  sent.edges = {{{1}, {2}, 0.25}, {{2}, {5}, 0.75}};
  const auto message = sendOverTheWire(*toMessage(sent, "world"));
  const auto received = fromMessage(*message);
  ASSERT_EQ(received->places.size(), 5U);
  EXPECT_EQ(received->places[4].position_m, sent.places[4].position_m);
  EXPECT_EQ(received->places[2].embedding.size(), 0);
  EXPECT_EQ(received->edges[1].b, sent.edges[1].b);
  EXPECT_EQ(received->edges[1].clearance_m, 0.75);
  EXPECT_TRUE(isSame(*message, *toMessage(*received, "world")));
}

TEST(GeometryConversion, StampsAreExact) {
  Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const Stamp stamp = random.stamp();
    EXPECT_EQ(toStamp(toRosTime(stamp)), stamp);
  }
  EXPECT_THROW(toRosTime({-1}), std::invalid_argument);
  ::ros::Time beyond;  // as it comes in a damaged message
  beyond.sec = beyond.nsec = 4294967295U;
  EXPECT_NO_THROW(toRosTime(toStamp(beyond)));
  EXPECT_THROW(toRosTime({(std::int64_t{1} << 32) * 1000000000}), std::invalid_argument);
}

TEST(GeometryConversion, PosesSurvive) {
  Random random(9);
  for (int i = 0; i < 100; ++i) {
    Pose pose = Pose::Identity();
    pose.rotate(Eigen::AngleAxisd(random.number(-3.1, 3.1), random.vector().normalized()));
    pose.pretranslate(random.vector());
    EXPECT_TRUE(toPose(toTransform(pose)).isApprox(pose, 1e-12));
  }
}

TEST(GeometryConversion, PoseWithoutRotationIsAnError) {
  geometry_msgs::Transform
      transform;  // the quaternion of a message that nobody filled is all zeros
  EXPECT_NE(messageOf([&] { toPose(transform); }).find("not a quaternion"), std::string::npos);
  transform.rotation.w = 1.0;
  transform.translation.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(messageOf([&] { toPose(transform); }).find("not finite"), std::string::npos);
}

TEST(GeometryConversion, RotatedBoxIsEnclosed) {
  msg::BoundingBox box = toBoundingBox(makeAabb({-1, -2, -3}, {1, 2, 3}));
  box.pose.orientation.w = std::sqrt(0.5);
  box.pose.orientation.z = std::sqrt(0.5);
  EXPECT_TRUE(toAabb(box).isApprox(makeAabb({-2, -1, -3}, {2, 1, 3}), 1e-12));
  EXPECT_TRUE(toAabb(toBoundingBox(Aabb())).isEmpty());
}

}  // namespace
}  // namespace tsg::ros_interface
