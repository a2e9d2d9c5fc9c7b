#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws what growth_benchmark wrote.

usage: plot_growth.py growth.csv docs/images/growth.png
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
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    run = read_columns(sys.argv[1])
    figure, (time_axis, memory_axis) = plt.subplots(1, 2, figsize=(9, 3.2))
    time_axis.plot(run["metres"], run["cpu_ms"])  # the stages' own times are no CPU times
    time_axis.set_ylabel("CPU time per frame, all stages [ms]")
    memory_axis.plot(run["metres"], run["resident_mb"], label="resident memory [MB]")
    memory_axis.plot(run["metres"], run["primitives"], linestyle="--", label="primitives")
    memory_axis.plot(run["metres"], [n / 50 for n in run["places"]], linestyle=":", label="places / 50")
    memory_axis.legend(fontsize=8)
    for axis in (time_axis, memory_axis):
        axis.set_xlabel("metres walked, all new")
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=80)


if __name__ == "__main__":
    main()
