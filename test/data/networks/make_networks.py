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
INT64 = TensorProto.INT64

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


def scalar_of_bad_images(bad):
    """0 for most images; for those that are bright somewhere NaN or inf, for those that are bright
    all over an error of the run."""
    if bad == "error":
        return [
            helper.make_node("ReduceMin", ["image"], ["darkest"], keepdims=0),
            helper.make_node("Greater", ["darkest", "bright"], ["is_bright"]),
            helper.make_node("Cast", ["is_bright"], ["index"], to=INT64),
            helper.make_node("Gather", ["only_zero", "index"], ["scalar"]),
        ]
    nodes = [
        helper.make_node("ReduceMax", ["image"], ["brightest"], keepdims=0),
        helper.make_node("Sub", ["brightest", "bright"], ["above"]),
    ]
    if bad == "infinite":
        return nodes + [
            helper.make_node("Relu", ["above"], ["positive"]),
            helper.make_node("Mul", ["positive", "huge"], ["large"]),
            helper.make_node("Mul", ["large", "huge"], ["scalar"]),
        ]
    return nodes + [
        helper.make_node("Neg", ["above"], ["below"]),
        helper.make_node("Sqrt", ["below"], ["root"]),
        helper.make_node("Mul", ["root", "zero"], ["scalar"]),
    ]


def bad_image_constants(bright):
    return [constant("bright", np.float32(bright)), constant("huge", np.float32(1e30)),
            constant("zero", np.float32(0)), constant("only_zero", np.zeros(1, np.float32))]


def save_segmenter_with_bad_images(name, bad):
    save(name, scalar_of_bad_images(bad) + prototype_nodes("image")
         + [helper.make_node("Add", ["anchors", "scalar"], ["output0"])],
         [("image", FLOAT, [1, 3, 64, 64])],
         [("output0", FLOAT, [1, 9, 4]), ("output1", FLOAT, [1, 4, 16, 16])],
         bad_image_constants(0.9) + [constant("anchors", ANCHORS), constant("one", np.float32(1))])


def save_encoder_with_bad_images(name, bad):
    save(name, scalar_of_bad_images(bad) + encoder_nodes("image", "finite")
         + [helper.make_node("Add", ["finite", "scalar"], ["embedding"])],
         [("image", FLOAT, ["batch", 3, 8, 8])], [("embedding", FLOAT, ["batch", 4])],
         bad_image_constants(1.0) + encoder_constants())


def save_segmenter_with_anchors_first():
    """The small segmenter's numbers, [1,A,5+K], with as many candidates as a 64 px input has."""
    anchors = np.zeros((1, 84, 9), np.float32)
    anchors[0, :, 0] = anchors[0, :, 1] = np.linspace(1, 63, 84)
    anchors[0, :4] = ANCHORS[0].T
    save("segmenter_anchors_first",
         [helper.make_node("Identity", ["anchors"], ["output0"])] + prototype_nodes("images"),
         [("images", FLOAT, [1, 3, 64, 64])],
         [("output0", FLOAT, [1, 84, 9]), ("output1", FLOAT, [1, 4, 16, 16])],
         [constant("anchors", anchors), constant("zero", np.float32(0)),
          constant("one", np.float32(1))])


def save_segmenter_with_more_outputs():
    """The small segmenter with prototypes first, and an output that is not needed."""
    save("segmenter_more_outputs",
         prototype_nodes("images") + [helper.make_node("Identity", ["anchors"], ["output0"]),
                                      helper.make_node("Flatten", ["pooled"], ["features"])],
         [("images", FLOAT, [1, 3, 64, 64])],
         [("output1", FLOAT, [1, 4, 16, 16]), ("features", FLOAT, [1, 768]),
          ("output0", FLOAT, [1, 9, 4])],
         [constant("anchors", ANCHORS), constant("zero", np.float32(0)),
          constant("one", np.float32(1))])


def save_zeros(name, inputs, outputs):
    """Outputs of these shapes, all zero: for layouts that are refused."""
    nodes, constants = [], []
    for i, (output, _, shape) in enumerate(outputs):
        constants.append(constant("shape%d" % i, np.array(shape, np.int64)))
        nodes.append(helper.make_node("ConstantOfShape", ["shape%d" % i], [output]))
    save(name, nodes, inputs, outputs, constants)


def save_other_segmenters():
    image = ("images", FLOAT, [1, 3, 640, 640])
    prototypes = ("output1", FLOAT, [1, 32, 160, 160])
    for name, shape in (("nms", [1, 300, 38]), ("yolov5", [1, 25200, 117]),
                        ("anchors_first_80", [1, 8400, 116]), ("zero_boxes", [1, 37, 8400])):
        save_zeros("segmenter_" + name, [image], [("output0", FLOAT, shape), prototypes])
    save_zeros("segmenter_boxes_only", [image], [("output0", FLOAT, [1, 84, 8400])])
    fastsam = [("output0", FLOAT, [1, 37, 8400]), prototypes]
    save_zeros("segmenter_channels_last", [("images", FLOAT, [1, 640, 640, 3])], fastsam)
    save_zeros("segmenter_uint8", [("images", TensorProto.UINT8, [1, 3, 640, 640])], fastsam)
    save_zeros("segmenter_batch4", [("images", FLOAT, [4, 3, 640, 640])], fastsam)
    save_zeros("segmenter_wide", [("images", FLOAT, [1, 3, 480, 640])], fastsam)


