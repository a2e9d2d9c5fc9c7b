#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Segments and embeds one image with NumPy, Pillow and onnx's reference evaluator only:

recompute_segments.py MODELS.yaml IMAGE OUTPUT.npz

A second opinion on the segmenter, written from the formats' descriptions: plain, whole-image, slow.
The image has to fit the network's input in one direction (its longer side = the input's side), so
that no resize comes before the network. Crops are squashed to squares.
"""
import os
import sys

import numpy as np
import yaml
from onnx.reference import ReferenceEvaluator
from PIL import Image

PADDING_PX = 4
MIN_AREA_PX = 20


def load(folder, name):
    network = ReferenceEvaluator(os.path.join(folder, name))
    shape = network.proto_.graph.input[0].type.tensor_type.shape
    return network, shape.dim[-1].dim_value


def run(network, tensor):
    return network.run(None, {network.input_names[0]: tensor.astype(np.float32)})


def letterbox(image, side):
    height, width = image.shape[:2]
    if max(height, width) != side:
        raise SystemExit(f"image is {width}x{height}, expected {side} px on its longer side")
    top, left = (side - height) // 2, (side - width) // 2
    square = np.full((side, side, 3), 114, np.uint8)
    square[top:top + height, left:left + width] = image
    return square.transpose(2, 0, 1)[None] / np.float32(255), top, left


def box_iou(a, b):
    low, high = np.maximum(a[:2], b[:2]), np.minimum(a[2:], b[2:])
    common = np.prod(np.clip(high - low, 0, None))
    return common / (np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - common)


def suppress(boxes, scores, threshold):
    kept = []
    for i in np.argsort(-scores, kind="stable"):
        if all(box_iou(boxes[i], boxes[j]) <= threshold for j in kept):
            kept.append(i)
    return kept


def spread(size, wanted):
    """Cells below and the share of those above, for pixel centres at whole numbers plus one half."""
    at = np.clip((np.arange(wanted) + 0.5) * size / wanted - 0.5, 0, size - 1)
    low = np.minimum(at.astype(int), size - 2)
    return low, at - low


def upsample(plane, height, width):
    """Bilinear, borders repeated."""
    low, part = spread(plane.shape[0], height)
    rows = plane[low] * (1 - part)[:, None] + plane[low + 1] * part[:, None]
    low, part = spread(plane.shape[1], width)
    return rows[:, low] * (1 - part) + rows[:, low + 1] * part


def window_all(mask):
    """Erosion by 3x3; nothing lies outside the image."""
    padded = np.pad(mask, 1)
    height, width = mask.shape
    return np.all([padded[v:v + height, u:u + width] for v in range(3) for u in range(3)], axis=0)


def window_any(mask):
    padded = np.pad(mask, 1)
    height, width = mask.shape
    return np.any([padded[v:v + height, u:u + width] for v in range(3) for u in range(3)], axis=0)


def find_masks(models, folder, image):
    network, side = load(folder, models["segmenter"])
    tensor, top, left = letterbox(image, side)
    predictions, prototypes = run(network, tensor)
    predictions, prototypes = predictions[0].T, prototypes[0]
    predictions = predictions[predictions[:, 4] > models["segmenter_score_threshold"]]
    middle, half = predictions[:, :2], predictions[:, 2:4] / 2
    boxes = np.concatenate([middle - half, middle + half], axis=1)
    height, width = image.shape[:2]
    cell = side // prototypes.shape[1]  # the letterbox's padding is left out before enlarging
    prototypes = prototypes[:, top // cell:(top + height) // cell, left // cell:(left + width) // cell]
    u, v = np.meshgrid(np.arange(width) + left, np.arange(height) + top)
    found = []
    for i in suppress(boxes, predictions[:, 4], models["segmenter_iou_threshold"]):
        logits = upsample(np.tensordot(predictions[i, 5:], prototypes, 1), height, width)
        x0, y0, x1, y1 = boxes[i]
        inside = (u >= x0) & (u < x1) & (v >= y0) & (v < y1)
        mask = (logits > 0) & inside
        found.append((mask, predictions[i, 4]))
    return found


def paint(found, shape):
    owners = np.zeros(shape, int)
    order = sorted(range(len(found)), key=lambda i: -int(found[i][0].sum()))
    for i in order:
        owners[found[i][0]] = i + 1
    labels, scores = np.zeros(shape, np.uint16), []
    for i, (_, score) in enumerate(found):
        opened = window_any(window_all(owners == i + 1)) & (owners == i + 1)
        if opened.sum() < MIN_AREA_PX:
            continue
        scores.append(score)
        labels[opened] = len(scores)
    return labels, np.array(scores)


def embed(models, folder, image, labels, count):
    network, side = load(folder, models["image_encoder"])
    mean, deviation = np.array(models["image_mean"]), np.array(models["image_std"])
    height, width = labels.shape
    embeddings = []
    for label in range(1, count + 1):
        v, u = np.nonzero(labels == label)
        rows = slice(max(0, v.min() - PADDING_PX), min(height, v.max() + 1 + PADDING_PX))
        columns = slice(max(0, u.min() - PADDING_PX), min(width, u.max() + 1 + PADDING_PX))
        crop = image[rows, columns]
        masked = crop * (labels[rows, columns, None] == label).astype(np.uint8)
        squares = [np.asarray(Image.fromarray(c).resize((side, side), Image.BICUBIC)) / 255.0
                   for c in (crop, masked)]
        tensor = ((np.array(squares) - mean) / deviation).transpose(0, 3, 1, 2)
        total = run(network, tensor)[0].mean(0)
        embeddings.append(total / np.linalg.norm(total))
    return np.array(embeddings)


def main():
    path, image_path, output = sys.argv[1:]
    with open(path) as file:
        models = yaml.safe_load(file)
    folder = os.path.dirname(path)
    image = np.asarray(Image.open(image_path).convert("RGB"))
    labels, scores = paint(find_masks(models, folder, image), image.shape[:2])
    np.savez(output, labels=labels, scores=scores,
             embeddings=embed(models, folder, image, labels, len(scores)))


if __name__ == "__main__":
    main()
