// SPDX-License-Identifier: BSD-3-Clause
#include "task_scene_graph/segmentation/clip_signature.h"

#include <algorithm>
#include <array>
#include <optional>

namespace tsg::segmentation {
namespace {

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

bool isInteger(const TensorInfo& info) {
  return info.element_type == "int64" || info.element_type == "int32";
}

ClipInput findRole(const TensorInfo& input) {
  if (input.shape.size() == 4) return ClipInput::kImages;
  if (!isInteger(input) || input.shape.size() != 2) return ClipInput::kUnknown;
  if (contains(input.name, "mask")) return ClipInput::kMask;
  const bool is_other = contains(input.name, "position") || contains(input.name, "type");
  return is_other ? ClipInput::kUnknown : ClipInput::kTokens;
}

std::string explainImages(const TensorInfo& images) {
  const auto& shape = images.shape;
  const bool may_be_channels = shape[1] == 3 || shape[1] < 0;
  if (!may_be_channels && shape[3] == 3) {
    return "it takes images with channels last; export it with channels first, [N,3,S,S]";
  }
  if (!may_be_channels) {
    return "it takes images of " + std::to_string(shape[1]) + " channels, not of red, green, blue";
  }
  if (!isFloat(images)) {
    return "it takes pixels as " + images.element_type +
           "; export it without the preprocessing inside, for float32 images";
  }
  if (shape[2] > 0 && shape[3] > 0 && shape[2] != shape[3]) {
    return "it takes images of " + std::to_string(shape[3]) + "x" + std::to_string(shape[2]) +
           " px; export it for square ones";
  }
  return "";
}

std::string explainUnknown(const TensorInfo& input) {
  if (contains(input.name, "token_type")) {
    return "'" + input.name + "' belongs to BERT's tokenizer, and tokens here are CLIP's";
  }
  if (input.shape.size() == 2 && !isInteger(input)) {
    return "'" + input.name + "' is " + input.element_type + ", and tokens are int64 or int32";
  }
  return "nothing is known of its input '" + input.name + "'";
}

const char* expectedName(Modality modality) {
  return modality == Modality::kImage ? "image_embeds" : "text_embeds";
}

/// Of outputs that are not the embedding, whatever their size.
bool isOtherName(const std::string& name, Modality modality) {
  const Modality other = modality == Modality::kImage ? Modality::kText : Modality::kImage;
  return contains(name, "hidden_state") || contains(name, "pooler_output") ||
         contains(name, "logits") || name == expectedName(other);
}

std::optional<std::size_t> findName(const std::vector<TensorInfo>& infos, const std::string& name) {
  for (std::size_t i = 0; i < infos.size(); ++i) {
    if (infos[i].name == name) return i;
  }
  return std::nullopt;
}

class OutputChoice {
 public:
  OutputChoice(const std::vector<TensorInfo>& infos, const std::vector<TensorView>& outputs,
               const EmbeddingSearch& search)
      : infos_(infos), outputs_(outputs), search_(search) {}

  std::size_t choose() const {
    if (!search_.wanted_name.empty()) return requireWanted();
    if (const auto named = findName(infos_, expectedName(search_.modality))) {
      if (isRight(*named)) return *named;
      refuse(explainShape(*named));
    }
    std::vector<std::size_t> right;
    for (std::size_t i = 0; i < infos_.size(); ++i) {
      if (isRight(i) && !isOtherName(infos_[i].name, search_.modality)) right.push_back(i);
    }
    if (right.size() == 1) return right.front();
    refuse(right.empty() ? explainNone() : explainSeveral(right));
  }

 private:
  bool isRight(std::size_t i) const {
    return isEmbeddingShaped(outputs_[i], search_.count, search_.size);
  }

  std::string key() const {
    return search_.modality == Modality::kImage ? "image_encoder_output" : "text_encoder_output";
  }

  std::size_t requireWanted() const {
    const auto wanted = findName(infos_, search_.wanted_name);
    if (!wanted) refuse(key() + " is '" + search_.wanted_name + "', which is none of them");
    if (!isRight(*wanted)) refuse(explainShape(*wanted));
    return *wanted;
  }

  std::string exportAdvice() const {
    return std::string("export the projected embedding (Hugging Face: CLIP") +
           (search_.modality == Modality::kImage ? "Vision" : "Text") +
           "ModelWithProjection, or scripts/export_models)";
  }

