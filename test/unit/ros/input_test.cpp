// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "task_scene_graph/ros/arrivals.h"
#include "task_scene_graph/ros/geometry_conversions.h"
#include "task_scene_graph/ros/parameters.h"
#include "task_scene_graph/ros/pose_waiter.h"
#include "task_scene_graph/ros/stage_report.h"
#include "task_scene_graph/ros/stamp_order.h"
#include "task_scene_graph/ros/worker.h"

namespace tsg::ros_interface {
namespace {

using std::chrono::seconds;
using std::chrono::steady_clock;

steady_clock::time_point deadline() { return steady_clock::now() + seconds(30); }

/// Lets a test hold a worker inside its handler.
class Gate {
 public:
  void open() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock<std::mutex> lock(mutex_);
    ++num_waiting_;
    changed_.notify_all();
    changed_.wait_until(lock, deadline(), [this] { return is_open_; });
  }
  bool waitForSomebody() {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_until(lock, deadline(), [this] { return num_waiting_ > 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_open_ = false;
  int num_waiting_ = 0;
};

TEST(Worker, HandlesItemsInOrder) {
  std::vector<int> handled;
  Worker<int> worker(100, [&](int item) { handled.push_back(item); });
  for (int i = 0; i < 50; ++i) EXPECT_EQ(worker.push(i), 0U);
  ASSERT_TRUE(worker.waitIdle(deadline()));
  ASSERT_EQ(handled.size(), 50U);
  EXPECT_TRUE(std::is_sorted(handled.begin(), handled.end()));
}

TEST(Worker, FullQueueDropsItsOldestItem) {
  Gate gate;
  std::vector<int> handled;
  std::vector<int> dropped_items;
  Worker<int> worker(
      2,
      [&](int item) {
        if (item == 0) gate.pass();
        handled.push_back(item);
      },
      [&](int item) { dropped_items.push_back(item); });
  worker.push(0);
  ASSERT_TRUE(gate.waitForSomebody());
  std::size_t dropped = 0;
  for (int i = 1; i <= 5; ++i) dropped += worker.push(i);
  gate.open();
  ASSERT_TRUE(worker.waitIdle(deadline()));
  EXPECT_EQ(dropped, 3U);
  EXPECT_EQ(dropped_items, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(handled, (std::vector<int>{0, 4, 5}));
}

TEST(Worker, OrdersNeverDropAndKeepTheirPlaceAmongItems) {
  Gate gate;
  std::vector<int> handled;
  Worker<int> worker(2, [&](int item) {
    if (item == 0) gate.pass();
    handled.push_back(item);
  });
  worker.push(0);
  ASSERT_TRUE(gate.waitForSomebody());
  std::size_t dropped = 0;
  for (int i = 1; i <= 4; ++i) {
    EXPECT_TRUE(worker.pushOrder(100 + i));
    dropped += worker.push(i);
  }
  gate.open();
  ASSERT_TRUE(worker.waitIdle(deadline()));
  EXPECT_EQ(dropped, 2U);
  EXPECT_EQ(handled, (std::vector<int>{0, 101, 102, 103, 3, 104, 4}));
}

TEST(Worker, WaitingIsForWhatIsQueuedNowWhateverFollows) {
  Gate first;
  Gate second;
  Worker<int> worker(2, [&](int item) {
    if (item == 0) first.pass();
    if (item == 9) second.pass();
  });
  worker.push(0);
  ASSERT_TRUE(first.waitForSomebody());
  worker.pushOrder(1);
  bool has_followed = false;
  const auto letFollow = [&]() -> std::uint64_t {  // called once it waits
    if (!std::exchange(has_followed, true)) {
      first.open();
      worker.pushOrder(9);
    }
    return 0;
  };
  EXPECT_TRUE(worker.waitHandled({deadline()}, letFollow));
  ASSERT_TRUE(second.waitForSomebody());
  EXPECT_GT(worker.size(), 0U);
  second.open();
}

TEST(Worker, ItemsThatDropDoNotCountAsTheOrderBeforeThem) {
  Gate gate;
  Worker<int> worker(1, [&](int) { gate.pass(); });
  worker.push(0);
  ASSERT_TRUE(gate.waitForSomebody());
  worker.pushOrder(1);
  std::thread feeder([&] {
    for (int i = 0; i < 20; ++i) worker.push(i);
  });
  feeder.join();
  EXPECT_FALSE(worker.waitHandled({deadline(), std::chrono::milliseconds(50)}));
  gate.open();
  EXPECT_TRUE(worker.waitHandled({deadline()}));
}

TEST(Worker, AStoppedOneTakesNoOrders) {
  Worker<int> worker(1, [](int) {});
  worker.stop();
  EXPECT_FALSE(worker.pushOrder(1));
  EXPECT_TRUE(worker.waitHandled({deadline()}));
}

TEST(Patience, WhoStillWorksIsNotLate) {
  const auto start = steady_clock::now();
  const auto has_passed = [&](int ms) {
    return steady_clock::now() - start > std::chrono::milliseconds(ms);
  };
  std::uint64_t progress = 0;
  const Patience patience{deadline(), std::chrono::milliseconds(500)};
  EXPECT_TRUE(
      waitPatiently([&] { return has_passed(1200); }, [&] { return ++progress; }, patience));
}

TEST(Patience, EndsWhereNothingMovesOrTheDeadlinePasses) {
  const auto never = [] { return false; };
  std::uint64_t progress = 0;
  EXPECT_FALSE(waitPatiently(never, [] { return 1; }, {deadline(), std::chrono::milliseconds(30)}));
  EXPECT_FALSE(waitPatiently(never, [&] { return ++progress; },
                             {steady_clock::now() + std::chrono::milliseconds(30)}));
}

TEST(Arrivals, WaitForAMessageOrAnyLaterOne) {
  Arrivals arrivals;
  const Patience brief{deadline(), std::chrono::milliseconds(20)};
  EXPECT_TRUE(arrivals.wait(0, brief));
  EXPECT_FALSE(arrivals.wait(1, brief));
  arrivals.note(3);
  EXPECT_TRUE(arrivals.wait(1, brief));
  EXPECT_TRUE(arrivals.wait(3, brief));
  EXPECT_FALSE(arrivals.wait(4, brief));
}

TEST(Worker, MailboxKeepsTheNewestItem) {
  Gate gate;
  std::vector<int> handled;
  Worker<int> worker(1, [&](int item) {
    if (item == 0) gate.pass();
    handled.push_back(item);
  });
  worker.push(0);
  ASSERT_TRUE(gate.waitForSomebody());
  for (int i = 1; i <= 9; ++i) worker.push(i);
  gate.open();
  ASSERT_TRUE(worker.waitIdle(deadline()));
  EXPECT_EQ(handled, (std::vector<int>{0, 9}));
}

TEST(Worker, StoppingFinishesTheItemInHandOnly) {
  Gate gate;
  std::atomic<int> handled{0};
  Worker<int> worker(10, [&](int) {
    gate.pass();
    ++handled;
  });
  worker.push(1);
  ASSERT_TRUE(gate.waitForSomebody());
  worker.push(2);
  std::thread opener([&] { gate.open(); });
  worker.stop();
  opener.join();
  EXPECT_LE(handled, 2);
  EXPECT_GE(handled, 1);
  EXPECT_EQ(worker.push(3), 1U);
}

TEST(StampOrder, TellsDuplicatesLateStampsAndJumps) {
  using Kind = StampOrder::Kind;
  StampOrder order(1.0);
  EXPECT_EQ(order.update(Stamp::fromSeconds(10.0)), Kind::kNext);
  EXPECT_EQ(order.update(Stamp::fromSeconds(10.0)), Kind::kDuplicate);
  EXPECT_EQ(order.update(Stamp::fromSeconds(11.0)), Kind::kNext);
  EXPECT_EQ(order.update(Stamp::fromSeconds(10.5)), Kind::kLate);
  EXPECT_EQ(order.update(Stamp::fromSeconds(9.0)), Kind::kJumpBack);
  EXPECT_EQ(order.update(Stamp::fromSeconds(9.1)), Kind::kNext);
}

class PoseWaiterTest : public ::testing::Test {
 protected:
  void setTransform(double seconds_, double x, bool is_static = false) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp.fromSec(seconds_);
    transform.header.frame_id = "world";
    transform.child_frame_id = "camera";
    transform.transform.translation.x = x;
    transform.transform.rotation.w = 1.0;
    buffer_.setTransform(transform, "test", is_static);
    if (waiter_ != nullptr) waiter_->notifyNews();
  }
  std::shared_ptr<RgbdFrame> makeFrame(double seconds_) {
    auto frame = std::make_shared<RgbdFrame>();
    frame->stamp = Stamp::fromSeconds(seconds_);
    return frame;
  }
  std::unique_ptr<PoseWaiter> makeWaiter(std::size_t capacity = 10) {
    auto waiter = std::make_unique<PoseWaiter>(
        poses_, PoseWaiter::Options{capacity, 1.0}, [this] { return now_s_.load(); },
        [this](RgbdFramePtr frame) {
          const std::lock_guard<std::mutex> lock(mutex_);
          frames_.push_back(frame);
          changed_.notify_all();
        },
        [this](const std::string& reason, const std::string& text) {
          const std::lock_guard<std::mutex> lock(mutex_);
          drops_.emplace_back(reason, text);
          changed_.notify_all();
        });
    waiter_ = waiter.get();
    return waiter;
  }
  bool waitFor(std::size_t num_frames, std::size_t num_drops) {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_until(lock, deadline(), [&] {
      return frames_.size() >= num_frames && drops_.size() >= num_drops;
    });
  }

  tf2::BufferCore buffer_;
  PoseSource poses_{InputConfig(), buffer_};
  PoseWaiter* waiter_ = nullptr;
  std::atomic<double> now_s_{0.0};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<RgbdFramePtr> frames_;
  std::vector<std::pair<std::string, std::string>> drops_;
};

TEST_F(PoseWaiterTest, PoseIsInterpolatedAtTheStamp) {
  setTransform(10.0, 1.0);
  setTransform(11.0, 2.0);
  auto waiter = makeWaiter();
  waiter->push(makeFrame(10.25), "camera");
  ASSERT_TRUE(waitFor(1, 0));
  EXPECT_NEAR(frames_[0]->T_world_camera.translation().x(), 1.25, 1e-9);
}

TEST_F(PoseWaiterTest, FrameWaitsForATransformThatComesLater) {
  setTransform(10.0, 1.0);
  auto waiter = makeWaiter();
  waiter->push(makeFrame(10.5), "camera");
  waiter->push(makeFrame(10.75), "camera");
  EXPECT_EQ(waiter->size(), 2U);
  setTransform(11.0, 2.0);
  ASSERT_TRUE(waitFor(2, 0));
  EXPECT_NEAR(frames_[1]->T_world_camera.translation().x(), 1.75, 1e-9);
  EXPECT_TRUE(drops_.empty());
}

TEST_F(PoseWaiterTest, MissingTransformIsNamedAfterTheTimeout) {
  auto waiter = makeWaiter();
  waiter->push(makeFrame(10.5), "camera");
  now_s_ = 2.0;
  ASSERT_TRUE(waitFor(0, 1));
  EXPECT_EQ(drops_[0].first, "no transform");
  EXPECT_NE(drops_[0].second.find("from 'camera' to 'world' at stamp 10.500 s"), std::string::npos)
      << drops_[0].second;
}

TEST_F(PoseWaiterTest, FrameFromBeforeTheFirstTransformIsDroppedAtOnce) {
  setTransform(10.0, 1.0);
  setTransform(11.0, 2.0);
  auto waiter = makeWaiter();
  waiter->push(makeFrame(9.0), "camera");
  waiter->push(makeFrame(10.5), "camera");
  ASSERT_TRUE(waitFor(1, 1));
  EXPECT_EQ(frames_[0]->stamp, Stamp::fromSeconds(10.5));
}

TEST_F(PoseWaiterTest, StaticTransformHoldsAtAnyStamp) {
  setTransform(0.0, 3.0, true);
  auto waiter = makeWaiter();
  waiter->push(makeFrame(12345.0), "camera");
  ASSERT_TRUE(waitFor(1, 0));
  EXPECT_EQ(frames_[0]->T_world_camera.translation().x(), 3.0);
}

TEST_F(PoseWaiterTest, FullQueueDropsItsOldestFrame) {
  auto waiter = makeWaiter(2);
  for (int i = 0; i < 3; ++i) waiter->push(makeFrame(10.0 + i), "camera");
  ASSERT_TRUE(waitFor(0, 1));
  EXPECT_EQ(drops_[0].first, PoseWaiter::kQueueFull);
  EXPECT_EQ(waiter->size(), 2U);
  EXPECT_EQ(waiter->clear(), 2U);
}

struct NestedConfig {
  double size_m = 0.1;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("size_m", self.size_m, {0.0, 1.0}, "m", "");
  }
};

struct NodeConfig {
  int count = 1;
  bool flag = false;
  std::string name;
  std::vector<std::string> names;
  NestedConfig nested;
  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("count", self.count, {0, 10}, "", "");
    v.field("flag", self.flag, {}, "", "");
    v.field("name", self.name, {}, "", "");
    v.field("names", self.names, {}, "", "");
    v.group("nested", self.nested);
  }
};

TEST(Parameters, EveryTypeArrives) {
  XmlRpc::XmlRpcValue value;
  value["count"] = 7;
  value["flag"] = true;
  value["name"] = std::string("on: [tricky");
  value["names"][0] = std::string("a");
  value["names"][1] = std::string("b");
  value["nested"]["size_m"] = 0.3;
  const auto config = config::load<NodeConfig>(toYaml(value), "node");
  EXPECT_EQ(config.count, 7);
  EXPECT_TRUE(config.flag);
  EXPECT_EQ(config.name, "on: [tricky");
  EXPECT_EQ(config.names, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(config.nested.size_m, 0.3);
}

TEST(Parameters, MisspeltNameIsAnErrorThatSuggestsTheRightOne) {
  XmlRpc::XmlRpcValue value;
  value["nested"]["size_mm"] = 0.5;
  try {
    config::load<NodeConfig>(toYaml(value), "parameters of /tracker");
    FAIL() << "no error";
  } catch (const config::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("parameters of /tracker"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("'nested/size_mm', did you mean 'size_m'?"),
              std::string::npos)
        << e.what();
  }
}

TEST(Parameters, DoublesKeepEveryDigit) {
  for (const double number : {0.1, 1.0 / 3.0, 1e-5, 12345678.9, 2.0}) {
    EXPECT_EQ(toYaml(XmlRpc::XmlRpcValue(number)).as<double>(), number);
  }
}

TEST(StageReport, CountsAndNamesWhatWasDropped) {
  StageReport report("tracker");
  report.countInput();
  report.countProcessed(2.0);
  report.countProcessed(4.0);
  report.countImage(true, nullptr);
  report.countDropped("no transform", "dropped a frame: no transform at stamp 3 s");
  report.countDropped("no transform", "dropped a frame: no transform at stamp 4 s");
  diagnostic_updater::DiagnosticStatusWrapper status;
  report.fill(status);
  EXPECT_EQ(status.level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "dropped a frame: no transform at stamp 4 s");
  std::map<std::string, std::string> lines;
  for (const auto& entry : status.values) lines[entry.key] = entry.value;
  EXPECT_EQ(lines["inputs"], "1");
  EXPECT_EQ(lines["processed"], "2");
  EXPECT_EQ(lines["dropped: no transform"], "2");
  EXPECT_EQ(lines["images shared"], "1");
  EXPECT_EQ(lines["ms mean"], "3.00");
  EXPECT_EQ(lines["ms max"], "4.00");
  diagnostic_updater::DiagnosticStatusWrapper next;
  report.fill(next);
  EXPECT_EQ(next.level, diagnostic_msgs::DiagnosticStatus::OK);
}

}  // namespace
}  // namespace tsg::ros_interface
