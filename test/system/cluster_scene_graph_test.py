# SPDX-License-Identifier: BSD-3-Clause
"""The program cluster_scene_graph against an independent clustering in numpy."""
import gzip
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import yaml

CACHE = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"),
                     "task_scene_graph")
sys.path.append(os.environ.get("TSG_SPARK_DSG_PATH") or os.path.join(CACHE, "spark_dsg"))
try:
    import spark_dsg
except ImportError:
    spark_dsg = None

PROGRAMS = os.path.join(os.environ.get("TSG_BUILD_DIR", "build"), "devel/lib/task_scene_graph")
PROGRAM = os.path.join(PROGRAMS, "cluster_scene_graph")
NETWORK = os.path.join(os.environ.get("TSG_SOURCE_DIR", "."),
                       "test/unit/language/networks/text_encoder.onnx")
VOCABULARY = os.path.join(CACHE, "bpe_simple_vocab_16e6.txt.gz")
IDENTITY = {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}


def node_id(letter, index):
    return (ord(letter) << 56) | index


def make_segment(random, tasks, version, box=None):
    """Attributes of a primitive that serves a mix of up to two tasks."""
    noise = random.normal(size=tasks.shape[1])
    feature = noise / np.linalg.norm(noise)
    if random.random() < 0.7:
        for task in tasks[random.integers(len(tasks), size=2)]:
            feature = feature + random.uniform(0.2, 0.6) * task
    feature = feature.astype(np.float32)
    center = random.uniform(0.0, 3.0, size=3) if box is None else np.array(box)
    attributes = {
        "type": "KhronosObjectAttributes",
        "position": [float(x) for x in center],
        "last_update_time_ns": int(random.integers(1 << 40)),
        "is_active": False,
        "is_predicted": False,
        "name": "",
        "color": {"r": 255, "g": 0, "b": 0, "a": 255},
        "bounding_box": {"type": "AABB", "dimensions": [1.0, 1.0, 1.0],
                         "world_P_center": [float(x) for x in center],
                         "world_R_center": IDENTITY},
        "semantic_label": 4294967295,
        "semantic_feature": {"rows": len(feature), "cols": 1,
                             "data": [float(x) for x in feature]},
        "mesh_connections": [], "registered": False, "world_R_object": IDENTITY,
        "first_observed_ns": [3], "last_observed_ns": [9],
        "mesh": {"header": {"project_name": "main",
                            "version": dict(zip(("major", "minor", "patch"), version))},
                 "has_colors": True, "has_timestamps": False, "has_labels": False,
                 "has_first_seen_stamps": False,
                 "points": [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]],
                 "colors": [{"r": 1, "g": 2, "b": 3, "a": 255}] * 3, "faces": [[0, 1, 2]]},
        "details": {}, "trajectory_positions": [], "trajectory_timestamps": [],
        "dynamic_object_points": [],
    }
    if version >= (1, 1, 0):
        attributes["metadata"] = {}
    return attributes


def make_graph(segments, version, letter="s", layer=1):
    """A scene graph file around the given attributes."""
    graph = {"SPARK_DSG_header": {"project_name": "main", "version": dict(
                 zip(("major", "minor", "patch"), version))},
             "directed": False, "multigraph": False, "nodes": [], "edges": []}
    for i, attributes in enumerate(segments):
        node = {"id": node_id(letter, 3 * i), "layer": layer, "attributes": attributes}
        if version >= (1, 1, 0):
            node["partition"] = 0
        graph["nodes"].append(node)
    if version >= (1, 1, 0):
        graph["layer_keys"] = [{"layer": x, "partition": 0} for x in range(1, 6)]
        graph["layer_names"] = {name: {"layer": x, "partition": 0} for x, name in enumerate(
            ("SEGMENTS", "OBJECTS", "PLACES", "ROOMS", "BUILDINGS"), start=1)}
        graph["metadata"] = {"kept": [1, 2]}
    else:
        graph["layer_ids"] = [1, 2, 3, 4, 5]
    return graph


