// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/segmenter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <vector>

#include "own_threads.h"
#include "segment_carrier.h"
#include "task_scene_graph/config/config.h"
#include "task_scene_graph/segmentation/label_painter.h"
#include "task_scene_graph/segmentation/letterbox.h"
#include "task_scene_graph/segmentation/mask_decoder.h"
#include "task_scene_graph/segmentation/segmenter_layout.h"

namespace tsg::segmentation {
namespace {

void checkImage(const cv::Mat& image) {
  if (image.type() == CV_8UC3 && !image.empty()) return;
  throw std::invalid_argument("colour image is " + std::to_string(image.cols) + "x" +
                              std::to_string(image.rows) + " of OpenCV type " +
                              cv::typeToString(image.type()) +
                              ", expected CV_8UC3 and at least one pixel");
}

void checkInputs(const Network& network) {
  const std::string why = explainSegmenterInputs(network.inputs());
  if (why.empty()) return;
  throw InferenceError("segmenter '" + network.path() + "' has inputs " + toText(network.inputs()) +
                       " and outputs " + toText(network.outputs()) +
                       ", expected FastSAM's float32[1,3,S,S] -> float32[1,4+classes+K,A] and "
                       "float32[1,K,P,P]: " +
                       why + "; scripts/export_models does");
}

/// Dark waves: a constant image could divide by 0 in networks that normalise by themselves.
cv::Mat makePattern() {
  cv::Mat image(480, 640, CV_8UC3);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<std::uint8_t>((7 * u + 13 * v) % 112));
    }
  }
  return image;
}

ModelSet applyOverrides(ModelSet models, const SegmenterConfig& config) {
  if (config.score_threshold >= 0.0) models.segmenter_score_threshold = config.score_threshold;
  if (config.iou_threshold >= 0.0) models.segmenter_iou_threshold = config.iou_threshold;
  return models;
}

cv::Rect padBox(const cv::Rect& box, int padding_px, cv::Size image_size_px) {
  const cv::Rect padded(box.x - padding_px, box.y - padding_px, box.width + 2 * padding_px,
                        box.height + 2 * padding_px);
  return padded & cv::Rect({0, 0}, image_size_px);
}

}  // namespace

class Segmenter::Implementation {
 public:
  Implementation(const ModelSet& models, const SegmenterConfig& config)
      : models_(applyOverrides(models, config)),
        config_(config),
        num_threads_(resolveNumThreads(config.engine)),
        network_(models.segmenter, config.engine) {
    checkInputs(network_);
    const auto& shape = network_.inputs()[0].shape;
    const auto side = static_cast<int>(std::max(shape[2], shape[3]));
    input_size_px_ = side > 0 ? side : models.segmenter_input_size_px;
    findLayout();
    if (config.embed_crop || config.embed_masked_crop || config.embed_image) {
      encoder_.emplace(models, config.engine, config.encoder);
    }
    if (config.schedule.mode == ScheduleMode::kReuse && countCropsPerSegment() > 0) {
      schedule_.emplace(config.schedule, countCropsPerSegment());
      carrier_.emplace(config.schedule, config.min_area_px);
    }
  }

  Segmentation segment(const ColorImage& color) {
    checkImage(color.image);
    ++counters_.images;
    Segmentation result;
    result.stamp = color.stamp;
    const LabelledSegments segments =
        schedule_ ? segmentOnSchedule(color, result) : segmentExactly(color, result);
    if (segments.scores.empty()) ++counters_.images_without_segments;
    result.labels = segments.labels;
    result.confidences = segments.scores;
    return result;
  }

  Embedding embed(const ColorImage& color) const {
    checkImage(color.image);
    if (!encoder_) {
      throw InferenceError(
          "this segmenter embeds nothing: embed_crop, embed_masked_crop and embed_image are false");
    }
    const CropRequest whole{cv::Rect({0, 0}, color.image.size()), 0};
    const Embedding row = encoder_->encode(color, {}, {whole}).row(0).transpose();
    const float norm = row.norm();
    if (std::isfinite(norm) && norm > 0.0F) return row / norm;
    throw InferenceError("the image encoder gives no direction for this picture (length " +
                         std::to_string(norm) + ")");
  }

