# SPDX-License-Identifier: BSD-3-Clause
"""The rows of the table: how a map is made of a recording, and which of its nodes are scored.

Methods that share a front end share its map: clio_prim and clio are two layers of one file."""
import collections

# name: of the row. front_end: key of FRONT_ENDS. layer: objects or segments.
# keep: options of evaluate_scene_graph: which of them are scored.
Method = collections.namedtuple("Method", "name front_end layer keep text")

ALPHA = 0.23  # of the paper, for ViT-L/14
NEAR = ("--min-cosine", str(ALPHA))  # those near a task
NAMED = ("--named",)  # those that the clustering gave to a task
REACH = "0.1"  # of the chain; the paper has none

# program: with --bag and --output; roslaunch: see live.py. config: what --config holds, None where the program has no such
# option. uses_tasks: whether the layers that are scored depend on the tasks. base: of a map that is
# made of another one's primitives, that one. Thresholds: [Clio24, Sec. V-A] and the released
# configurations.
FrontEnd = collections.namedtuple("FrontEnd", "program config uses_tasks base")
PAPER = {
    "tracker": {"adapt_cosine": False, "max_range_m": 4.0},
    "mesh_fusion": {"reconstruction": {"max_range_m": 4.0, "min_object_share": 0.5,
                                       "min_part_share": 0.0}},
    "scene_graph": {"object_reach": 0.0},
}
KHRONOS = {"preset": "khronos", "adapt_cosine": False, "min_observations": 5, "max_range_m": 4.0}
FRONT_ENDS = {
    "default": FrontEnd("process_bag", {}, True, None),
    "online": FrontEnd("roslaunch", {}, True, None),
    "batch": FrontEnd("cluster_scene_graph", None, True, "default"),
    "paper": FrontEnd("process_bag", PAPER, True, None),
    "khronos": FrontEnd("process_bag", dict(PAPER, tracker=KHRONOS), False, None),
    "concept_graphs": FrontEnd("concept_graphs", None, False, None),
}

METHODS = [
    Method("clio", "default", "objects", (), "this package with its defaults"),
    Method("clio_online", "online", "objects", (), "the live chain, at the recording's own pace"),
    Method("clio_batch", "batch", "objects", NAMED, "its primitives, clustered at once at the end"),
    Method("primitives", "default", "segments", (), "its primitives, not clustered"),
    Method("clio_paper", "paper", "objects", (), "the paper's thresholds"),
    Method("clio_prim", "paper", "segments", (), "these thresholds' primitives"),
    Method("khronos", "khronos", "segments", (), "coarse tracks, no tasks"),
    Method("khronos_task", "khronos", "segments", NEAR, "of these, those near a task"),
    Method("cg", "concept_graphs", "objects", (), "ConceptGraphs"),
    Method("cg_task", "concept_graphs", "objects", NEAR, "of its objects, those near a task"),
]


def find_default_names():
    """Those that need not wait for the recording to be played."""
    return [method.name for method in METHODS if FRONT_ENDS[method.front_end].program != "roslaunch"]


def find_named(things, names, kind):
    """Those of the names, in their order. Raises ValueError naming the first that is none."""
    known = {thing.name: thing for thing in things}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"no {kind} '{unknown[0]}', expected some of {', '.join(known)}")
    return [known[name] for name in names]


def find_methods(names):
    return find_named(METHODS, names, "method")
