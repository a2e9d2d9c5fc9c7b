# SPDX-License-Identifier: BSD-3-Clause
"""One parameter at a time around the defaults: what it does to the scores.

Parameters of the clustering are studied on the primitives of the default map, clustered at once;
those of the tracker on maps of their own."""
import collections
import os

from . import chain, figures, methods, results

# default: None where the default is none of the values (the tracker's learned cosine).
# options: of cluster_scene_graph, for a value; config: what process_bag's --config holds, likewise.
Parameter = collections.namedtuple("Parameter", "name values default options config")


def option(name, *more):
    return lambda value: [f"--{name}", str(value)] + list(more)


def tracker(name, **more):
    return lambda value: {"tracker": dict(more, **{name: value})}


PARAMETERS = [
    Parameter("alpha", [0.17, 0.20, 0.22, 0.23, 0.24, 0.26, 0.28], 0.23, option("alpha"), None),
    Parameter("delta", [0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1], 1e-5, option("delta"), None),
    Parameter("delta_bits", [0.001, 0.01, 0.03, 0.1, 0.3], None,
              option("delta", "--normaliser", "size_invariant"), None),
    Parameter("top_k", [1, 2, 3, 5, 10], 2, option("top-k"), None),
    Parameter("prior", ["uniform", "marginal"], "uniform", option("prior"), None),
    Parameter("reach", [0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4], 0.1, option("reach"), None),
    Parameter("min_cosine", [0.7, 0.8, 0.85, 0.9, 0.95], None, None,
              tracker("min_cosine", adapt_cosine=False)),
    Parameter("min_iou", [0.2, 0.4, 0.6, 0.8], 0.6, None, tracker("min_iou")),
    Parameter("min_observations", [1, 2, 3, 5], 2, None, tracker("min_observations")),
    Parameter("window_s", [1.0, 3.0, 5.0, 15.0], 5.0, None, tracker("window_s")),
]


def find_parameters(names):
    return methods.find_named(PARAMETERS, names, "parameter")


def make_map(run, recording, tasks, parameter, value, folder, base):
    """The map of one value. The clustering's default is a value like the others."""
    target = os.path.join(folder, "study", f"{parameter.name}_{value}")
    if parameter.options is not None:
        return chain.cluster(run, base, tasks, parameter.options(value), target)
    if value == parameter.default:
        return base
    return chain.process_bag(run, recording, tasks, parameter.config(value), target)


def score(run, recording, tasks, level, parameter, folder, say):
    """A row of each value that is not there yet."""
    base = chain.make_map(run, recording, tasks.tasks, "default", folder)
    for value in parameter.values:
        path = os.path.join(folder, "study", f"{parameter.name}_{value}.study.json")
        if os.path.exists(path):
            continue
        made = make_map(run, recording, tasks.tasks, parameter, value, folder, base)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        # Only what a study tells is scored.
        bare = recording._replace(rooms="", mesh="")
        scores = chain.evaluate(run, bare, tasks._replace(labels=""), made,
                                path.replace(".study.json", ".scores.json"), keep=methods.NAMED)
        paper = scores["paper"]
        results.write(path, {"world": tasks.world, "level": level, "recording": recording.name,
                             "parameter": parameter.name, "value": value,
                             "f1": paper["strict"]["f1"], "relaxed_f1": paper["relaxed"]["f1"],
                             "iou": paper["iou"], "num_objects": paper["num_objects"]})
        say(f"{tasks.world}, {recording.name} {parameter.name} {value}: strict F1 "
            f"{paper['strict']['f1']:.3f}, {paper['num_objects']} objects")


def load_rows(folder):
    """Every row in a folder. Raises ValueError naming what is none."""
    return results.load_all(folder, ".study.json")


def collect(rows, parameter):
    """{value: [row of each recording]}, of those recordings that have every value that any has."""
    by_recording = {}
    for row in rows:
        if row["parameter"] == parameter.name:
            key = (row["world"], row["recording"])
            by_recording.setdefault(key, {})[row["value"]] = row
    values = [value for value in parameter.values
              if any(value in found for found in by_recording.values())]
    whole = [found for found in by_recording.values() if len(found) == len(values)]
    return {value: [found[value] for found in whole] for value in values} if whole else {}


