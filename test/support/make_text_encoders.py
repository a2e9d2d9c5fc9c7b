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


def make_initializers(context):
    floats = {name: values.astype(numpy.float32) for name, values in make_weights().items()}
    floats["positions"] = floats["positions"][:context]
    integers = {"modulus": NUM_TOKENS, "axis_1": [1], "axis_2": [2], "axis": 1, "depth": context}
    arrays = {**floats, **{name: numpy.array(v, dtype=numpy.int64) for name, v in integers.items()}}
    arrays["off_on"] = numpy.array([0, 1], dtype=numpy.float32)
    arrays["nan"] = numpy.array(numpy.nan, dtype=numpy.float32)
    return [numpy_helper.from_array(values, name) for name, values in arrays.items()]


def make_nodes(last_nodes, text="text"):
    node = helper.make_node
    return [
        node("Cast", [text], ["ids"], to=TensorProto.INT64),
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


def make_masked_nodes():
    """The same sum, over the positions where the mask is 1, of texts of any length."""
    node = helper.make_node
    return [
        node("Cast", ["input_ids"], ["ids"], to=TensorProto.INT64),
        node("Mod", ["ids", "modulus"], ["rows"]),
        node("Gather", ["tokens", "rows"], ["token_part"]),
        node("Shape", ["ids"], ["shape"]),
        node("Gather", ["shape", "axis_1"], ["length"]),
        node("Slice", ["positions", "axis_0", "length"], ["some_positions"]),
        node("Add", ["token_part", "some_positions"], ["sum"]),
        node("Tanh", ["sum"], ["hidden"]),
        node("Cast", ["attention_mask"], ["mask"], to=TensorProto.FLOAT),
        node("Unsqueeze", ["mask", "axis_2"], ["mask_column"]),
        node("Mul", ["hidden", "mask_column"], ["picked"]),
        node("ReduceSum", ["picked", "axis_1"], ["feature"], keepdims=0),
        node("MatMul", ["feature", "projection"], ["vector"]),
    ]


def save(name, nodes, inputs, outputs, initializers):
    infos = [helper.make_tensor_value_info(*i) for i in inputs], [helper.make_tensor_value_info(*o) for o in outputs]
    graph = helper.make_graph(nodes, name, infos[0], infos[1], initializers)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 14)], ir_version=8)
    onnx.checker.check_model(model)
    FOLDER.mkdir(exist_ok=True)
    onnx.save(model, FOLDER / (name + ".onnx"))


def write(name, element_type, batch, last_node, output_shape, context=CONTEXT):
    save(name, make_nodes([last_node]), [("text", element_type, [batch, context])],
         [("embedding", TensorProto.FLOAT, output_shape)], make_initializers(context))


def write_outputs(name, outputs):
    """Outputs named: the embedding, or the hidden states."""
    node = helper.make_node
    shapes = {"vector": ["batch", SIZE], "hidden": ["batch", CONTEXT, WIDTH]}
    save(name, make_nodes([node("Identity", [kind], [output]) for output, kind in outputs], "input_ids"),
         [("input_ids", TensorProto.INT64, ["batch", CONTEXT])],
         [(output, TensorProto.FLOAT, shapes[kind]) for output, kind in outputs], make_initializers(CONTEXT))


def write_masked(name, element_type, further_inputs=()):
    """As Hugging Face's exports: ids and mask, all sizes open."""
    node = helper.make_node
    names = ["attention_mask", "input_ids"] + list(further_inputs)
    initializers = make_initializers(CONTEXT) + [numpy_helper.from_array(numpy.array([0]), "axis_0")]
    save(name, make_masked_nodes() + [node("Identity", ["vector"], ["text_embeds"])],
         [(n, element_type, ["batch", "length"]) for n in names],
         [("text_embeds", TensorProto.FLOAT, ["batch", SIZE])], initializers)


def write_both_towers():
    """A whole CLIP, as Hugging Face's `model.onnx`: an image's embedding is its mean colour, projected."""
    node = helper.make_node
    image_nodes = [
        node("GlobalAveragePool", ["pixel_values"], ["mean_color"]),
        node("Flatten", ["mean_color"], ["color"]),
        node("MatMul", ["color", "color_projection"], ["image_embeds"]),
        node("Identity", ["vector"], ["text_embeds"]),
        node("Transpose", ["text_embeds"], ["text_columns"], perm=[1, 0]),
        node("MatMul", ["image_embeds", "text_columns"], ["logits_per_image"]),
        node("Transpose", ["logits_per_image"], ["logits_per_text"], perm=[1, 0]),
    ]
    color_projection = numpy.sin(0.3 + SIZE * numpy.arange(3)[:, None] + numpy.arange(SIZE)).astype(numpy.float32)
    initializers = make_initializers(CONTEXT) + [numpy_helper.from_array(numpy.array([0]), "axis_0"),
                                                 numpy_helper.from_array(color_projection, "color_projection")]
    texts = ["text_batch", "length"]
    save("clip_both_towers", make_masked_nodes() + image_nodes,
         [("input_ids", TensorProto.INT64, texts),
          ("pixel_values", TensorProto.FLOAT, ["image_batch", "channels", "height", "width"]),
          ("attention_mask", TensorProto.INT64, texts)],
         [("logits_per_image", TensorProto.FLOAT, ["image_batch", "text_batch"]),
          ("logits_per_text", TensorProto.FLOAT, ["text_batch", "image_batch"]),
          ("text_embeds", TensorProto.FLOAT, ["text_batch", SIZE]),
          ("image_embeds", TensorProto.FLOAT, ["image_batch", SIZE])], initializers)


def main():
    node = helper.make_node
    same = node("Identity", ["vector"], ["embedding"])
    write("text_encoder", TensorProto.INT64, "batch", same, ["batch", "size"])
    write("text_encoder_int32_batch4", TensorProto.INT32, 4, same, [4, SIZE])
    write("text_encoder_nan", TensorProto.INT64, "batch", node("Mul", ["vector", "nan"], ["embedding"]), ["batch", "size"])
    write("text_encoder_per_token", TensorProto.INT64, "batch", node("Identity", ["hidden"], ["embedding"]), ["batch", CONTEXT, WIDTH])
    write("text_encoder_float", TensorProto.FLOAT, "batch", same, ["batch", "size"])
    write("text_encoder_64", TensorProto.INT64, "batch", same, ["batch", "size"], context=64)
    write("text_encoder_same_for_all", TensorProto.INT64, 1, node("ReduceMean", ["projection"], ["embedding"], axes=[0]), [1, SIZE])
    write_outputs("text_encoder_named", [("last_hidden_state", "hidden"), ("pooler_output", "vector"), ("text_embeds", "vector")])
    write_outputs("text_encoder_pooler", [("last_hidden_state", "hidden"), ("pooler_output", "vector")])
    write_outputs("text_encoder_hidden_named_embeds", [("text_embeds", "hidden"), ("other", "vector")])
    write_outputs("text_encoder_ambiguous", [("first", "vector"), ("second", "vector")])
    write_masked("text_encoder_mask", TensorProto.INT64)
    write_masked("text_encoder_mask_int32", TensorProto.INT32)
    write_masked("text_encoder_bert", TensorProto.INT64, ["token_type_ids"])
    write_both_towers()


if __name__ == "__main__":
    main()