def size_nodes(image, count):
    """`nothing`: 0, and an error of the run for images of another size than the file should say."""
    return [helper.make_node("Reshape", [image, count], ["all_values"]),
            helper.make_node("ReduceMean", ["all_values"], ["mean_value"], keepdims=0),
            helper.make_node("Mul", ["mean_value", "zero"], ["nothing"])]


def save_networks_of_one_size():
    """Files that leave their size open and work with one only, as networks with a table of positions."""
    zero = constant("zero", np.float32(0))
    save("segmenter_only_64",
         prototype_nodes("images") + size_nodes("images", "count")
         + [helper.make_node("Add", ["anchors", "nothing"], ["output0"])],
         [("images", FLOAT, [1, 3, "height", "width"])],
         [("output0", FLOAT, [1, 9, 4]), ("output1", FLOAT, [1, 4, None, None])],
         [constant("anchors", ANCHORS), zero, constant("one", np.float32(1)),
          constant("count", np.array([3 * 64 * 64]))])
    save("encoder_only_8",
         encoder_nodes("image", "finite") + size_nodes("image", "count")
         + [helper.make_node("Add", ["finite", "nothing"], ["embedding"])],
         [("image", FLOAT, [1, 3, "height", "width"])], [("embedding", FLOAT, [1, 4])],
         encoder_constants() + [zero, constant("count", np.array([3 * 8 * 8]))])


def encoder_nodes(image, embedding):
    return [helper.make_node("GlobalAveragePool", [image], ["mean"]),
            helper.make_node("Flatten", ["mean"], ["flat"]),
            helper.make_node("Gemm", ["flat", "weights", "bias"], [embedding])]


def encoder_constants():
    return [constant("weights", EMBEDDING_WEIGHTS), constant("bias", EMBEDDING_BIAS)]


def save_encoder_with_outputs(name, outputs):
    """The small encoder; outputs named: embedding, with a dimension of 1 more, or patches."""
    nodes = encoder_nodes("pixel_values", "row")
    shapes = {"row": ["batch", 4], "column": ["batch", 4, 1], "patches": ["batch", 3, 4]}
    infos = []
    for output, kind in outputs:
        infos.append((output, FLOAT, shapes[kind]))
        if kind == "row":
            nodes.append(helper.make_node("Identity", ["row"], [output]))
        else:
            nodes.append(helper.make_node("Unsqueeze", ["row", "two" if kind == "column" else "one"],
                                          [output + "_1"]))
            nodes.append(helper.make_node("Tile", [output + "_1", "once" if kind == "column" else "thrice"],
                                          [output]))
    save(name, nodes, [("pixel_values", FLOAT, ["batch", "channels", "height", "width"])], infos,
         encoder_constants() + [constant("one", np.array([1])), constant("two", np.array([2])),
                                constant("once", np.array([1, 1, 1])),
                                constant("thrice", np.array([1, 3, 1]))])


def save_other_encoders():
    embedding = [("embedding", FLOAT, [1, 4])]
    save_zeros("encoder_channels_last", [("image", FLOAT, [1, 8, 8, 3])], embedding)
    save_zeros("encoder_uint8", [("image", TensorProto.UINT8, [1, 3, 8, 8])], embedding)
    save_zeros("encoder_wide", [("image", FLOAT, [1, 3, 8, 12])], embedding)
    save_encoder_with_outputs("encoder_named", [("last_hidden_state", "patches"), ("other", "row"),
                                                ("image_embeds", "row")])
    save_encoder_with_outputs("encoder_column", [("features", "column")])
    save_encoder_with_outputs("encoder_hidden", [("last_hidden_state", "patches")])
    save_encoder_with_outputs("encoder_pooler", [("last_hidden_state", "patches"),
                                                 ("pooler_output", "row")])
    save_encoder_with_outputs("encoder_ambiguous", [("first", "row"), ("second", "row")])


def save_encoder(name, batch, size, bias):
    save(name, encoder_nodes("image", "embedding"),
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
    save_segmenter_with_anchors_first()
    save_segmenter_with_more_outputs()
    save_other_segmenters()
    save_other_encoders()
    save_networks_of_one_size()
    for bad in ("nan", "infinite", "error"):
        save_encoder_with_bad_images("encoder_%s_on_bright" % bad, bad)
    for bad in ("nan", "error"):
        save_segmenter_with_bad_images("segmenter_%s_on_bright" % bad, bad)


if __name__ == "__main__":
    main()
