# SPDX-License-Identifier: BSD-3-Clause
"""Measures the exported model set on apartments that were not trained on, with the package's own
segmenter and text encoder (the programs segment_images and encode_tasks)."""
import json
import subprocess
from collections import Counter
from dataclasses import dataclass, field

import cv2
import numpy as np
import yaml

from . import vocabulary
from .data import ROOM_SHARE

MIN_PIXELS = 400  # of the 640x480 image
CROP_FIT = "squash"
SETS = ("validation", "test_own", "test_held_out")
IOU_STEPS = tuple(np.arange(0.5, 0.96, 0.05))


@dataclass
class Results:
    """What was found in one set of views."""
    ious: list = field(default_factory=list)  # of each thing's best segment
    scores: list = field(default_factory=list)  # of segments
    hits: dict = field(default_factory=lambda: {t: [] for t in IOU_STEPS})  # of segments
    things: list = field(default_factory=list)  # (phrase, colour, embedding) of things found
    rooms: list = field(default_factory=list)  # (room, embedding)
    candidates: dict = field(default_factory=dict)  # apartment -> (thing or None, embedding)s


def segment(programs, models, folder, output, config):
    """Runs the segmenter over a folder of renders, a few hundred files at a time."""
    output.mkdir(parents=True, exist_ok=True)
    settings = output / "segmenter.yaml"
    settings.write_text(yaml.safe_dump(config))
    images = sorted(str(p) for p in folder.glob("*.color.png"))
    for first in range(0, len(images), 200):
        subprocess.run([programs / "segment_images", "--models", models, "--output", output, "--data",
                        "--config", settings, *images[first:first + 200]], check=True,
                       stdout=subprocess.DEVNULL)


def encode(programs, models, sentences, path):
    """Unit rows, one per sentence."""
    path.with_suffix(".in.yaml").write_text(yaml.safe_dump(list(sentences), allow_unicode=True))
    subprocess.run([programs / "encode_tasks", "--models", models, "--tasks",
                    path.with_suffix(".in.yaml"), "--output", path], check=True,
                   stdout=subprocess.DEVNULL)
    tasks = yaml.load(path.read_text(), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))["tasks"]
    return np.array([t["embedding"] for t in tasks])


def compute_overlaps(truth, found):
    """IoU of each true id with each segment, both counted from 1, and the true ids' pixels."""
    num_true, num_found = int(truth.max()), int(found.max())
    joint = np.bincount(truth.ravel().astype(np.int64) * (num_found + 1) + found.ravel(),
                        minlength=(num_true + 1) * (num_found + 1))
    joint = joint.reshape(num_true + 1, num_found + 1)
    union = joint.sum(1, keepdims=True) + joint.sum(0, keepdims=True) - joint
    return (joint / np.maximum(union, 1))[1:, 1:], joint.sum(1)[1:]


def match(iou, scores, threshold, candidates):
    """Segments by falling score take the best thing left; a segment that fits a thing too small to
    count counts neither way (None)."""
    free = np.ones(iou.shape[0], bool)
    hits = {}
    for segment_index in np.argsort(-scores, kind="stable"):
        column = np.where(free, iou[:, segment_index], 0.0)
        best = int(column.argmax()) if len(column) else 0
        if len(column) == 0 or column[best] < threshold:
            hits[segment_index] = False
            continue
        free[best] = False
        hits[segment_index] = True if candidates[best] else None
    return [hits[i] for i in range(len(scores))]


def list_candidates(found, iou, instances, embeddings):
    """What a text may be answered with: every segment that is large enough, and the (phrase, colour)
    that it shows (None: nothing, or half of something)."""
    for index, embedding in enumerate(embeddings):
        if np.count_nonzero(found == index + 1) <= MIN_PIXELS:
            continue
        best = int(iou[:, index].argmax()) if len(iou) else 0
        shows = len(iou) > 0 and iou[best, index] >= 0.5
        thing = instances[best + 1] if shows else None
        yield thing and (thing["phrase"], thing["color"]), embedding


def collect_view(folder, output, view, instances, results):
    truth = cv2.imread(str(folder / f"{view['name']}.labels.png"), cv2.IMREAD_UNCHANGED)
    stem = output / f"{view['name']}.color"
    found = cv2.imread(f"{stem}.labels.png", cv2.IMREAD_UNCHANGED)
    found_data = json.loads(output.joinpath(f"{view['name']}.color.json").read_text())
    scores = np.array(found_data["scores"])
    iou, pixels = compute_overlaps(truth, found)
    iou = iou[:, :len(scores)] if iou.shape[1] >= len(scores) else np.pad(
        iou, ((0, 0), (0, len(scores) - iou.shape[1])))
    counts = pixels > MIN_PIXELS
    for index in np.flatnonzero(counts):
        best = int(iou[index].argmax()) if len(scores) else 0
        value = float(iou[index, best]) if len(scores) else 0.0
        results.ious.append(value)
        if value >= 0.5:
            thing = instances[index + 1]
            results.things.append((thing["phrase"], thing["color"], found_data["embeddings"][best]))
    apartment = view["name"].rsplit("_", 1)[0]
    results.candidates.setdefault(apartment, []).extend(
        list_candidates(found, iou, instances, found_data["embeddings"]))
    results.scores += scores.tolist()
    for threshold in IOU_STEPS:
        results.hits[threshold] += match(iou, scores, threshold, counts)
    room, share = max(view["rooms"].items(), key=lambda entry: entry[1])
    if share > ROOM_SHARE:
        results.rooms.append((room, found_data["image_embedding"]))


