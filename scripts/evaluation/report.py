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
]


def pick(result, path, mode="paper"):
    value = result["scores"][mode]
    for key in path:
        value = value[key]
    return value


def format_cell(values):
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
        times = [row["ms_per_frame"] for row in rows if row.get("ms_per_frame") is not None]
        cells.append(format_cell(times) if times else "")
        lines.append("| " + " | ".join([method] + cells) + " |")
    return "\n".join(lines)


def make_report(results, command):
    parts = ["# Objects against the truth", "", f"Made by `{command}`; mean ± sample deviation.", ""]
    for (world, level), by_method in stored.group(results).items():
        count = max(len(rows) for rows in by_method.values())
        recordings = "recording" if count == 1 else "recordings"
        parts += [f"## {world}, segments: {level} ({count} {recordings})", "",
                  make_table(by_method), ""]
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


def plot(results, path):
    """Bars of strict F1, a panel for each world and level. Returns False without matplotlib."""
    try:
        import matplotlib
    except ImportError:
        return False
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    groups = stored.group(results)
    figure, panels = plt.subplots(1, len(groups), figsize=(3.2 * len(groups), 3.4), sharey=True,
                                  squeeze=False)
    for panel, ((world, level), by_method) in zip(panels[0], groups.items()):
        names = order(by_method)
        cells = [stored.mean_and_deviation([pick(row, ("strict", "f1")) for row in by_method[name]])
                 for name in names]
        panel.bar(names, [mean for mean, _ in cells], yerr=[spread for _, spread in cells])
        panel.set_title(f"{world}\n{level}", fontsize=9)
        panel.tick_params(axis="x", rotation=70, labelsize=8)
        panel.set_ylim(0.0, 1.0)
    panels[0][0].set_ylabel("strict F1")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return True