def relevance(feature, tasks, alpha, k):
    """Eq. 5 with the null task first."""
    phi = tasks @ feature / (np.linalg.norm(tasks, axis=1) * np.linalg.norm(feature))
    null = np.eye(len(tasks) + 1)[0]
    if phi.max() < alpha:
        return null
    theta = np.concatenate([[alpha], np.maximum(phi, 0.0)])
    k = min(k, len(theta))
    p = np.zeros(len(theta))
    for rank, y in enumerate(sorted(range(len(theta)), key=lambda y: (-theta[y], y))[:k]):
        p[y] = (k - rank) * theta[y]
    return p / p.sum() if p.sum() > 0 else null


def entropy(p):
    p = p[p > 0]
    return -float(np.sum(p * np.log2(p)))


def cluster(graph, tasks, layer=1, alpha=0.23, delta=1e-5, k=2, prior="uniform"):
    """Batch agglomerative information bottleneck, everything anew at every merge."""
    primitives = {}
    for node in graph["nodes"]:
        if node["layer"] == layer:
            a = node["attributes"]
            center = np.array(a["bounding_box"]["world_P_center"])
            half = np.array(a["bounding_box"]["dimensions"]) / 2
            feature = np.array(a["semantic_feature"]["data"])
            primitives[node["id"]] = (center - half, center + half, feature)
    ids = sorted(primitives)
    members = {i: [i] for i in ids}
    p = {i: relevance(primitives[i][2], tasks, alpha, k) for i in ids}
    edges = {(a, b) for a in ids for b in ids if a < b
             and np.all(primitives[a][0] < primitives[b][1])
             and np.all(primitives[b][0] < primitives[a][1])}
    mean = sum(p.values()) / len(ids)
    marginal = mean if prior == "marginal" else np.full(len(tasks) + 1, 1 / (len(tasks) + 1))
    information = -float(np.sum(mean[mean > 0] * np.log2(marginal[mean > 0])))
    information -= sum(entropy(q) for q in p.values()) / len(ids)
    merges = []
    while edges:
        def cost(edge):
            na, nb = len(members[edge[0]]), len(members[edge[1]])
            pa, pb = p[edge[0]], p[edge[1]]
            if np.array_equal(pa, pb):
                return 0.0
            mixed = (na * pa + nb * pb) / (na + nb)
            return round((na + nb) * entropy(mixed) - na * entropy(pa) - nb * entropy(pb), 9)
        best, (a, b) = min((cost(edge), edge) for edge in edges)
        d = best / len(ids)
        if not (delta >= 1 or (delta > 0 and (best == 0 or d / information < delta))):
            break
        merges.append((a, b, d, d / information if best else 0.0))
        na, nb = len(members[a]), len(members[b])
        p[a] = (na * p[a] + nb * p[b]) / (na + nb)
        members[a] = sorted(members[a] + members.pop(b))
        edges = {tuple(sorted((a if x == b else x, a if y == b else y))) for x, y in edges}
        edges = {e for e in edges if e[0] != e[1]}
    return information, merges, sorted(members.values())


