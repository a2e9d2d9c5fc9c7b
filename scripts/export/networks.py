# SPDX-License-Identifier: BSD-3-Clause
"""PyTorch modules to ONNX files. Needs torch and onnx."""
import inspect
import os
import pathlib
import tempfile

OPSET = 17
MAX_SINGLE_FILE_BYTES = 1900 * 1000 * 1000  # an ONNX file cannot exceed 2 GB; larger ones keep weights beside it


def calibrate_batch_norm(model, images):
    """Sets the running statistics from images: without them a random network ignores its input."""
    import torch
    layers = [m for m in model.modules() if isinstance(m, torch.nn.modules.batchnorm._BatchNorm)]
    if not layers:
        return 0
    momenta = [layer.momentum for layer in layers]
    for layer in layers:
        layer.reset_running_stats()
        layer.momentum = None  # plain average
    model.train()
    with torch.no_grad():
        model(images)
    model.eval()
    for layer, momentum in zip(layers, momenta):
        layer.momentum = momentum
    return len(layers)


def count_bytes(module):
    return sum(p.numel() * p.element_size() for p in module.parameters())


def export(module, example, input_name, output_name, path):
    """Writes `module` as an ONNX file whose first sizes (of input and output) are open."""
    import torch
    # The fused attention has no ONNX counterpart.
    if hasattr(torch.backends, "mha"):
        torch.backends.mha.set_fastpath_enabled(False)
    options = {"dynamo": False} if "dynamo" in inspect.signature(torch.onnx.export).parameters else {}
    with tempfile.TemporaryDirectory(dir=str(path.parent)) as folder:
        raw = pathlib.Path(folder) / "network.onnx"
        with torch.no_grad():
            torch.onnx.export(module, (example,), str(raw), input_names=[input_name], output_names=[output_name],
                              dynamic_axes={input_name: {0: "batch"}, output_name: {0: "batch"}},
                              opset_version=OPSET, **options)
        if count_bytes(module) > MAX_SINGLE_FILE_BYTES:
            gather_weights(raw, path)
        else:
            os.replace(str(raw), str(path))


def gather_weights(raw, path):
    """Brings the weights, which torch spreads over one file per tensor, into one file beside the network's."""
    import onnx
    model = onnx.load(str(raw))
    onnx.save_model(model, str(path), save_as_external_data=True, all_tensors_to_one_file=True,
                    location=path.name + ".data", size_threshold=1024)