def collect(folder, output):
    results = Results()
    for path in sorted(folder.glob("*.json")):
        info = json.loads(path.read_text())
        instances = {i["id"]: i for i in info["instances"]}
        for view in info["views"]:
            collect_view(folder, output, view, instances, results)
    return results


def compute_average_precision(scores, hits, num_true):
    """Area under precision over recall, precision made monotonic."""
    kept = [(s, h) for s, h in zip(scores, hits) if h is not None]
    kept.sort(key=lambda entry: -entry[0])
    good = np.cumsum([h for _, h in kept])
    precision = good / np.arange(1, len(kept) + 1)
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    steps = np.diff(np.concatenate(([0], good))) / max(1, num_true)
    return float((precision * steps).sum())


def measure_masks(results):
    precisions = {t: compute_average_precision(results.scores, results.hits[t], len(results.ious))
                  for t in IOU_STEPS}
    counted = [h for h in results.hits[0.5] if h is not None]
    return {"things": len(results.ious),
            "recall_iou_0.5": float(np.mean(np.array(results.ious) >= 0.5)),
            "recall_iou_0.75": float(np.mean(np.array(results.ious) >= 0.75)),
            "ap_0.5": precisions[0.5], "ap_0.5_0.95": float(np.mean(list(precisions.values()))),
            "precision": float(np.mean(counted)) if counted else 0.0}


def measure_ranking(vectors, truth, names, texts):
    """Share whose best text is the true one, per true name, and the most frequent mistakes."""
    best = [names[i] for i in (np.array(vectors) @ texts.T).argmax(1)]
    right = [b == t for b, t in zip(best, truth)]
    mistakes = Counter((t, b) for b, t in zip(best, truth) if b != t)
    totals = Counter(truth)
    return {"things": len(truth), "top_1": float(np.mean(right)),
            "mean_over_classes": float(np.mean([
                np.mean([r for r, t in zip(right, truth) if t == name]) for name in totals])),
            "mistakes": [f"{t} -> {b}: {n} of {totals[t]}"
                         for (t, b), n in mistakes.most_common(15)]}


def measure_retrieval(candidates, is_asked, texts, vectors):
    """Share of texts whose best segment, of all in an apartment, shows what the text names. Asked
    is each apartment for what some segment of it shows. `is_asked`: (phrase, colour) -> text or
    None; `texts`: index of each text in the rows of `vectors`."""
    right = []
    mistakes = Counter()
    for segments in candidates.values():
        names = [thing and is_asked(*thing) for thing, _ in segments]
        embeddings = np.array([e for _, e in segments])
        for text in sorted({n for n in names if n is not None}):
            best = int((embeddings @ vectors[texts[text]]).argmax())
            right.append(names[best] == text)
            if not right[-1]:
                shown = segments[best][0]
                mistakes[f"{text} -> {' '.join(reversed(shown)) if shown else 'nothing'}"] += 1
    return {"questions": len(right), "top_1": float(np.mean(right)) if right else 0.0,
            "mistakes": [f"{name}: {n}" for name, n in mistakes.most_common(15)]}


def measure_threshold(vectors, truth, names, texts, alpha):
    """Shares of cosines above alpha of what fits and of what does not."""
    cosines = np.array(vectors) @ texts.T
    fits = np.array([[n == t for n in names] for t in truth])
    return {"alpha": alpha, "fitting_above": float((cosines[fits] > alpha).mean()),
            "others_above": float((cosines[~fits] > alpha).mean()),
            "fitting_median": float(np.median(cosines[fits])),
            "others_median": float(np.median(cosines[~fits]))}


class Texts:
    """Sentences of the three vocabularies, embedded."""

    def __init__(self, arguments, models, info_files):
        things = [(i["phrase"], i["color"]) for path in info_files
                  for i in json.loads(path.read_text())["instances"]]
        things += [(phrase, color) for color, phrase in vocabulary.HELD_OUT_PAIRS]
        self.classes = sorted({phrase for phrase, _ in things})
        self.pairs = vocabulary.list_phrases(things)
        self.rooms = list(vocabulary.ROOMS)
        embed = lambda sentences, name: encode(arguments.programs, models, sentences,
                                               arguments.work / f"texts_{name}.yaml")
        self.class_vectors = embed([f"{c}" for c in self.classes], "classes")
        self.task_vectors = embed([f"get the {c}" for c in self.classes], "tasks")
        self.pair_vectors = embed(self.pairs, "pairs")
        self.room_vectors = embed(self.rooms, "rooms")