  void cancel() {
    network_.cancel();
    if (encoder_) encoder_->cancel();
  }

  const SegmenterCounters& counters() const { return counters_; }
  int embeddingSize() const { return models_.embedding_size; }

 private:
  void findLayout() {
    const ColorImage color{{}, makePattern(), ColorOrder::kRgb, nullptr};
    std::vector<TensorView> outputs;
    try {
      outputs = runNetwork(color, computeLetterbox(color.image.size(), input_size_px_));
    } catch (const InferenceError& e) {
      throw InferenceError("segmenter '" + network_.path() + "' cannot take images of " +
                           std::to_string(input_size_px_) +
                           " px (its own size, or segmenter_input_size_px of " + describe(models_) +
                           "; a multiple of 32 in YOLO): " + e.what());
    }
    layout_ = findSegmenterLayout(network_.outputs(), outputs, input_size_px_, network_.path());
  }

  std::vector<TensorView> runNetwork(const ColorImage& color, const Letterbox& letterbox) {
    const std::int64_t side = input_size_px_;
    tensor_.resize(static_cast<std::size_t>(3 * side * side));
    fillLetterboxTensor(color, letterbox, tensor_.data());
    return network_.run({{1, 3, side, side}, tensor_.data(), nullptr});
  }

  LabelledSegments findSegments(const ColorImage& color) {
    const Letterbox letterbox = computeLetterbox(color.image.size(), input_size_px_);
    const auto outputs = runNetwork(color, letterbox);
    const RawDetections raw = interpretOutputs(outputs, layout_, network_.path());
    const std::vector<Detection> detections = suppressOverlaps(
        findCandidates(raw, models_.segmenter_score_threshold), models_.segmenter_iou_threshold,
        static_cast<std::size_t>(config_.max_segments));
    std::vector<SegmentMask> masks(detections.size());
    runOnOwnThreads(detections.size(), num_threads_,
                    [&](std::size_t i) { masks[i] = decodeMask(raw, detections[i], letterbox); });
    return paintLabels(masks, color.image.size(), config_.refine_masks, config_.min_area_px);
  }

  /// For each of these segments: crop, masked crop (as configured); last the whole image.
  std::vector<CropRequest> planCrops(const LabelledSegments& segments,
                                     const std::vector<std::size_t>& chosen,
                                     bool embed_image) const {
    std::vector<CropRequest> crops;
    for (const std::size_t i : chosen) {
      const cv::Rect box =
          padBox(segments.boxes_px[i], config_.crop_padding_px, segments.labels.size());
      if (config_.embed_crop) crops.push_back({box, 0});
      if (config_.embed_masked_crop) crops.push_back({box, static_cast<std::uint16_t>(i + 1)});
    }
    if (embed_image) crops.push_back({cv::Rect({0, 0}, segments.labels.size()), 0});
    return crops;
  }

