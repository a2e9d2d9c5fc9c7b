# SPDX-License-Identifier: BSD-3-Clause
"""Tables of results in Markdown, and what changed between two of them."""
from . import results as stored
from .methods import METHODS

# heading: path into the scores
COLUMNS = [
    ("osR strict", ("strict", "recall")),
    ("osP strict", ("strict", "precision")),
    ("F1 strict", ("strict", "f1")),
    ("osR relaxed", ("relaxed", "recall")),
    ("osP relaxed", ("relaxed", "precision")),
    ("F1 relaxed", ("relaxed", "f1")),
    ("IoU", ("iou",)),
    ("Objs", ("num_objects",)),
    ("false", ("num_false",)),
]
REGION_COLUMNS = [("precision", "precision"), ("recall", "recall"), ("F1", "f1"),
                  ("regions", "num_regions"), ("rooms", "num_rooms")]
GOAL_COLUMNS = [("success", "success"), ("right object", "right"), ("strict", "strict"),
                ("path", "path"), ("free", "free"), ("path / shortest", "median_ratio"),
                ("SPL", "spl"), ("tasks", "num_tasks")]
CLASS_COLUMNS = [("mAcc", "mean_accuracy"), ("mIoU", "mean_iou"), ("F-mIoU", "weighted_iou"),
                 ("classes", "num_classes")]


def pick(result, path, mode="paper"):
    """None where an older result does not tell."""
    value = result["scores"][mode]
    for key in path:
        value = value.get(key)
        if value is None:
            break
    return value


def format_cell(values):
    values = [value for value in values if value is not None]
    if not values:
        return ""
    mean, deviation = stored.mean_and_deviation(values)
    digits = 1 if mean > 1.5 else 3
    text = f"{mean:.{digits}f}"
    return text if len(values) == 1 else f"{text} ± {deviation:.{digits}f}"


def order(methods):
    names = [method.name for method in METHODS]
    return sorted(methods, key=lambda name: names.index(name) if name in names else len(names))


def make_table(by_method, mode="paper"):
    heads = ["method"] + [head for head, _ in COLUMNS] + ["TPF (ms)"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for method in order(by_method):
        rows = by_method[method]
        cells = [format_cell([pick(row, path, mode) for row in rows]) for _, path in COLUMNS]
        cells.append(format_cell([row.get("ms_per_frame") for row in rows]))
        lines.append("| " + " | ".join([method] + cells) + " |")
    return "\n".join(lines)


def make_part_table(groups, part, columns):
    """A part of the scores, such as regions, of each method; None where nothing has it."""
    heads = ["world", "segments", "method"] + [head for head, _ in columns]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for (world, level), by_method in groups.items():
        for method in order(by_method):
            scored = [row["scores"][part] for row in by_method[method] if part in row["scores"]]
            if scored:
                cells = [format_cell([row[key] for row in scored]) for _, key in columns]
                lines.append("| " + " | ".join([world, level, method] + cells) + " |")
    return "\n".join(lines) if len(lines) > 2 else None


def make_calibration_table(groups):
    """Share of right objects by cosine, of each method over everything; None where not told."""
    sums = {}
    for by_method in groups.values():
        for method, rows in by_method.items():
            for row in rows:
                for item in row["scores"].get("calibration", {}).get("bins", []):
                    count = sums.setdefault(method, {}).setdefault(round(item["low"], 4), [0, 0])
                    count[0] += item["num_right"]
                    count[1] += item["num_objects"]
    if not sums:
        return None
    lows = sorted({low for counts in sums.values() for low in counts})
    lines = ["| method | " + " | ".join(f"from {low:.2f}" for low in lows) + " |",
             "|" + "---|" * (len(lows) + 1)]
    for method in order(sums):
        cells = []
        for low in lows:
            right, total = sums[method].get(low, [0, 0])
            cells.append(f"{right / total:.2f} of {total}" if total else "")
        lines.append("| " + " | ".join([method] + cells) + " |")
    return "\n".join(lines)


def make_frames_table(results):
    """What the live chain dropped; None where nothing was made live."""
    lines = ["| world | segments | recording | method | frames | missing in the map | segmented ones not tracked |",
             "|---|---|---|---|---|---|---|"]
    for row in results:
        if row.get("frames"):
            used, untracked, recorded = row["frames"]
            cells = [row["world"], row["level"], row["recording"], row["method"], str(recorded),
                     str(recorded - used), str(untracked)]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) if len(lines) > 2 else None


def make_report(results, command):
    parts = ["# Objects against the truth", "", f"Made by `{command}`; mean ± sample deviation.", ""]
    groups = stored.group(results)
    for (world, level), by_method in groups.items():
        count = max(len(rows) for rows in by_method.values())
        recordings = "recording" if count == 1 else "recordings"
        parts += [f"## {world}, segments: {level} ({count} {recordings})", "",
                  make_table(by_method), ""]
    for heading, table in (("Regions against rooms",
                            make_part_table(groups, "regions", REGION_COLUMNS)),
                           ("Going to things", make_part_table(groups, "goals", GOAL_COLUMNS)),
                           ("Classes of the mesh's vertices",
                            make_part_table(groups, "classes", CLASS_COLUMNS)),
                           ("Share of right objects by cosine", make_calibration_table(groups)),
                           ("Frames of the live chain", make_frames_table(results))):
        if table is not None:
            parts += [f"## {heading}", "", table, ""]
    return "\n".join(parts)


def compare(before, after):
    """Lines: strict F1 of each group and method in both."""
    old = stored.group(before)
    lines = ["| world | segments | method | F1 strict before | after | change |", "|---|---|---|---|---|---|"]
    for key, by_method in stored.group(after).items():
        for method in order(by_method):
            rows = old.get(key, {}).get(method)
            if not rows:
                continue
            path = ("strict", "f1")
            was, _ = stored.mean_and_deviation([pick(row, path) for row in rows])
            now, _ = stored.mean_and_deviation([pick(row, path) for row in by_method[method]])
            lines.append(f"| {key[0]} | {key[1]} | {method} | {was:.3f} | {now:.3f} | {now - was:+.3f} |")
    return "\n".join(lines)
