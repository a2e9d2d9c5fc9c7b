#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Reads a scene graph with the PyPI package `spark_dsg`, edits it, and writes it again.

usage: spark_dsg_rewrite.py GRAPH.json [--erase SYMBOL] [--move SYMBOL DX]
The package is looked for as in spark_dsg_load_test.py. Exit status 77: it cannot be imported.
"""
import os
import sys

CACHE = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
sys.path.append(os.environ.get("TSG_SPARK_DSG_PATH") or
                os.path.join(CACHE, "task_scene_graph", "spark_dsg"))
try:
    import spark_dsg
except ImportError as error:
    print("the Python package spark_dsg is not here (%s); scripts/install_spark_dsg gets it" % error)
    sys.exit(77)


def node_id(symbol):
    return spark_dsg.NodeSymbol(symbol[0], int(symbol[1:])).value


def main():
    path, edits = sys.argv[1], sys.argv[2:]
    graph = spark_dsg.DynamicSceneGraph.load(path)
    if edits[:1] == ["--erase"]:
        graph.remove_node(node_id(edits[1]))
    elif edits[:1] == ["--move"]:
        attributes = graph.get_node(node_id(edits[1])).attributes
        box = attributes.bounding_box
        center = [float(value) for value in box.world_P_center]
        center[0] += float(edits[2])
        attributes.bounding_box = spark_dsg.BoundingBox(box.dimensions, center)
    graph.save(path, False)


if __name__ == "__main__":
    main()