  LabelledSegments segmentExactly(const ColorImage& color, Segmentation& result) {
    LabelledSegments segments = findSegments(color);
    std::vector<std::size_t> all(segments.scores.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    result.embeddings = encode(color, segments, all, config_.embed_image, result);
    return segments;
  }

  /// As if the image had not been there if something in it fails.
  LabelledSegments segmentOnSchedule(const ColorImage& color, Segmentation& result) {
    const MotionEstimator motion_before = motion_;
    const SegmentCarrier carrier_before = *carrier_;
    try {
      return advanceSchedule(color, result);
    } catch (...) {
      motion_ = motion_before;
      *carrier_ = carrier_before;
      throw;
    }
  }

  LabelledSegments advanceSchedule(const ColorImage& color, Segmentation& result) {
    const ImageMotion motion = motion_.update(color);
    std::optional<LabelledSegments> carried = carrier_->carry(color.stamp, motion);
    LabelledSegments segments = carried ? std::move(*carried) : findSegments(color);
    embedOnSchedule(color, motion, segments, result);
    counters_.images_carried += carried.has_value();
    carrier_->setSegments(color.stamp, segments, carried.has_value());
    return segments;
  }

  /// One row per chosen segment, of unit length or zeros; the whole image's goes to `result`.
  EmbeddingMatrix encode(const ColorImage& color, const LabelledSegments& segments,
                         const std::vector<std::size_t>& chosen, bool embed_image,
                         Segmentation& result) {
    const auto num_chosen = static_cast<Eigen::Index>(chosen.size());
    EmbeddingMatrix embeddings = EmbeddingMatrix::Zero(num_chosen, models_.embedding_size);
    if (!encoder_) return embeddings;
    const std::vector<CropRequest> crops = planCrops(segments, chosen, embed_image);
    const EmbeddingMatrix rows = encoder_->encode(color, segments.labels, crops);
    counters_.crops_embedded += crops.size();
    const Eigen::Index per_segment = countCropsPerSegment();
    for (Eigen::Index s = 0; s < num_chosen && per_segment > 0; ++s) {
      embeddings.row(s) =
          toUnit(rows.middleRows(s * per_segment, per_segment).colwise().mean().transpose());
    }
    if (!embed_image) return embeddings;
    const Embedding image = toUnit(rows.row(rows.rows() - 1).transpose());
    if (!image.isZero(0.0F)) result.image_embedding = image;
    return embeddings;
  }

  void embedOnSchedule(const ColorImage& color, const ImageMotion& motion,
                       LabelledSegments& segments, Segmentation& result) {
    EmbeddingSchedule::Plan plan = schedule_->plan(color, segments, motion);
    const std::vector<std::size_t> dropped = plan.dropped;
    const std::size_t num_reused = plan.reuse.size();
    const bool embed_image = config_.embed_image && plan.embed_image;
    const std::int64_t start = cv::getTickCount();
    const EmbeddingMatrix fresh = encode(color, segments, plan.embed, embed_image, result);
    schedule_->addCost(
        plan.embed.size() * static_cast<std::size_t>(countCropsPerSegment()) + embed_image,
        1e3 * static_cast<double>(cv::getTickCount() - start) / cv::getTickFrequency());
    const EmbeddingMatrix rows = schedule_->commit(std::move(plan), fresh);
    counters_.segments_reused += num_reused;
    counters_.segments_dropped += dropped.size();
    result.embeddings.resize(rows.rows() - static_cast<Eigen::Index>(dropped.size()), rows.cols());
    Eigen::Index kept = 0;
    for (std::size_t i = 0; i < segments.scores.size(); ++i) {
      if (std::binary_search(dropped.begin(), dropped.end(), i)) continue;
      result.embeddings.row(kept++) = rows.row(static_cast<Eigen::Index>(i));
    }
    dropSegments(dropped, segments);
  }

  int countCropsPerSegment() const { return config_.embed_crop + config_.embed_masked_crop; }

  /// Scaled to unit length; zeros, counted, if that is not possible.
  Embedding toUnit(const Embedding& mean) {
    const float norm = mean.norm();
    if (std::isfinite(norm) && norm > 0.0F) return mean / norm;
    ++counters_.embeddings_not_finite;
    return Embedding::Zero(mean.size());
  }

  const ModelSet models_;
  const SegmenterConfig config_;
  const int num_threads_;
  int input_size_px_ = 0;
  Network network_;
  SegmenterLayout layout_;
  std::optional<ImageEncoder> encoder_;
  std::optional<EmbeddingSchedule> schedule_;  ///< none: every segment of every image
  std::optional<SegmentCarrier> carrier_;      ///< with schedule_ only
  MotionEstimator motion_;
  std::vector<float> tensor_;  ///< the segmenter's input, reused
  SegmenterCounters counters_;
};

Segmenter::Segmenter(const ModelSet& models, const SegmenterConfig& config) {
  config::validate(models, describe(models));
  config::validate(config, "segmenter");
  implementation_ = std::make_unique<Implementation>(models, config);
}

Segmenter::~Segmenter() = default;

Segmentation Segmenter::segment(const ColorImage& color) { return implementation_->segment(color); }

Embedding Segmenter::embed(const ColorImage& color) const { return implementation_->embed(color); }

void Segmenter::cancel() { implementation_->cancel(); }

const SegmenterCounters& Segmenter::counters() const { return implementation_->counters(); }

int Segmenter::embeddingSize() const { return implementation_->embeddingSize(); }

}  // namespace tsg::segmentation
