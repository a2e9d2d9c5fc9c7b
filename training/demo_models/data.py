# SPDX-License-Identifier: BSD-3-Clause
"""Rendered views -> arrays in a cache folder: images and labels for the segmenter, crops for the
image encoder."""
import json
import multiprocessing
import random
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from . import vocabulary

SEGMENTER_SIZE = 384
CONTENT_ROWS = 288  # of a 4:3 image in the letterbox
CROP_SIZE = 64
CROP_PADDING = 4
MIN_SEGMENT_PIXELS = 100  # of the 640x480 image; smaller things are no target
MIN_IGNORED_PIXELS = 30  # nor background down to here
MIN_CROP_PIXELS = 250
ROOM_SHARE = 0.6
CENTER_CROP_SHARE = 0.25


@dataclass
class Views:
    """Letterbox contents [N, 288, 384, 3], index maps [N, 288, 384] (0 = structure, k = k-th thing),
    and per view an array [things, 5] of boxes x0 y0 x1 y1 (pixels of the content) and 1 = target,
    0 = to be ignored."""
    images: np.ndarray
    labels: np.ndarray
    things: list


@dataclass
class Crops:
    """Pairs of crops [N, 2, 64, 64, 3] (box; box with the background black) with phrase and colour;
    whole views have an empty phrase and a room."""
    images: np.ndarray
    phrases: list
    colors: list
    rooms: list


def read_view(folder, name):
    color = cv2.cvtColor(cv2.imread(str(folder / f"{name}.color.png")), cv2.COLOR_BGR2RGB)
    labels = cv2.imread(str(folder / f"{name}.labels.png"), cv2.IMREAD_UNCHANGED)
    return color, labels


def find_boxes(labels):
    """{instance id: (x0, y0, x1, y1, pixels)}, ends exclusive."""
    boxes = {}
    counts = np.bincount(labels.ravel())
    for value in np.flatnonzero(counts[1:]) + 1:
        mask = labels == value
        columns, rows = np.flatnonzero(mask.any(0)), np.flatnonzero(mask.any(1))
        boxes[int(value)] = (int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1,
                             int(counts[value]))
    return boxes


def letterbox_view(color, labels, boxes, instances):
    scale = SEGMENTER_SIZE / color.shape[1]
    size = (SEGMENTER_SIZE, CONTENT_ROWS)
    index_of = np.zeros(int(labels.max()) + 1, np.uint8)
    things = []
    for value, (x0, y0, x1, y1, pixels) in boxes.items():
        thing = instances[value]
        if pixels < MIN_IGNORED_PIXELS or len(things) == 255:
            continue
        target = pixels >= MIN_SEGMENT_PIXELS and not vocabulary.is_held_out(
            thing["phrase"], thing["color"])
        things.append((x0 * scale, y0 * scale, x1 * scale, y1 * scale, float(target)))
        index_of[value] = len(things)
    small = cv2.resize(index_of[labels], size, interpolation=cv2.INTER_NEAREST)
    image = cv2.resize(color, size, interpolation=cv2.INTER_LINEAR)
    return image, small, np.array(things, np.float32).reshape(-1, 5)


def fit_crop(crop, center_crop):
    """To a square, as the segmenter does: bicubic as Pillow's."""
    if not center_crop:
        return np.asarray(Image.fromarray(crop).resize((CROP_SIZE, CROP_SIZE), Image.BICUBIC))
    height, width = crop.shape[:2]
    scale = CROP_SIZE / min(height, width)
    size = (max(CROP_SIZE, int(width * scale)), max(CROP_SIZE, int(height * scale)))
    left, top = (size[0] - CROP_SIZE) // 2, (size[1] - CROP_SIZE) // 2
    resized = Image.fromarray(crop).resize(size, Image.BICUBIC)
    return np.asarray(resized.crop((left, top, left + CROP_SIZE, top + CROP_SIZE)))


def disturb_mask(rng, mask):
    """Segmenters miss borders: a mask a little larger, smaller or rougher."""
    kind = rng.random()
    if kind < 0.3:
        return mask
    size = rng.choice((3, 3, 5))
    kernel = np.ones((size, size), np.uint8)
    if kind < 0.65:
        return cv2.dilate(mask, kernel)
    eroded = cv2.erode(mask, kernel)
    return eroded if eroded.sum() > 0.5 * mask.sum() else mask


