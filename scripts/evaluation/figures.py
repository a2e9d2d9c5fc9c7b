# SPDX-License-Identifier: BSD-3-Clause
"""Figures of results: scores as bars, and what they cost."""
import os

from . import results as stored
from .report import order, pick
from .worlds import LEVELS


def find_pyplot():
    """None without matplotlib."""
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    return plt


def save(plt, figure, path):
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw(results, folder):
    """Writes report.png and curves.png. @returns the names; none without matplotlib or results."""
    plt = find_pyplot()
    if plt is None or not results:
        return []
    for name, plot in (("report.png", plot_bars), ("curves.png", plot_curves)):
        save(plt, plot(plt, results), os.path.join(folder, name))
    return ["report.png", "curves.png"]


def find_levels(results):
    return sorted({result["level"] for result in results}, key=LEVELS.index)


def plot_bars(plt, results):
    """Strict F1, a row for each world and list of tasks, a column for each level of segments."""
    groups = stored.group(results)
    worlds = list(dict.fromkeys(world for world, _ in groups))
    levels = find_levels(results)
    figure, panels = plt.subplots(len(worlds), len(levels), sharey=True, squeeze=False,
                                  figsize=(3.6 * len(levels), 2.6 * len(worlds)))
    for row, world in zip(panels, worlds):
        for panel, level in zip(row, levels):
            by_method = groups.get((world, level))
            if by_method is None:
                panel.axis("off")
                continue
            names = order(by_method)
            cells = [stored.mean_and_deviation([pick(one, ("strict", "f1"))
                                                for one in by_method[name]]) for name in names]
            panel.bar(names, [mean for mean, _ in cells], yerr=[spread for _, spread in cells],
                      color=["tab:blue" if name.startswith("clio") else "0.6" for name in names])
            panel.set_title(f"{world}, {level}", fontsize=9)
            panel.tick_params(axis="x", rotation=70, labelsize=8)
            panel.set_ylim(0.0, 1.0)
        row[0].set_ylabel("strict F1")
    return figure


def plot_curves(plt, results):
    """Means over all worlds, a row for each level of segments: precision over recall, F1 over the
    objects kept for each true thing, and the time of each stage."""
    levels = find_levels(results)
    figure, panels = plt.subplots(len(levels), 3, squeeze=False, figsize=(13.0, 3.8 * len(levels)))
    for row, level in zip(panels, levels):
        by_method = {}
        for result in results:
            if result["level"] == level:
                by_method.setdefault(result["method"], []).append(result)
        plot_precision_recall(row[0], by_method)
        plot_kept(row[1], by_method)
        plot_times(row[2], by_method)
        row[0].set_title(f"segments {level}: precision over recall", fontsize=9)
        row[1].set_title("strict F1 over objects for each true thing", fontsize=9)
        row[2].set_title("ms for each frame, by stage", fontsize=9)
    return figure


def average_curve(rows):
    """[(recall, precision)] by falling least cosine. Above the highest cosine of a map nothing of it
    is left (of one without objects never): recall 0, and its precision does not count; below its
    lowest all is left."""
    curves = [{round(point["min_cosine"], 4): point for point in row["scores"]["precision_recall"]}
              for row in rows if "precision_recall" in row["scores"]]
    cosines = sorted({cosine for curve in curves for cosine in curve}, reverse=True)
    line = []
    for cosine in cosines:
        recalls, precisions = [], []
        for curve in curves:
            reached = [known for known in curve if known >= cosine]
            point = curve[min(reached)] if reached else None
            recalls.append(point["recall"] if point else 0.0)
            if point:
                precisions.append(point["precision"])
        line.append((sum(recalls) / len(recalls), sum(precisions) / len(precisions)))
    return line


def plot_precision_recall(panel, by_method):
    for method in order(by_method):
        line = average_curve(by_method[method])
        if line:
            panel.plot([recall for recall, _ in line], [precision for _, precision in line],
                       label=method, linewidth=2.0 if method == "clio" else 1.0)
    panel.set_xlim(0.0, 1.0)
    panel.set_ylim(0.0, 1.05)
    panel.legend(fontsize=7)


def plot_kept(panel, by_method):
    for method in order(by_method):
        rows = by_method[method]
        kept = [pick(row, ("num_objects",)) / (pick(row, ("num_true",)) or 1) for row in rows]
        scores = [pick(row, ("strict", "f1")) for row in rows]
        mean = (sum(kept) / len(kept), sum(scores) / len(scores))
        panel.plot(*mean, marker="o", color="tab:blue" if method.startswith("clio") else "0.4")
        panel.annotate(method, mean, fontsize=7, xytext=(4, 3), textcoords="offset points")
    panel.margins(x=0.25)
    panel.set_xlim(left=0.0)
    panel.set_ylim(0.0, 1.0)


def plot_times(panel, by_method):
    """Of methods that share a front end one is enough."""
    shown = {}
    for method in order(by_method):
        stages = [row["stages"] for row in by_method[method] if row.get("stages")]
        if stages:
            mean = {name: sum(one.get(name, 0.0) for one in stages) / len(stages)
                    for name in stages[0]}
            shown.setdefault(tuple(sorted(mean.items())), (method, mean))
    names = sorted({name for _, mean in shown.values() for name in mean})
    left = [0.0] * len(shown)
    for name in names:
        values = [mean.get(name, 0.0) for _, mean in shown.values()]
        panel.barh([method for method, _ in shown.values()], values, left=left, label=name)
        left = [a + b for a, b in zip(left, values)]
    panel.invert_yaxis()
    panel.tick_params(axis="y", labelsize=8)
    if names:
        panel.legend(fontsize=7, loc="upper right")
        limit = 2.0 * sorted(left)[len(left) // 2]  # what takes much longer is cut off and labelled
        panel.set_xlim(0.0, limit)
        for i, total in enumerate(left):
            if total > limit:
                panel.text(0.5 * limit, i, f"{total:.0f} ms", ha="center", va="center", color="white")
