// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace tsg::segmentation {

/// Networks that belong together, and everything that has to match between them. Loaded from one
/// YAML file with these keys; paths in it are relative to the file.
struct ModelSet {
  std::string file;  ///< the YAML file it was loaded from, or empty; no key
  std::string name;
  std::string segmenter;                    ///< path of a FastSAM-shaped ONNX file
  double segmenter_score_threshold = 0.55;  ///< masks below this score are dropped
  double segmenter_iou_threshold = 0.85;  ///< of two boxes that overlap more, the better one stays
  int segmenter_input_size_px = 640;      ///< used only if the file leaves its input size open
  std::string image_encoder;              ///< path of a CLIP-shaped ONNX file
  int image_encoder_input_size_px = 224;  ///< used only if the file leaves its input size open
  std::string image_encoder_output;       ///< name of its embedding, or empty: found by itself
  std::string text_encoder;               ///< path, or empty: tasks come with their embeddings
  std::string text_encoder_output;        ///< name of its embedding, or empty: found by itself
  int text_context_length = 77;           ///< length of its texts, in tokens of CLIP's tokenizer
  std::string tokenizer;                  ///< path, or empty
  int embedding_size = 0;                 ///< D, of image and text embeddings
  std::vector<double> image_mean = {0.48145466, 0.4578275, 0.40821073};  ///< RGB, of values in 0..1
  std::vector<double> image_std = {0.26862954, 0.26130258, 0.27577711};  ///< RGB, of values in 0..1
  double alpha = 0.23;  ///< suggested threshold on the cosine between an object and a task

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor& v) {
    v.field("name", self.name, {}, "", "name of the set, for messages");
    v.field("segmenter", self.segmenter, {}, "", "FastSAM-shaped ONNX file");
    v.field("segmenter_score_threshold", self.segmenter_score_threshold, {0.0, 1.0}, "",
            "masks that do not exceed this score are dropped");
    v.field("segmenter_iou_threshold", self.segmenter_iou_threshold, {0.0, 1.0}, "",
            "of two boxes whose IoU exceeds this, the better one stays");
    v.field("segmenter_input_size_px", self.segmenter_input_size_px, {32, 4096}, "px",
            "side of the square input, where the file leaves it open");
    v.field("image_encoder", self.image_encoder, {}, "", "CLIP-shaped ONNX file");
    v.field("image_encoder_input_size_px", self.image_encoder_input_size_px, {1, 2048}, "px",
            "side of the square input, where the file leaves it open");
    v.field("image_encoder_output", self.image_encoder_output, {}, "",
            "name of the output that is the embedding, where the file leaves doubts");
    v.field("text_encoder", self.text_encoder, {}, "", "ONNX file; empty: none");
    v.field("text_encoder_output", self.text_encoder_output, {}, "",
            "name of the output that is the embedding, where the file leaves doubts");
    v.field("text_context_length", self.text_context_length, {2, 65536}, "",
            "tokens of CLIP's tokenizer that the text encoder reads; CLIP: 77");
    v.field("tokenizer", self.tokenizer, {}, "", "vocabulary file; empty: none");
    v.field("embedding_size", self.embedding_size, {1, 65536}, "", "size of all embeddings");
    v.field("image_mean", self.image_mean, {0.0, 1.0}, "",
            "RGB mean of the encoder's input, of values in 0..1");
    v.field("image_std", self.image_std, {1e-3, 1.0}, "",
            "RGB deviation of the encoder's input, of values in 0..1");
    v.field("alpha", self.alpha, {-1.0, 1.0}, "", "suggested threshold on task similarity");
  }
};

/// Reads a model set; all paths in the result are absolute.
/// @throws config::ConfigError with all violations: unreadable YAML, unknown or missing keys,
/// values out of range, files that are not there.
ModelSet loadModelSet(const std::string& yaml_path);

/// "model set 'vit-b-32' (/home/a/models.yaml)", for messages.
std::string describe(const ModelSet& models);

}  // namespace tsg::segmentation
