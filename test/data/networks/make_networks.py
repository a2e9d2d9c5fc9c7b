#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the networks of the segmentation tests beside this file (needs the PyPI package onnx).

They have FastSAM's and CLIP's signatures and a closed form, so that the tests know the right answer:
the segmenters find red, green and blue regions, the encoders map a crop's mean colour linearly.
"""
import os

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

FOLDER = os.path.dirname(os.path.abspath(__file__))
FLOAT = TensorProto.FLOAT

# One column per anchor: cx, cy, w, h, score, weights of the prototypes red, green, blue, 1.
ANCHORS = np.array([
    [32, 32, 64, 64, 0.90, 1, -1, -1, -0.1],
    [32, 32, 63, 63, 0.80, -1, 1, -1, -0.1],
    [32, 32, 62, 62, 0.30, -1, -1, 1, -0.1],
    [32, 32, 20, 20, 0.05, 0, 0, 0, 1.0],
], np.float32).T[None]
EMBEDDING_WEIGHTS = np.array([[1, 0, 0, 0.5], [0, 1, 0, 0.5], [0, 0, 1, 0.5]], np.float32)
EMBEDDING_BIAS = np.array([0.25, 0.25, 0.25, 1.0], np.float32)


def constant(name, value):
    return numpy_helper.from_array(np.asarray(value), name)


def save(name, nodes, inputs, outputs, initializers):
    graph = helper.make_graph(nodes, name, [helper.make_tensor_value_info(*i) for i in inputs],
                              [helper.make_tensor_value_info(*o) for o in outputs], initializers)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    onnx.checker.check_model(model)
    onnx.save(model, os.path.join(FOLDER, name + ".onnx"))


def prototype_nodes(image):
    """[1,3,S,S] -> [1,4,S/4,S/4]: the colours, averaged over 4x4 pixels, and a plane of ones."""
    return [
        helper.make_node("AveragePool", [image], ["pooled"], kernel_shape=[4, 4], strides=[4, 4]),
        helper.make_node("ReduceMean", ["pooled"], ["grey"], axes=[1], keepdims=1),
        helper.make_node("Mul", ["grey", "zero"], ["zeros"]),
        helper.make_node("Add", ["zeros", "one"], ["ones"]),
        helper.make_node("Concat", ["pooled", "ones"], ["output1"], axis=1),
    ]


def save_segmenter(name, size, anchors):
    grid = size // 4 if isinstance(size, int) else None
    save(name,
         [helper.make_node("Identity", ["anchors"], ["output0"])] + prototype_nodes("images"),
         [("images", FLOAT, [1, 3, size, size])],
         [("output0", FLOAT, list(anchors.shape)), ("output1", FLOAT, [1, 4, grid, grid])],
         [constant("anchors", anchors), constant("zero", np.float32(0)),
          constant("one", np.float32(1))])


def save_slow_segmenter():
    """Black and grey images take no time, a white one takes hours: 1e9 matrix products."""
    body = helper.make_graph(
        [helper.make_node("MatMul", ["carried", "matrix"], ["product"]),
         helper.make_node("Identity", ["go_on"], ["go_on_out"])],
        "body",
        [helper.make_tensor_value_info("i", TensorProto.INT64, []),
         helper.make_tensor_value_info("go_on", TensorProto.BOOL, []),
         helper.make_tensor_value_info("carried", FLOAT, [16, 16])],
        [helper.make_tensor_value_info("go_on_out", TensorProto.BOOL, []),
         helper.make_tensor_value_info("product", FLOAT, [16, 16])])
    nodes = prototype_nodes("images") + [
        helper.make_node("ReduceMax", ["images"], ["brightest"], keepdims=0),
        helper.make_node("Sub", ["brightest", "half"], ["above"]),
        helper.make_node("Relu", ["above"], ["positive"]),
        helper.make_node("Mul", ["positive", "many"], ["times"]),
        helper.make_node("Cast", ["times"], ["count"], to=TensorProto.INT64),
        helper.make_node("Loop", ["count", "true", "matrix"], ["last"], body=body),
        helper.make_node("ReduceMean", ["last"], ["mean"], keepdims=0),
        helper.make_node("Mul", ["mean", "zero"], ["nothing"]),
        helper.make_node("Add", ["anchors", "nothing"], ["output0"]),
    ]
    save("slow_segmenter", nodes, [("images", FLOAT, [1, 3, 64, 64])],
         [("output0", FLOAT, [1, 9, 4]), ("output1", FLOAT, [1, 4, 16, 16])],
         [constant("anchors", ANCHORS), constant("zero", np.float32(0)),
          constant("one", np.float32(1)), constant("half", np.float32(0.5)),
          constant("many", np.float32(2e9)), constant("true", np.array(True)),
          constant("matrix", np.eye(16, dtype=np.float32))])


def save_encoder(name, batch, size, bias):
    save(name,
         [helper.make_node("GlobalAveragePool", ["image"], ["mean"]),
          helper.make_node("Flatten", ["mean"], ["flat"]),
          helper.make_node("Gemm", ["flat", "weights", "bias"], ["embedding"])],
         [("image", FLOAT, [batch, 3, size, size])], [("embedding", FLOAT, [batch, 4])],
         [constant("weights", EMBEDDING_WEIGHTS), constant("bias", bias)])


def save_half_encoder():
    """The small encoder with half floats from input to output, as `half=True` exports give."""
    save("encoder_float16",
         [helper.make_node("GlobalAveragePool", ["image"], ["mean"]),
          helper.make_node("Flatten", ["mean"], ["flat"]),
          helper.make_node("Gemm", ["flat", "weights", "bias"], ["embedding"])],
         [("image", TensorProto.FLOAT16, ["batch", 3, 8, 8])],
         [("embedding", TensorProto.FLOAT16, ["batch", 4])],
         [constant("weights", EMBEDDING_WEIGHTS.astype(np.float16)),
          constant("bias", EMBEDDING_BIAS.astype(np.float16))])


def save_int8_encoder():
    """The small encoder as dynamic quantisation leaves it: weights and products of 8-bit integers."""
    save("encoder_int8",
         [helper.make_node("GlobalAveragePool", ["image"], ["mean"]),
          helper.make_node("Flatten", ["mean"], ["flat"]),
          helper.make_node("DynamicQuantizeLinear", ["flat"], ["levels", "step", "zero_level"]),
          helper.make_node("MatMulInteger", ["levels", "weights", "zero_level"], ["products"]),
          helper.make_node("Cast", ["products"], ["sums"], to=FLOAT),
          helper.make_node("Mul", ["step", "weight_step"], ["scale"]),
          helper.make_node("Mul", ["sums", "scale"], ["scaled"]),
          helper.make_node("Add", ["scaled", "bias"], ["embedding"])],
         [("image", FLOAT, ["batch", 3, 8, 8])], [("embedding", FLOAT, ["batch", 4])],
         [constant("weights", np.round(EMBEDDING_WEIGHTS * 100).astype(np.int8)),
          constant("weight_step", np.float32(0.01)), constant("bias", EMBEDDING_BIAS)])


def main():
    save_segmenter("segmenter", 64, ANCHORS)
    save_segmenter("segmenter_open_size", "size", ANCHORS)
    save_segmenter("segmenter_two_outputs_wrong", 64, ANCHORS[:, :7])
    nan_anchors = ANCHORS.copy()
    nan_anchors[:, 4] = np.nan
    save_segmenter("segmenter_nan", 64, nan_anchors)
    save_slow_segmenter()
    save_encoder("encoder", "batch", 8, EMBEDDING_BIAS)
    save_encoder("encoder_open_size", "batch", "size", EMBEDDING_BIAS)
    save_encoder("encoder_two_at_once", 2, 8, EMBEDDING_BIAS)
    save_half_encoder()
    save_int8_encoder()
    save_encoder("encoder_infinite", "batch", 8, EMBEDDING_BIAS * np.float32(np.inf))
    save_encoder("encoder_nan", "batch", 8, EMBEDDING_BIAS * np.float32(np.nan))


if __name__ == "__main__":
    main()