def measure(results, texts, alpha):
    vectors = [np.array(v) / max(1e-9, np.linalg.norm(v)) for _, _, v in results.things]
    phrases = [phrase for phrase, _, _ in results.things]
    pairs = [(v, f"{c} {p}") for v, (p, c, _) in zip(vectors, results.things)
             if vocabulary.is_held_out(p, c)]
    seen = [(v, f"{c} {p}") for v, (p, c, _) in zip(vectors, results.things)
            if not vocabulary.is_held_out(p, c) and vocabulary.color_of(p, c) is not None]
    report = {"masks": measure_masks(results),
              "object": measure_ranking(vectors, phrases, texts.classes, texts.class_vectors),
              "object_from_task": measure_ranking(vectors, phrases, texts.classes,
                                                  texts.task_vectors),
              "threshold": measure_threshold(vectors, phrases, texts.classes, texts.task_vectors,
                                             alpha)}
    for name, entries in (("unseen_pairs", pairs), ("seen_pairs", seen)):
        if entries:
            report[name] = measure_ranking([v for v, _ in entries], [p for _, p in entries],
                                           texts.pairs, texts.pair_vectors)
    report["retrieval"] = measure_retrieval(
        results.candidates, lambda phrase, color: phrase,
        {c: i for i, c in enumerate(texts.classes)}, texts.task_vectors)
    for name, unseen in (("retrieval_unseen_pairs", True), ("retrieval_seen_pairs", False)):
        report[name] = measure_retrieval(
            results.candidates,
            lambda phrase, color: f"{color} {phrase}" if vocabulary.color_of(phrase, color) is not None
            and vocabulary.is_held_out(phrase, color) == unseen else None,
            {p: i for i, p in enumerate(texts.pairs)}, texts.pair_vectors)
    rooms = [np.array(v) / max(1e-9, np.linalg.norm(v)) for _, v in results.rooms]
    room_names = [room for room, _ in results.rooms]
    report["rooms"] = measure_ranking(rooms, room_names, texts.rooms, texts.room_vectors)
    report["room_threshold"] = measure_threshold(rooms, room_names, texts.rooms, texts.room_vectors,
                                                 alpha)
    return report


TABLE = (  # row of the model card, path in the report
    ("mask recall at IoU 0.5, things over 400 px", "masks", "recall_iou_0.5"),
    ("mask recall at IoU 0.75", "masks", "recall_iou_0.75"),
    ("precision at IoU 0.5", "masks", "precision"),
    ("AP at IoU 0.5", "masks", "ap_0.5"), ("AP at IoU 0.5:0.95", "masks", "ap_0.5_0.95"),
    ("text to object, kinds: top-1", "retrieval", "top_1"),
    ("text to object, seen pairs of colour and kind: top-1", "retrieval_seen_pairs", "top_1"),
    ("text to object, unseen pairs: top-1", "retrieval_unseen_pairs", "top_1"),
    ("object to text, kinds: top-1", "object_from_task", "top_1"),
    ("object to text, seen pairs: top-1", "seen_pairs", "top_1"),
    ("object to text, unseen pairs: top-1", "unseen_pairs", "top_1"),
    ("true tasks above alpha", "threshold", "fitting_above"),
    ("other tasks above alpha", "threshold", "others_above"),
    ("view to room: top-1", "rooms", "top_1"))


def format_table(report):
    lines = ["| | " + " | ".join(report) + " |", "|---|" + "---|" * len(report)]
    for title, part, key in TABLE:
        count = lambda r: r[part].get("questions", r[part].get("things", ""))
        cells = [f"{r[part][key]:.3f} ({count(r)})" if part in r else "" for r in report.values()]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def evaluate_all(arguments):
    models = arguments.output / "models.yaml"
    alpha = yaml.safe_load(models.read_text())["alpha"]
    folders = {name: arguments.work / "data" / name for name in SETS}
    texts = Texts(arguments, models, [p for f in folders.values() for p in f.glob("*.json")])
    report = {}
    for name, folder in folders.items():
        output = arguments.work / "segments" / name
        segment(arguments.programs, models, folder, output, {"encoder": {"fit": CROP_FIT}})
        report[name] = measure(collect(folder, output), texts, alpha)
        print(f"[evaluate] {name}: " + json.dumps(report[name], indent=1), flush=True)
    (arguments.output / "metrics.json").write_text(json.dumps(report, indent=1) + "\n")
    print(format_table(report))