class ClusterSceneGraph(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.random = np.random.default_rng(5)
        self.tasks = self.random.normal(size=(4, 12)).astype(np.float32).astype(float)
        self.names = ["wash %d" % i for i in range(4)]
        self.write_tasks(self.tasks)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write_tasks(self, tasks):
        entries = [{"name": n, "embedding": [float(x) for x in t]}
                   for n, t in zip(self.names, tasks)]
        with open(self.path("tasks.yaml"), "w") as f:
            yaml.safe_dump({"tasks": entries}, f)

    def run_program(self, graph, *options):
        if graph is not None:
            with open(self.path("in.json"), "w") as f:
                json.dump(graph, f)
        return subprocess.run(
            [PROGRAM, "--input", self.path("in.json"), "--tasks", self.path("tasks.yaml"),
             "--output", self.path("out.json"), "--tape", self.path("tape.json"), *options],
            capture_output=True, text=True, timeout=60)

    def load(self, name):
        with open(self.path(name)) as f:
            return json.load(f)

    def cluster(self, graph, *options):
        result = self.run_program(graph, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.load("tape.json"), self.load("out.json")

    def make_segments(self, count, version):
        return [make_segment(self.random, self.tasks, version) for _ in range(count)]

    def assert_tape(self, tape, expected):
        information, merges, clusters = expected
        self.assertAlmostEqual(tape["information"], information, places=9)
        self.assertEqual([(m["a"], m["b"]) for m in tape["merges"]], [m[:2] for m in merges])
        for ours, (_, _, d, delta) in zip(tape["merges"], merges):
            self.assertAlmostEqual(ours["d"], d, places=9)
            self.assertAlmostEqual(ours["delta"], delta, places=9)
        self.assertEqual(tape["clusters"], clusters)

    def test_tape_is_that_of_an_independent_clustering(self):
        for version in ((1, 0, 5), (1, 1, 3)):
            graph = make_graph(self.make_segments(40, version), version)
            for delta in (0.0, 1e-5, 0.01, 1.0):
                for prior in ("uniform", "marginal"):
                    tape, _ = self.cluster(graph, "--delta", str(delta), "--prior", prior)
                    expected = cluster(graph, self.tasks, delta=delta, prior=prior)
                    self.assert_tape(tape, expected)
                    self.assertEqual(bool(tape["merges"]), delta > 0)

    def test_alpha_and_top_k_reach_the_clustering(self):
        graph = make_graph(self.make_segments(40, (1, 1, 3)), (1, 1, 3))
        options = ("--alpha", "0.4", "--top-k", "3", "--delta", "0.02")
        tape, _ = self.cluster(graph, *options)
        self.assert_tape(tape, cluster(graph, self.tasks, alpha=0.4, k=3, delta=0.02))

    def test_reach_joins_what_stands_on_each_other_with_a_gap_small_for_its_size(self):
        version = (1, 1, 3)
        segments = json.loads(json.dumps(self.make_segments(1, version) * 6))
        # A gap of 0.2 m above boxes of 1 m, above such of 0.2 m, and beside boxes of 1 m.
        boxes = (([0, 0, 0.0], 1.0), ([0, 0, 1.2], 1.0), ([50, 0, 0.0], 0.2), ([50, 0, 0.4], 0.2),
                 ([90, 0, 0.0], 1.0), ([91.2, 0, 0.0], 1.0))
        for segment, (center, side) in zip(segments, boxes):
            segment["semantic_feature"]["data"] = [float(v) for v in self.tasks[0]]
            segment["bounding_box"].update(world_P_center=[float(v) for v in center],
                                           dimensions=[side] * 3)
        graph = make_graph(segments, version)
        self.assertEqual([len(c) for c in self.cluster(graph)[0]["clusters"]], [1] * 6)
        tape, out = self.cluster(graph, "--reach", "0.15")
        self.assertEqual([len(c) for c in tape["clusters"]], [2, 1, 1, 1, 1])
        box = [n for n in out["nodes"] if n["layer"] == 2][0]["attributes"]["bounding_box"]
        self.assertTrue(np.allclose(box["dimensions"], [1.0, 1.0, 2.2]))  # not as far as they reach
        self.assertEqual(self.run_program(graph, "--reach", "-1").returncode, 2)

    def test_size_invariant_clusters_do_not_drift_as_the_map_grows(self):
        segments = self.make_segments(30, (1, 1, 3))
        far = [make_segment(self.random, self.tasks, (1, 1, 3), (100.0 + 2 * i, 0.0, 0.0))
               for i in range(60)]
        options = ("--normaliser", "size_invariant", "--delta", "0.3")
        small = self.cluster(make_graph(segments, (1, 1, 3)), *options)[0]["clusters"]
        large = self.cluster(make_graph(segments + far, (1, 1, 3)), *options)[0]["clusters"]
        self.assertEqual(large[:len(small)], small)
        self.assertEqual(len(large), len(small) + len(far))

    def test_objects_stand_for_the_clusters(self):
        version = (1, 1, 3)
        graph = make_graph(self.make_segments(30, version), version)
        place = {"id": node_id("p", 0), "layer": 3, "partition": 0,
                 "attributes": {"type": "PlaceNodeAttributes", "position": [0.0, 0.0, 0.0]}}
        old = {"id": node_id("O", 77), "layer": 2, "partition": 0,
               "attributes": graph["nodes"][0]["attributes"]}
        agent = {"id": node_id("a", 0), "layer": 2, "partition": 97, "attributes": {"position": 0}}
        graph["nodes"] += [place, old, agent]
        info = {"type": "EdgeAttributes", "weight": 1.0, "weighted": False, "metadata": {}}
        graph["edges"].append({"source": old["id"], "target": node_id("s", 0), "info": info})
        graph["edges"].append({"source": place["id"], "target": old["id"], "info": info})
        tape, out = self.cluster(graph, "--delta", "0.05")
        nodes = {n["id"]: n for n in out["nodes"]}
        before = {n["id"]: n for n in graph["nodes"]}
        for kept in before.keys() - {old["id"]}:
            self.assertEqual(nodes[kept], before[kept])
        self.assertEqual(out["metadata"], graph["metadata"])
        objects = [n for n in out["nodes"] if n["layer"] == 2 and n["partition"] == 0]
        self.assertEqual(len(objects), len(tape["clusters"]))
        edges = {(e["source"], e["target"]) for e in out["edges"]}
        for index, members in enumerate(tape["clusters"]):
            object_id = node_id("O", index)
            self.assertTrue(all((object_id, m) in edges for m in members))
            self.assertIn((place["id"], object_id), edges)
            self.assert_merged(nodes[object_id]["attributes"],
                               [nodes[m]["attributes"] for m in members])
        self.assertEqual(len(edges), len(objects) + 30)

    def test_notes_of_one_primitive_are_not_those_of_an_object_of_several(self):
        def note(x, y, side):
            return {"track": 4, "num_observations": 9, "seen_by": "Ann", "oriented_box": {
                "center_m": [x, y, 0.0], "size_m": [side, side, 1.0], "yaw_rad": 0.0}}
        version = (1, 1, 3)
        segments = self.make_segments(1, version) * 3
        segments = json.loads(json.dumps(segments))
        for segment, x in zip(segments, (1.0, 1.5, 900.0)):
            segment["semantic_feature"]["data"] = [float(v) for v in self.tasks[0]]
            segment["bounding_box"]["world_P_center"] = [x, 1.0, 1.0]
            segment["metadata"] = note(x, 1.0, 1.0)
        tape, out = self.cluster(make_graph(segments, version))
        self.assertEqual([len(members) for members in tape["clusters"]], [2, 1])
        notes = [n["attributes"]["metadata"] for n in out["nodes"] if n["layer"] == 2]
        self.assertEqual(notes[0]["seen_by"], "Ann")
        self.assertNotIn("track", notes[0])
        self.assertNotIn("num_observations", notes[0])
        box = notes[0]["oriented_box"]  # from x = 0.5 to 2
        self.assertTrue(np.allclose(box["center_m"], [1.25, 1.0, 0.0]), box)
        self.assertTrue(np.allclose(sorted(box["size_m"]), [1.0, 1.0, 1.5]), box)
        self.assertEqual(notes[1], segments[2]["metadata"])
        segments[1]["metadata"]["oriented_box"] = "somebody else's"
        _, out = self.cluster(make_graph(segments, version))
        notes = [n["attributes"]["metadata"] for n in out["nodes"] if n["layer"] == 2]
        self.assertEqual(notes[0], {"seen_by": "Ann"})

    def assert_merged(self, merged, parts):
        centers = np.array([p["bounding_box"]["world_P_center"] for p in parts])
        box = merged["bounding_box"]
        center = np.array(box["world_P_center"])
        half = np.array(box["dimensions"]) / 2
        np.testing.assert_allclose(center - half, centers.min(axis=0) - 0.5, atol=1e-9)
        np.testing.assert_allclose(center + half, centers.max(axis=0) + 0.5, atol=1e-9)
        np.testing.assert_allclose(merged["position"], centers.mean(axis=0))
        features = np.array([p["semantic_feature"]["data"] for p in parts])
        np.testing.assert_allclose(merged["semantic_feature"]["data"], features.mean(axis=0),
                                   rtol=1e-6)
        mesh = merged["mesh"]
        self.assertEqual(len(mesh["points"]), 3 * len(parts))
        self.assertEqual(len(mesh["colors"]), 3 * len(parts))
        world = np.array(mesh["points"])[::3] + center
        np.testing.assert_allclose(world, centers, atol=1e-9)
        self.assertEqual(mesh["faces"], [[3 * i, 3 * i + 1, 3 * i + 2] for i in range(len(parts))])
        p = sum(relevance(f, self.tasks, 0.23, 2) for f in features)
        task = int(np.argmax(p))
        self.assertEqual(merged["name"], self.names[task - 1] if task else "")

    def test_without_segments_objects_are_clustered_in_place(self):
        version = (1, 0, 5)
        graph = make_graph(self.make_segments(30, version), version, letter="O", layer=2)
        place = {"id": node_id("p", 0), "layer": 3, "attributes": {"position": [0.0, 0.0, 0.0]}}
        info = {"type": "EdgeAttributes", "weight": 1.0, "weighted": False}
        graph["edges"] = [{"source": place["id"], "target": n["id"], "info": info}
                          for n in graph["nodes"]]
        graph["nodes"].append(place)
        tape, out = self.cluster(graph, "--delta", "0.05")
        self.assert_tape(tape, cluster(graph, self.tasks, layer=2, delta=0.05))
        representatives = [members[0] for members in tape["clusters"]]
        self.assertLess(len(representatives), 30)
        self.assertEqual(sorted(n["id"] for n in out["nodes"] if n["layer"] == 2), representatives)
        self.assertEqual(sorted(e["target"] for e in out["edges"]), representatives)

    def test_errors_name_file_and_value(self):
        version = (1, 1, 3)
        graph = make_graph(self.make_segments(3, version), version)

        def error_of(status, change, *options):
            broken = json.loads(json.dumps(graph))
            change(broken)
            result = self.run_program(broken, *options)
            self.assertEqual(result.returncode, status, result.stderr)
            self.assertFalse(os.path.exists(self.path("out.json")))
            return result.stderr

        cases = [
            (lambda g: g.pop("nodes"), ("in.json", "nodes")),
            (lambda g: g.update(edges=None), ("in.json", "edges")),
            (lambda g: [n["attributes"].pop("semantic_feature") for n in g["nodes"]],
             ("in.json", "s0 (%d)" % node_id("s", 0), "semantic_feature")),
            (lambda g: [n["attributes"].update(semantic_feature=[1.0] * 5) for n in g["nodes"]],
             ("in.json", "5 numbers", "the tasks' 12")),
        ]
        for change, words in cases:
            message = error_of(1, change)
            for word in words:
                self.assertIn(word, message)
        for options, words in (
                (("--alpha", "high"), ("alpha", "high")), (("--alpha", "1.5"), ("alpha", "1.5")),
                (("--alpha", "nan"), ("alpha", "nan")), (("--top-k", "2.5"), ("top_k", "2.5")),
                (("--top-k", "0"), ("top_k", "0")), (("--delta", "-1"), ("delta", "-1")),
                (("--prior", "flat"), ("prior", "flat", "marginal")),
                (("--normaliser", "none"), ("normaliser", "none", "size_invariant")),
                (("--nonsense", "1"), ("--nonsense",)), (("--delta",), ("--delta",))):
            message = error_of(2, lambda g: None, *options)
            for word in words:
                self.assertIn(word, message)

    def test_one_bad_node_is_left_counted_and_named(self):
        version = (1, 1, 3)
        graph = make_graph(self.make_segments(30, version), version)
        bad = graph["nodes"][7]
        others = json.loads(json.dumps(graph))
        del others["nodes"][7]
        expected = cluster(others, self.tasks, delta=0.02)
        spoilings = (lambda a: a.pop("semantic_feature"),
                     lambda a: a.update(semantic_feature=None),
                     lambda a: a.update(semantic_feature={"rows": -2, "cols": -2, "data": [1.0] * 4}),
                     lambda a: a.update(semantic_feature={"rows": 0, "cols": 0, "data": []}),
                     lambda a: a.update(semantic_feature=[1.0] * 5),
                     lambda a: a["semantic_feature"]["data"].__setitem__(3, math.nan),
                     lambda a: a["semantic_feature"]["data"].__setitem__(3, math.inf),
                     lambda a: a.pop("bounding_box"))
        good = bad["attributes"]
        for spoil in spoilings:
            bad["attributes"] = json.loads(json.dumps(good))
            spoil(bad["attributes"])
            result = self.run_program(graph, "--delta", "0.02")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn("29 primitives", result.stdout)
            self.assertIn("1 node left as in the file", result.stdout)
            self.assertIn("in.json", result.stderr)
            self.assertIn("s21 (%d)" % bad["id"], result.stderr)
            self.assert_tape(self.load("tape.json"), expected)
            out = {n["id"]: n for n in self.load("out.json")["nodes"]}
            # NaN and Infinity are no JSON: null stands for them.
            text = json.dumps(bad).replace("NaN", "null").replace("Infinity", "null")
            self.assertEqual(out[bad["id"]], json.loads(text))

    def make_clio_graph(self, count):
        """A file of 1.0.0 as Clio published them; vertices are the corners of a triangle."""
        graph = {"directed": False, "multigraph": False, "layer_ids": [1, 2, 3, 4, 5],
                 "nodes": [], "edges": []}
        for i, attributes in enumerate(self.make_segments(count, (1, 0, 0))):
            center = np.array(attributes["position"])
            size = np.array([1.0, 0.8, 0.6])
            attributes["bounding_box"] = {
                "type": "AABB", "min": list(center - size / 2), "max": list(center + size / 2),
                "world_P_center": list(center) if i % 2 else [0.0, 0.0, 0.0],
                "world_R_center": IDENTITY}
            del attributes["mesh"]
            attributes["color"] = [255, 0, 0]
            attributes["vertices"] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.8, 0.6]
            attributes["colors"] = [10 * (i % 20), 2, 3, 255] * 3
            attributes["faces"] = [0, 1, 2]
            graph["nodes"].append({"id": node_id("s", i), "layer": 1, "attributes": attributes})
        return graph

    def world_vertices(self, attributes):
        box = attributes["bounding_box"]
        return np.array(attributes["vertices"]).reshape(-1, 3) + np.array(box["min"])

    def test_objects_of_a_file_of_clio_hold_all_vertices_at_their_place(self):
        graph = self.make_clio_graph(40)
        segments = {n["id"]: n["attributes"] for n in graph["nodes"]}
        tape, out = self.cluster(graph, "--delta", "0.05")
        objects = [n for n in out["nodes"] if n["layer"] == 2]
        self.assertEqual(len(objects), len(tape["clusters"]))
        self.assertLess(len(objects), 40)
        self.assertNotIn("SPARK_DSG_header", out)
        for node, members in zip(objects, tape["clusters"]):
            merged = node["attributes"]
            expected = np.concatenate([self.world_vertices(segments[m]) for m in members])
            np.testing.assert_allclose(self.world_vertices(merged), expected, atol=1e-9)
            np.testing.assert_allclose(merged["bounding_box"]["min"], expected.min(axis=0), atol=1e-9)
            np.testing.assert_allclose(merged["bounding_box"]["max"], expected.max(axis=0), atol=1e-9)
            self.assertEqual(merged["faces"], list(range(3 * len(members))))
            self.assertEqual(len(merged["colors"]), 12 * len(members))
            self.assertNotIn("mesh", merged)

    def test_missing_and_malformed_files_are_named(self):
        self.assertIn("in.json", self.run_program(None).stderr)
        good = json.dumps(make_graph(self.make_segments(3, (1, 1, 3)), (1, 1, 3)))
        for text, word in ((b"{ not json", "is not JSON"), (b"", "is empty"),
                           (good.encode()[:1000], "cut off"),
                           (gzip.compress(good.encode()), "gzip"),
                           (good.encode("utf-16"), "UTF-16"),
                           (100000 * b"[", "deeper than"), (b"{}", "nodes"),
                           (b"<html>", "web page")):
            with open(self.path("in.json"), "wb") as f:
                f.write(text)
            result = self.run_program(None)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn(self.path("in.json"), result.stderr)
            self.assertIn(word, result.stderr)
        with open(self.path("tasks.yaml"), "w") as f:
            f.write("- wash the dishes\n")
        message = self.run_program(make_graph([], (1, 1, 3))).stderr
        self.assertIn("tasks.yaml", message)
        self.assertIn("wash the dishes", message)

    def test_edge_cases(self):
        version = (1, 1, 3)
        tape, _ = self.cluster(make_graph([], version))
        self.assertEqual(tape, {"information": 0.0, "merges": [], "clusters": []})
        one = self.make_segments(1, version)
        self.assertEqual(self.cluster(make_graph(one, version))[0]["clusters"], [[node_id("s", 0)]])
        twins = one * 5
        graph = make_graph(twins, version)
        tape, _ = self.cluster(graph)
        self.assertEqual([m["d"] for m in tape["merges"]], [0.0] * 4)
        self.assertEqual(len(tape["clusters"]), 1)
        with open(self.path("tasks.yaml"), "w") as f:
            f.write("tasks: []\n")
        tape, _ = self.cluster(make_graph(self.make_segments(9, version), version))
        self.assertEqual(tape["information"], 0.0)

    def test_rotated_boxes_count_with_their_hull(self):
        version = (1, 1, 3)
        segments = [make_segment(self.random, self.tasks, version, (x, 0.0, 0.0))
                    for x in (0.0, 1.1)]
        segments[1]["semantic_feature"] = segments[0]["semantic_feature"]
        self.assertEqual(len(self.cluster(make_graph(segments, version))[0]["clusters"]), 2)
        segments[0]["bounding_box"]["type"] = "OBB"
        half_angle = math.pi / 8
        segments[0]["bounding_box"]["world_R_center"] = {
            "w": math.cos(half_angle), "x": 0.0, "y": 0.0, "z": math.sin(half_angle)}
        self.assertEqual(len(self.cluster(make_graph(segments, version))[0]["clusters"]), 1)

    @unittest.skipUnless(os.path.isfile(VOCABULARY),
                         "CLIP's vocabulary is not here (scripts/install_vocabulary gets it)")
    def test_tasks_without_embeddings_are_encoded(self):
        with open(self.path("models.yaml"), "w") as f:  # only the text encoder is run
            f.write("name: small\nembedding_size: 12\nalpha: 0.1\n" + "".join(
                "%s: %s\n" % (key, os.path.abspath(NETWORK))
                for key in ("segmenter", "image_encoder", "text_encoder")))
        with open(self.path("names.yaml"), "w") as f:
            f.write("- wash the dishes\n- fold the clothes\n")
        encoded = subprocess.run(
            [os.path.join(PROGRAMS, "encode_tasks"), "--models", self.path("models.yaml"),
             "--tasks", self.path("names.yaml"), "--output", self.path("tasks.yaml")],
            capture_output=True, text=True, timeout=60)
        if "scripts/install_engine" in encoded.stderr:
            self.skipTest(encoded.stderr)
        self.assertEqual(encoded.returncode, 0, encoded.stderr)
        with open(self.path("tasks.yaml")) as f:
            self.tasks = np.array([t["embedding"] for t in yaml.safe_load(f)["tasks"]])
        graph = make_graph(self.make_segments(30, (1, 1, 3)), (1, 1, 3))
        ready, _ = self.cluster(graph, "--delta", "0.02", "--alpha", "0.1")
        self.assert_tape(ready, cluster(graph, self.tasks, alpha=0.1, delta=0.02))
        self.assertGreater(ready["information"], 0.1)
        os.replace(self.path("names.yaml"), self.path("tasks.yaml"))
        tape, _ = self.cluster(graph, "--delta", "0.02", "--models", self.path("models.yaml"))
        self.assertEqual(tape, ready)

    @unittest.skipIf(spark_dsg is None, "the Python package spark_dsg is not here "
                     "(scripts/install_spark_dsg gets it)")
    def test_spark_dsg_reads_what_we_write(self):
        for version in ((1, 0, 5), (1, 1, 3)):
            graph = make_graph(self.make_segments(20, version), version)
            tape, _ = self.cluster(graph, "--delta", "0.05")
            loaded = spark_dsg.DynamicSceneGraph.load(self.path("out.json"))
            objects = loaded.get_layer("OBJECTS" if version >= (1, 1, 0) else 2)
            self.assertEqual(objects.num_nodes(), len(tape["clusters"]))
            self.assertLess(len(tape["clusters"]), 20)
            for index, members in enumerate(tape["clusters"]):
                node = loaded.get_node(node_id("O", index))
                self.assertEqual(sorted(node.children()), members)

    @unittest.skipIf(spark_dsg is None, "the Python package spark_dsg is not here "
                     "(scripts/install_spark_dsg gets it)")
    def test_spark_dsg_reads_clustered_files_of_clio(self):
        tape, out = self.cluster(self.make_clio_graph(20), "--delta", "0.05")
        loaded = spark_dsg.DynamicSceneGraph.load(self.path("out.json"))
        self.assertEqual(loaded.get_layer(2).num_nodes(), len(tape["clusters"]))
        objects = [n for n in out["nodes"] if n["layer"] == 2]
        for node, members in zip(objects, tape["clusters"]):
            ours, theirs = node["attributes"], loaded.get_node(node["id"]).attributes
            box = ours["bounding_box"]
            if len(members) > 1:  # spark_dsg takes the centre as it is written, Clio's is 0
                np.testing.assert_allclose(theirs.bounding_box.min, box["min"], atol=1e-5)
                np.testing.assert_allclose(theirs.bounding_box.max, box["max"], atol=1e-5)
            vertices = theirs.mesh().get_vertices()
            np.testing.assert_allclose(vertices[:3].T + np.array(box["min"]),
                                       self.world_vertices(ours), atol=1e-5)

    @unittest.skipIf(spark_dsg is None, "the Python package spark_dsg is not here "
                     "(scripts/install_spark_dsg gets it)")
    def test_spark_dsg_reads_what_is_left_of_a_graph_with_faults(self):
        version = (1, 1, 3)
        graph = make_graph(self.make_segments(20, version), version)
        graph["nodes"][3]["attributes"]["semantic_feature"]["data"][0] = math.nan
        graph["nodes"][4]["attributes"]["mesh"]["faces"][0] = [0, 1, 99]
        info = {"type": "EdgeAttributes", "weight": 1.0, "weighted": False, "metadata": {}}
        graph["edges"].append({"source": node_id("p", 9), "target": node_id("s", 0), "info": info})
        graph["nodes"][4]["attributes"]["semantic_feature"] = (
            graph["nodes"][5]["attributes"]["semantic_feature"])
        graph["nodes"][4]["attributes"]["bounding_box"] = (
            graph["nodes"][5]["attributes"]["bounding_box"])
        result = self.run_program(graph, "--delta", "0.05")
        self.assertEqual(result.returncode, 0, result.stderr)
        for words in ("1 mesh ", "1 edge ", "p9 ("):
            self.assertIn(words, result.stderr)
        loaded = spark_dsg.DynamicSceneGraph.load(self.path("out.json"))
        self.assertEqual(loaded.get_layer("SEGMENTS").num_nodes(), 20)
        self.assertIsNone(loaded.get_node(node_id("s", 9)).get_parent())

    @unittest.skipIf(spark_dsg is None, "the Python package spark_dsg is not here "
                     "(scripts/install_spark_dsg gets it)")
    def test_reads_what_spark_dsg_writes(self):
        version = (1, 1, 3)
        graph = make_graph(self.make_segments(20, version), version)
        tape, _ = self.cluster(graph, "--delta", "0.05")
        spark_dsg.DynamicSceneGraph.load(self.path("out.json")).save(self.path("in.json"))
        self.assertEqual(self.cluster(None, "--delta", "0.05")[0], tape)


if __name__ == "__main__":
    unittest.main()
