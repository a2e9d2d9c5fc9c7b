#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Prints the values that the resampling and crop tests expect, computed with Pillow and NumPy.

CLIP's own preprocessing is torchvision's Resize(BICUBIC) and CenterCrop on a Pillow image; what those
two do with sizes is written out here.
"""
import numpy as np
from PIL import Image

RESIZES = [((40, 30), (17, 11)), ((40, 30), (64, 48)), ((13, 90), (3, 5)), ((7, 5), (7, 9)),
           ((1, 1), (8, 8)), ((160, 120), (31, 24))]
CROPS = [((0, 0, 97, 61), 32), ((10, 5, 20, 50), 32), ((3, 7, 60, 13), 32), ((90, 55, 7, 6), 32)]


def pattern(width, height):
    u, v, c = np.meshgrid(np.arange(width), np.arange(height), np.arange(3), indexing="xy")
    value = (u * 7 + v * 13 + c * 29 + (u * v) // 5 + ((u // 9) ^ (v // 7)) * 31) % 256
    return value.astype(np.uint8)


def checksums(pixels):
    flat = pixels.astype(np.int64).ravel()
    return int(flat.sum()), int((flat * (1 + np.arange(flat.size) % 1009)).sum())


def center_crop(crop, size):
    height, width = crop.shape[:2]
    shorter, longer = min(width, height), max(width, height)
    resized_longer = int(size * longer / shorter)
    target = (size, resized_longer) if width <= height else (resized_longer, size)
    left = int(round((target[0] - size) / 2.0))
    top = int(round((target[1] - size) / 2.0))
    resized = np.asarray(Image.fromarray(crop).resize(target, Image.BICUBIC))
    return resized[top:top + size, left:left + size]


def main():
    print("resizes: source, resized, sum, weighted sum")
    for (width, height), target in RESIZES:
        result = np.asarray(Image.fromarray(pattern(width, height)).resize(target, Image.BICUBIC))
        print("  {{%d, %d}, {%d, %d}, %d, %d}," % ((width, height) + target + checksums(result)))
    image = pattern(97, 61)
    labels = ((np.arange(97)[None] // 5 + np.arange(61)[:, None] // 4) % 3).astype(np.uint16)
    print("crops of 97x61: box, sums of center_crop, of it with label 2 only, of squash")
    for (x, y, width, height), size in CROPS:
        crop = image[y:y + height, x:x + width]
        masked = crop * (labels[y:y + height, x:x + width, None] == 2).astype(np.uint8)
        squashed = np.asarray(Image.fromarray(crop).resize((size, size), Image.BICUBIC))
        print("  {{%d, %d, %d, %d}, {%d, %d}, {%d, %d}, {%d, %d}}," % (
            (x, y, width, height) + checksums(center_crop(crop, size)) +
            checksums(center_crop(masked, size)) + checksums(squashed)))


if __name__ == "__main__":
    main()