  std::string explainShape(std::size_t i) const {
    const TensorView& output = outputs_[i];
    const std::string found = "'" + infos_[i].name + "' is " + toText(output.shape);
    if (output.values == nullptr) return found + " of " + infos_[i].element_type + ", not floats";
    if (output.shape.size() == 2 && output.shape[0] == search_.count) {
      return "it gives embeddings of " + std::to_string(output.shape[1]) + " values, but " +
             search_.models + " says embedding_size " + std::to_string(search_.size);
    }
    if (output.shape.size() == 3) {
      return found + ", the hidden states of every token or patch; " + exportAdvice();
    }
    return found + ", not one row for each " +
           (search_.modality == Modality::kImage ? "image" : "text");
  }

  std::string explainNone() const {
    for (std::size_t i = 0; i < infos_.size(); ++i) {
      if (!contains(infos_[i].name, "pooler_output") || !isRight(i)) continue;
      return "in CLIP '" + infos_[i].name +
             "' comes before the projection into the space that images and texts share; " +
             exportAdvice() + ", or, if this network has no projection" +
             (search_.modality == Modality::kImage ? " (SigLIP)" : "") + ", say so in " +
             search_.models + ": '" + key() + ": " + infos_[i].name + "'";
    }
    const auto is_row = [&](const TensorView& output) { return output.shape.size() == 2; };
    const auto row = std::find_if(outputs_.begin(), outputs_.end(), is_row);
    const std::size_t which =
        row == outputs_.end() ? 0 : static_cast<std::size_t>(row - outputs_.begin());
    return explainShape(which);
  }

  std::string explainSeveral(const std::vector<std::size_t>& right) const {
    return std::to_string(right.size()) + " of them could be the embedding; name it in " +
           search_.models + ": '" + key() + ": " + infos_[right.front()].name + "'";
  }

  std::string describeCount() const {
    return std::to_string(search_.count) +
           (search_.modality == Modality::kImage ? " image" : " text") +
           (search_.count == 1 ? "" : "s");
  }

  [[noreturn]] void refuse(const std::string& why) const {
    throw InferenceError(search_.encoder + " gives " + toText(infos_, outputs_) + " for " +
                         describeCount() + ", expected " + expectedName(search_.modality) + " " +
                         toText({search_.count, search_.size}) + ": " + why);
  }

  const std::vector<TensorInfo>& infos_;
  const std::vector<TensorView>& outputs_;
  const EmbeddingSearch& search_;
};

}  // namespace

std::vector<ClipInput> findClipInputs(const std::vector<TensorInfo>& inputs) {
  std::vector<ClipInput> roles;
  for (const TensorInfo& input : inputs) roles.push_back(findRole(input));
  return roles;
}

std::string explainClipInputs(Modality modality, const std::vector<TensorInfo>& inputs) {
  std::array<int, 4> counts{};
  const std::vector<ClipInput> roles = findClipInputs(inputs);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    ++counts[static_cast<std::size_t>(roles[i])];
    if (roles[i] == ClipInput::kUnknown) return explainUnknown(inputs[i]);
    const std::string why = roles[i] == ClipInput::kImages ? explainImages(inputs[i]) : "";
    if (!why.empty()) return why;
  }
  const int images = counts[static_cast<std::size_t>(ClipInput::kImages)];
  const int tokens = counts[static_cast<std::size_t>(ClipInput::kTokens)];
  const int masks = counts[static_cast<std::size_t>(ClipInput::kMask)];
  if (modality == Modality::kImage && images == 0) return "it takes no images: a text encoder?";
  if (modality == Modality::kText && tokens == 0) return "it takes no tokens: an image encoder?";
  if (masks > tokens) return "it takes more masks than tokens";
  if (images > 1 || tokens > 1) return "it takes several inputs of one kind";
  return "";
}

std::size_t findEmbeddingOutput(const std::vector<TensorInfo>& infos,
                                const std::vector<TensorView>& outputs,
                                const EmbeddingSearch& search) {
  return OutputChoice(infos, outputs, search).choose();
}

bool isEmbeddingShaped(const TensorView& output, std::int64_t count, std::int64_t size) {
  const auto& shape = output.shape;
  if (output.values == nullptr || shape.size() < 2 || shape[0] != count) return false;
  std::int64_t values = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) values *= shape[i];
  return values == size && std::find(shape.begin() + 1, shape.end(), size) != shape.end();
}

}  // namespace tsg::segmentation
