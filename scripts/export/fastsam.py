# SPDX-License-Identifier: BSD-3-Clause
"""FastSAM out of the user's own install of ultralytics."""
import os
import pathlib

import numpy

import checks
import networks

# FastSAM-s and -x are YOLOv8-seg of these sizes with one class.
CHOICES = {"fastsam-s": ("FastSAM-s.pt", "yolov8s-seg.yaml"), "fastsam-x": ("FastSAM-x.pt", "yolov8x-seg.yaml")}
CALIBRATION_SIZE_PX = 320


def load(choice, random_weights, views):
    try:
        import ultralytics
    except ImportError:
        raise SystemExit("ultralytics is not installed in this Python (pip install ultralytics); it is AGPL-3.0")
    if not random_weights:
        return ultralytics.FastSAM(CHOICES[choice][0] if choice in CHOICES else choice)
    from ultralytics.nn.tasks import SegmentationModel
    architecture = CHOICES[choice][1]
    yolo = ultralytics.YOLO(architecture)
    arguments = yolo.model.args
    yolo.model = SegmentationModel(architecture, nc=1, verbose=False)
    yolo.model.args, yolo.model.task = arguments, yolo.task
    networks.calibrate_batch_norm(yolo.model, to_tensor(views[:4], CALIBRATION_SIZE_PX))
    return yolo


def to_tensor(views, size_px):
    import torch
    arrays = [numpy.asarray(view.resize((size_px, size_px)), dtype=numpy.float32) / 255 for view in views]
    return torch.from_numpy(numpy.stack(arrays).transpose(0, 3, 1, 2).copy())


def find_tensors(output):
    """All tensors of a nested output: how they are nested changes with ultralytics' versions."""
    if hasattr(output, "shape"):
        return [output]
    if isinstance(output, dict):
        output = list(output.values())
    if not isinstance(output, (list, tuple)):
        return []
    return [tensor for part in output for tensor in find_tensors(part)]


def run_source(model, images, size_px):
    """Predictions [n, 37, A] and prototypes [n, 32, S/4, S/4]."""
    import torch
    with torch.no_grad():
        tensors = find_tensors(model.eval()(images))

    def pick(what, fits):
        found = [t for t in tensors if fits(tuple(t.shape))]
        if not found:
            raise checks.Mismatch("no %s among the model's outputs %s: is it FastSAM?" % (what, [list(t.shape) for t in tensors]))
        return found[0].numpy()

    return (pick("[n,37,A]", lambda shape: len(shape) == 3 and shape[1] == 37),
            pick("[n,32,S/4,S/4]", lambda shape: shape[1:] == (32, size_px // 4, size_px // 4)))


def export(yolo, views, size_px, folder, stem):
    """Writes and checks the network. Returns its file name and what was found."""
    images = to_tensor(views[:3], size_px)
    predictions, prototypes = run_source(yolo.model.float(), images, size_px)
    path = folder / (stem + ".onnx")
    # ultralytics writes beside the weights: give it a place of its own.
    yolo.model.pt_path = yolo.ckpt_path = str(folder / (stem + ".pt"))
    written = pathlib.Path(yolo.export(format="onnx", imgsz=size_px, opset=networks.OPSET, simplify=False, dynamic=False,
                                       nms=False, device="cpu"))
    if written.resolve() != path.resolve():
        os.replace(str(written), str(path))
    outputs = [checks.run_onnx(path, image[None].numpy()) for image in images]
    found = numpy.concatenate([out[0] for out in outputs])
    findings = [
        checks.compare_rows("segmenter, boxes", predictions[:, :4], found[:, :4], 1e-3),
        checks.compare_rows("segmenter, scores", predictions[:, 4:5], found[:, 4:5], 1e-3),
        checks.compare_rows("segmenter, mask coefficients", predictions[:, 5:], found[:, 5:], 1e-3),
        checks.compare_rows("segmenter, mask prototypes", prototypes, numpy.concatenate([out[1] for out in outputs]), 1e-3),
    ]
    return path.name, findings
