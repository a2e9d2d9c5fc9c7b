#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws what long_walk_benchmark wrote, with and without archiving.

usage: plot_long_walk.py archived.csv kept.csv docs/images/long_walk.png
"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def read_columns(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    runs = [(read_columns(sys.argv[1]), "far blocks archived (default)", "tab:blue"),
            (read_columns(sys.argv[2]), "all voxels kept", "tab:orange")]
    figure, (time_axis, memory_axis) = plt.subplots(1, 2, figsize=(9, 3.2))
    for run, label, color in runs:
        total_ms = [a + b for a, b in zip(run["integration_ms"], run["mesh_ms"])]
        time_axis.plot(run["minute"], total_ms, color=color, label=label)
        memory_axis.plot(run["minute"], run["resident_mb"], color=color, label=label)
    archived = runs[0][0]
    memory_axis.plot(archived["minute"], archived["archive_file_mb"], color="tab:blue",
                     linestyle="--", label="archived mesh, in a file")
    time_axis.set_ylabel("CPU time per frame [ms]")
    memory_axis.set_ylabel("resident memory [MB]")
    for axis in (time_axis, memory_axis):
        axis.set_xlabel("minutes of walk at 0.5 m/s, all new")
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    memory_axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(sys.argv[3], dpi=100)


if __name__ == "__main__":
    main()
