# SPDX-License-Identifier: BSD-3-Clause
"""Checkpoints -> ONNX files, checked against PyTorch, with the model set's YAML and reference outputs
for the tests."""
import json
import warnings

import numpy as np
import onnxruntime
import torch

from .data import CROP_SIZE, SEGMENTER_SIZE
from .encoder_network import EMBEDDING_SIZE
from .encoder_training import CONTEXT, IMAGE_MEAN, IMAGE_STD, Tokenizer, make_networks
from .segmenter_network import Segmenter

TOLERANCE = 1e-4
# Chosen on the validation set.
SCORE_THRESHOLD, IOU_THRESHOLD, ALPHA = 0.2, 0.5, 0.18
SENTENCES = ("red coffee mug", "get the coffee mug", "an image of a kitchen", "repair the bicycle",
             "something to read", "")

MODEL_SET = """\
# Demo models, trained on the simulation's own renders: for the demo and the tests, not for
# photographs. docs/demo_models.md tells what they can do; scripts/train_demo_models makes them.
name: demo
segmenter: segmenter.onnx
segmenter_score_threshold: {score}
segmenter_iou_threshold: {iou}
image_encoder: image_encoder.onnx
text_encoder: text_encoder.onnx
embedding_size: {size}
image_mean: [{mean}, {mean}, {mean}]
image_std: [{std}, {std}, {std}]
alpha: {alpha}
"""


def make_pattern(size):
    """A picture that C++ makes, too: 8-bit values (7 x + 13 y + 29 c + x y / 16) mod 256, /255."""
    y, x = np.mgrid[0:size, 0:size]
    channels = [(7 * x + 13 * y + 29 * c + x * y // 16) % 256 for c in range(3)]
    return torch.from_numpy(np.stack(channels)[None].astype(np.float32) / 255)


def load_networks(work):
    segmenter = Segmenter(SEGMENTER_SIZE)
    segmenter.load_state_dict(torch.load(work / "segmenter.pt", weights_only=True))
    saved = torch.load(work / "encoder.pt", weights_only=True)
    encoders = make_networks(saved["tokens"])
    encoders.load_state_dict(saved["state"])
    return segmenter.eval(), encoders["image"].eval(), encoders["text"].eval()


def export(network, example, path, output_names, batch_is_open):
    """Writes the file and returns PyTorch's outputs after comparing ONNX Runtime's with them."""
    axes = {name: {0: "n"} for name in ("input", *output_names)} if batch_is_open else None
    with warnings.catch_warnings(), torch.no_grad():
        warnings.simplefilter("ignore")
        torch.onnx.export(network, (example,), str(path), input_names=["input"],
                          output_names=list(output_names), dynamic_axes=axes, opset_version=14,
                          dynamo=False)
        expected = network(example)
    expected = [t.numpy() for t in (expected if isinstance(expected, tuple) else (expected,))]
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    for name, want, got in zip(output_names, expected,
                               session.run(None, {"input": example.numpy()})):
        error = np.abs(want - got).max() / max(1.0, np.abs(want).max())
        if not error <= TOLERANCE:
            raise RuntimeError(f"{path.name}: {name} differs by {error:.2e} from PyTorch's")
        print(f"[export] {path.name} {name} {list(got.shape)}: differs by {error:.1e}")
    return expected


def describe_reference(segmenter, image, texts):
    """A few of the segmenter's values are enough: boxes and scores of every 97th cell, and means."""
    predictions, prototypes = segmenter
    return {
        "sentences": list(SENTENCES), "texts": [row.tolist() for row in texts],
        "image": image[0].tolist(),
        "segmenter_cells": predictions[0, :5, ::97].T.tolist(),
        "prototype_means": prototypes[0].mean((1, 2)).tolist()}


def export_all(arguments):
    torch.set_num_threads(1)
    segmenter, image_encoder, text_encoder = load_networks(arguments.work)
    output = arguments.output
    output.mkdir(parents=True, exist_ok=True)
    segments = export(segmenter, make_pattern(SEGMENTER_SIZE), output / "segmenter.onnx",
                      ("output0", "output1"), batch_is_open=False)
    pattern = (make_pattern(CROP_SIZE) - IMAGE_MEAN) / IMAGE_STD
    image, = export(image_encoder, pattern.expand(3, -1, -1, -1).contiguous(),
                    output / "image_encoder.onnx", ("embedding",), batch_is_open=True)
    tokens = Tokenizer().encode(SENTENCES)
    assert tokens.shape[1] == CONTEXT
    texts, = export(text_encoder, tokens, output / "text_encoder.onnx", ("embedding",),
                    batch_is_open=True)
    (output / "models.yaml").write_text(MODEL_SET.format(
        score=SCORE_THRESHOLD, iou=IOU_THRESHOLD, size=EMBEDDING_SIZE, mean=IMAGE_MEAN,
        std=IMAGE_STD, alpha=ALPHA))
    arguments.reference.write_text(json.dumps(describe_reference(segments, image, texts)) + "\n")
