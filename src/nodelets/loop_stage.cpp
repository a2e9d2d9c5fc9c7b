// SPDX-License-Identifier: BSD-3-Clause
#include "loop_stage.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "task_scene_graph/core/thread_priority.h"

namespace tsg::nodelets {
namespace {

constexpr std::size_t kMostWaiting = 50;  ///< keyframes, with their images

}  // namespace

LoopStage::LoopStage(const Options& options, ros_interface::StageReport& report, OnResult on_result)
    : options_(options),
      report_(report),
      on_result_(std::move(on_result)),
      keyframes_(std::in_place, options.frame, options.config.keyframes),
      closer_(std::in_place, options.frame, options.config),
      results_(1, [this](const auto& result) { on_result_(*result); }),
      worker_(
          kMostWaiting, [](const Job& job) { job(); }, [this](const Job&) { ++num_passed_over_; }) {
  worker_.pushOrder([] { lowerThreadPriority(); });
}

void LoopStage::addFrame(const RgbdFramePtr& frame, const SegmentationPtr& segmentation) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!keyframes_) return;
  const auto& list = keyframes_->list();
  if (!list.empty() && frame->stamp <= list.back().stamp) return;  // overtaken by the next one
  if (!keyframes_->add(frame->stamp, frame->T_world_camera)) return;
  worker_.push([this, frame, segmentation] { process(*frame, segmentation); });
}

void LoopStage::process(const RgbdFrame& frame, const SegmentationPtr& segmentation) {
  try {
    is_due_ = closer_->add(frame, segmentation) || is_due_;
  } catch (const std::exception& e) {
    report_.warn("loop closure",
                 "no loop closure is looked for at a keyframe: " + std::string(e.what()));
  }
  describe();
  const bool has_rested =
      !last_told_ || frame.stamp.seconds() - last_told_->seconds() >= options_.period_s;
  if (is_due_ && has_rested) tell();
}

void LoopStage::tell() {
  is_due_ = false;
  last_told_ = closer_->keyframes().list().back().stamp;
  results_.push(std::make_shared<const LoopResult>(makeResult()));
}

LoopResult LoopStage::makeResult() const {
  LoopResult result;
  const trajectory::Keyframes corrected = closer_->correctedKeyframes();
  for (const auto& keyframe : corrected.list()) {
    result.keyframes.add(keyframe.stamp, keyframe.T_world_camera);
  }
  for (const loops::LoopRecord& record : closer_->records()) {
    if (!record.edge) continue;
    const auto& a = *corrected.find(record.a);
    const auto& b = *corrected.find(record.b);
    const trajectory::PoseEdge& edge = closer_->graph().edges()[*record.edge];
    const auto error = trajectory::computeError(edge, a.T_world_camera, b.T_world_camera);
    result.lines.push_back(
        {a.stamp, b.stamp, loops::isAccepted(record, closer_->graph()), error.head<3>().norm()});
  }
  return result;
}

void LoopStage::describe() {
  const auto& records = closer_->records();
  const auto num_accepted = std::count_if(records.begin(), records.end(), [&](const auto& record) {
    return loops::isAccepted(record, closer_->graph());
  });
  report_.set("loop closures: keyframes", std::to_string(closer_->keyframes().list().size()));
  report_.set("loop closures: pairs of places tried", std::to_string(records.size()));
  report_.set("loop closures: accepted", std::to_string(num_accepted));
  if (records.empty()) return;
  report_.set("loop closures: the last pair",
              loops::describeOutcome(records.back(), closer_->graph()));
}

bool LoopStage::finish(const ros_interface::Patience& patience) {
  worker_.pushOrder([this] {
    try {
      is_due_ = closer_->finish() || is_due_;
    } catch (const std::exception& e) {
      report_.warn("loop closure", "the last places are not compared: " + std::string(e.what()));
    }
    describe();
    if (is_due_) tell();
  });
  return worker_.waitHandled(patience) && results_.waitHandled(patience);
}

void LoopStage::end() {
  const std::lock_guard<std::mutex> lock(mutex_);
  keyframes_.reset();
}

void LoopStage::restart() {
  const std::lock_guard<std::mutex> lock(mutex_);
  keyframes_.emplace(options_.frame, options_.config.keyframes);
  worker_.pushOrder([this] {
    closer_.emplace(options_.frame, options_.config);
    last_told_.reset();
    is_due_ = false;
  });
}

void LoopStage::check() {
  report_.set("loop closures: keyframes that wait", std::to_string(worker_.size()));
  const std::lock_guard<std::mutex> lock(mutex_);
  report_.set("loop closures: keyframes passed over", std::to_string(num_passed_over_));
}

void LoopStage::stop() {
  worker_.stop();
  results_.stop();
}

}  // namespace tsg::nodelets
