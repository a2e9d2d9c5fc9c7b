#!/usr/bin/env python3
"""Writes the small networks that the tests of the text encoder run: test/unit/language/networks/*.onnx.

usage: make_text_encoders.py        Needs the Python packages onnx and numpy.

Shaped as CLIP's text towers: token ids [N,77] in, [N,12] out, read at the end mark (the largest id),
blind to what comes after it. Weights are sines, so that the test can compute them, too:
  hidden[p] = tanh(sin(1 + 8 (id % 61) + j) + cos(8 p + j) / 2),   j = 0..7
  output    = sum over p up to the end mark of hidden[p] * sin(0.3 + 12 j + k),   k = 0..11
"""
import pathlib

import numpy
import onnx
from onnx import TensorProto, helper, numpy_helper

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "unit" / "language" / "networks"
CONTEXT, WIDTH, SIZE, NUM_TOKENS = 77, 8, 12, 61


def make_weights():
    width = numpy.arange(WIDTH)
    return {
        "tokens": numpy.sin(1 + WIDTH * numpy.arange(NUM_TOKENS)[:, None] + width),
        "positions": numpy.cos(WIDTH * numpy.arange(CONTEXT)[:, None] + width) / 2,
        "projection": numpy.sin(0.3 + SIZE * width[:, None] + numpy.arange(SIZE)),
    }


def make_initializers():
    floats = {name: values.astype(numpy.float32) for name, values in make_weights().items()}
    integers = {"modulus": NUM_TOKENS, "axis_1": [1], "axis_2": [2], "axis": 1, "depth": CONTEXT}
    arrays = {**floats, **{name: numpy.array(v, dtype=numpy.int64) for name, v in integers.items()}}
    arrays["off_on"] = numpy.array([0, 1], dtype=numpy.float32)
    arrays["nan"] = numpy.array(numpy.nan, dtype=numpy.float32)
    return [numpy_helper.from_array(values, name) for name, values in arrays.items()]


def make_nodes(last_nodes):
    node = helper.make_node
    return [
        node("Cast", ["text"], ["ids"], to=TensorProto.INT64),
        node("Mod", ["ids", "modulus"], ["rows"]),
        node("Gather", ["tokens", "rows"], ["token_part"]),
        node("Add", ["token_part", "positions"], ["sum"]),
        node("Tanh", ["sum"], ["hidden"]),
        node("CumSum", ["hidden", "axis"], ["so_far"]),
        node("ArgMax", ["ids"], ["end"], axis=1, keepdims=0),
        node("OneHot", ["end", "depth", "off_on"], ["at_end"], axis=-1),
        node("Unsqueeze", ["at_end", "axis_2"], ["at_end_column"]),
        node("Mul", ["so_far", "at_end_column"], ["picked"]),
        node("ReduceSum", ["picked", "axis_1"], ["feature"], keepdims=0),
        node("MatMul", ["feature", "projection"], ["vector"]),
    ] + last_nodes


def write(name, element_type, batch, last_node, output_shape):
    text = helper.make_tensor_value_info("text", element_type, [batch, CONTEXT])
    output = helper.make_tensor_value_info("embedding", TensorProto.FLOAT, output_shape)
    graph = helper.make_graph(make_nodes([last_node]), name, [text], [output], make_initializers())
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 14)], ir_version=8)
    onnx.checker.check_model(model)
    FOLDER.mkdir(exist_ok=True)
    onnx.save(model, FOLDER / (name + ".onnx"))


def main():
    node = helper.make_node
    same = node("Identity", ["vector"], ["embedding"])
    write("text_encoder", TensorProto.INT64, "batch", same, ["batch", "size"])
    write("text_encoder_int32_batch4", TensorProto.INT32, 4, same, [4, SIZE])
    write("text_encoder_nan", TensorProto.INT64, "batch", node("Mul", ["vector", "nan"], ["embedding"]), ["batch", "size"])
    write("text_encoder_per_token", TensorProto.INT64, "batch", node("Identity", ["hidden"], ["embedding"]), ["batch", CONTEXT, WIDTH])
    write("text_encoder_float", TensorProto.FLOAT, "batch", same, ["batch", "size"])


if __name__ == "__main__":
    main()