def cut_crops(rng, color, labels, value, box, disturb):
    """The pair of crops [2, 64, 64, 3] of one instance."""
    x0, y0, x1, y1, _ = box
    near = slice(max(0, y0 - 64), y1 + 64), slice(max(0, x0 - 64), x1 + 64)
    x0, x1 = x0 - near[1].start, x1 - near[1].start
    y0, y1 = y0 - near[0].start, y1 - near[0].start
    color, mask = color[near], (labels[near] == value).astype(np.uint8)
    pad = [CROP_PADDING] * 4
    if disturb:
        mask = disturb_mask(rng, mask)
        reach = 0.04 * max(x1 - x0, y1 - y0)
        pad = [CROP_PADDING + round(min(60.0, rng.uniform(-reach, reach))) for _ in range(4)]
    height, width = mask.shape
    x0, y0 = max(0, x0 - pad[0]), max(0, y0 - pad[1])
    x1, y1 = min(width, x1 + pad[2]), min(height, y1 + pad[3])
    crop = np.ascontiguousarray(color[y0:y1, x0:x1])
    masked = crop * mask[y0:y1, x0:x1, None]
    center = disturb and rng.random() < CENTER_CROP_SHARE
    return np.stack([fit_crop(crop, center), fit_crop(masked, center)])


def process_apartment(job):
    """All of one apartment: segmenter views and crops."""
    path, disturb = job
    folder = path.parent
    info = json.loads(path.read_text())
    instances = {i["id"]: i for i in info["instances"]}
    rng = random.Random(info["seed"])
    views, crops = [], []
    for view in info["views"]:
        color, labels = read_view(folder, view["name"])
        boxes = find_boxes(labels)
        views.append(letterbox_view(color, labels, boxes, instances))
        for value, box in boxes.items():
            thing = instances[value]
            if box[4] < MIN_CROP_PIXELS or vocabulary.is_held_out(thing["phrase"], thing["color"]):
                continue
            pair = cut_crops(rng, color, labels, value, box, disturb)
            crops.append((pair, thing["phrase"], thing["color"], ""))
        room, share = max(view["rooms"].items(), key=lambda entry: entry[1])
        if share > ROOM_SHARE:
            whole = fit_crop(color, disturb and rng.random() < CENTER_CROP_SHARE)
            crops.append((np.stack([whole, whole]), "", "", room))
    return views, crops


def load(folder, cache, disturb, processes):
    """(Views, Crops) of a folder that render_apartments wrote; made once, then read from `cache`."""
    cache = Path(cache)
    if not (cache / "info.json").exists():
        build(Path(folder), cache, disturb, processes)
    info = json.loads((cache / "info.json").read_text())
    things = [np.array(t, np.float32).reshape(-1, 5) for t in info["things"]]
    images = np.load(cache / "images.npy", mmap_mode="r")
    labels = np.load(cache / "labels.npy", mmap_mode="r")
    crops = np.load(cache / "crops.npy", mmap_mode="r")
    return (Views(images, labels, things),
            Crops(crops, info["phrases"], info["colors"], info["rooms"]))


def build(folder, cache, disturb, processes):
    cache.mkdir(parents=True, exist_ok=True)
    jobs = [(path, disturb) for path in sorted(folder.glob("*.json"), key=lambda p: int(p.stem))]
    views, crops = [], []
    with multiprocessing.Pool(processes) as pool:
        for done, (v, c) in enumerate(pool.imap(process_apartment, jobs), 1):
            views += v
            crops += c
            if done % 50 == 0:
                print(f"[data] {done}/{len(jobs)} apartments, {len(crops)} crops", flush=True)
    np.save(cache / "images.npy", np.stack([v[0] for v in views]))
    np.save(cache / "labels.npy", np.stack([v[1] for v in views]))
    np.save(cache / "crops.npy", np.stack([c[0] for c in crops]))
    (cache / "info.json").write_text(json.dumps({
        "things": [v[2].tolist() for v in views], "phrases": [c[1] for c in crops],
        "colors": [c[2] for c in crops], "rooms": [c[3] for c in crops]}))