def make_table(rows, parameter):
    """Means over the recordings; None without any."""
    by_value = collect(rows, parameter)
    if not by_value:
        return None
    count = len(next(iter(by_value.values())))
    lines = [f"| {parameter.name} | F1 strict | F1 relaxed | IoU | objects |", "|---|---|---|---|---|"]
    for value, found in by_value.items():
        mark = " (default)" if value == parameter.default else ""
        cells = [results.mean_and_deviation([row[key] for row in found])[0]
                 for key in ("f1", "relaxed_f1", "iou", "num_objects")]
        lines.append(f"| {value}{mark} | " + " | ".join(f"{cell:.3f}" for cell in cells[:3]) +
                     f" | {cells[3]:.1f} |")
    return "\n".join(lines + ["", f"Means over {count} pairs of a recording and a list of tasks."
                              if count > 1 else "One recording, one list of tasks."])


def make_report(rows, command):
    parts = ["# Parameters, one at a time", "", f"Made by `{command}`.", ""]
    for parameter in PARAMETERS:
        table = make_table(rows, parameter)
        if table is not None:
            parts += [f"## {parameter.name}", "", table, ""]
    return "\n".join(parts)


def plot_parameter(panel, parameter, by_value):
    """Strict F1 of each recording and its mean; the number of objects on the other side."""
    places = range(len(by_value))
    columns = list(by_value.values())
    for i in range(len(columns[0])):
        panel.plot(places, [found[i]["f1"] for found in columns], color="0.75", linewidth=0.8)
    means = [results.mean_and_deviation([row["f1"] for row in found])[0] for found in columns]
    panel.plot(places, means, color="tab:blue", marker="o", linewidth=2.0)
    objects = panel.twinx()
    counts = [results.mean_and_deviation([row["num_objects"] for row in found])[0]
              for found in columns]
    objects.plot(places, counts, color="tab:orange", linestyle="--", marker=".")
    objects.set_ylim(bottom=0.0)
    objects.tick_params(axis="y", labelsize=7, colors="tab:orange")
    panel.set_xticks(list(places))
    panel.set_xticklabels([str(value) for value in by_value], rotation=45, fontsize=7)
    if parameter.default in by_value:
        panel.axvline(list(by_value).index(parameter.default), color="0.5", linestyle=":")
    panel.set_title(parameter.name, fontsize=9)
    panel.set_ylim(0.0, 1.0)


def plot(rows, path):
    """A panel for each parameter. Returns False without matplotlib."""
    plt = figures.find_pyplot()
    if plt is None:
        return False
    studied = [(parameter, collect(rows, parameter)) for parameter in PARAMETERS]
    studied = [(parameter, by_value) for parameter, by_value in studied if by_value]
    if not studied:
        return False
    height = (len(studied) + 2) // 3
    figure, panels = plt.subplots(height, min(3, len(studied)), squeeze=False,
                                  figsize=(4.0 * min(3, len(studied)), 3.0 * height))
    for panel in panels.flat[len(studied):]:
        panel.axis("off")
    for panel, (parameter, by_value) in zip(panels.flat, studied):
        plot_parameter(panel, parameter, by_value)
    for row in panels:
        row[0].set_ylabel("strict F1 (dashed: objects)", fontsize=8)
    figures.save(plt, figure, path)
    return True


def write_report(folder, command, say):
    rows = load_rows(folder)
    results.write(os.path.join(folder, "study.json"), {"command": command, "rows": rows})
    path = os.path.join(folder, "study.md")
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(make_report(rows, command))
    os.replace(path + ".part", path)
    figure = os.path.join(folder, "study.png")
    say(f"{path}: {len(rows)} values" + (f"; {figure}" if plot(rows, figure) else
                                          "; no figure without python3-matplotlib"))
