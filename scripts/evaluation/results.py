# SPDX-License-Identifier: BSD-3-Clause
"""Scores on disk: one JSON file per recording and method, written whole or not at all."""
import json
import os
import statistics


def write(path, content):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    part = f"{path}.part"
    with open(part, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1)
    os.replace(part, path)


def load_all(folder, ending=".result.json"):
    """Every result in a folder, sorted by its path. Raises ValueError naming what is no result."""
    results = []
    for parent, _, names in sorted(os.walk(folder)):
        for name in sorted(names):
            if not name.endswith(ending):
                continue
            path = os.path.join(parent, name)
            with open(path, encoding="utf-8") as file:
                try:
                    results.append(json.load(file))
                except ValueError as error:
                    raise ValueError(f"result '{path}' is no JSON: {error}")
    return results


def mean_and_deviation(values):
    """The sample's deviation; 0 for one value."""
    mean = statistics.mean(values)
    return mean, statistics.stdev(values) if len(values) > 1 else 0.0


def group(results):
    """{(world, level): {method: [result, ...]}}, worlds without their seeds, in order of names."""
    groups = {}
    for result in results:
        key = (result["world"], result["level"])
        groups.setdefault(key, {}).setdefault(result["method"], []).append(result)
    return groups
