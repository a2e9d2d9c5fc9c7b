#!/usr/bin/python3
"""Loads a scene graph file into the PyPI package `spark_dsg` and compares it with what was written.

usage: spark_dsg_load_test.py GRAPH.json EXPECTED.json
The package is looked for on the Python path, then in $TSG_SPARK_DSG_PATH or, without that, where
scripts/install_spark_dsg puts it. Exit status: 0 all as expected, 1 not, 77 the package cannot be
imported.
"""
import json
import os
import pathlib
import sys
import unittest

CACHE = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
sys.path.append(os.environ.get("TSG_SPARK_DSG_PATH") or
                os.path.join(CACHE, "task_scene_graph", "spark_dsg"))
try:
    import numpy
    import spark_dsg
except ImportError as error:
    print(f"the Python package spark_dsg is not here ({error}); scripts/install_spark_dsg gets it")
    sys.exit(77)

LAYERS = {"segments": "SEGMENTS", "objects": "OBJECTS", "places": "PLACES", "regions": "ROOMS"}


def node_id(symbol):
    return spark_dsg.NodeSymbol(symbol[0], int(symbol[1:])).value


class LoadedGraph(unittest.TestCase):
    graph = None
    expected = None

    def attributes(self, symbol):
        return self.graph.get_node(node_id(symbol)).attributes

    def nodes(self):
        for layer in LAYERS:
            yield from self.expected[layer].items()

    def test_layers_hold_exactly_the_nodes_written(self):
        for key, layer in LAYERS.items():
            ids = {node.id.value for node in self.graph.get_layer(layer).nodes}
            self.assertEqual(ids, {node_id(symbol) for symbol in self.expected[key]}, layer)

    def test_symbols_read_as_written(self):
        for symbol, _ in self.nodes():
            loaded = self.graph.get_node(node_id(symbol)).id
            self.assertEqual((loaded.category, loaded.category_id), (symbol[0], int(symbol[1:])))

    def test_positions(self):
        for symbol, node in self.nodes():
            numpy.testing.assert_allclose(self.attributes(symbol).position, node["position"],
                                          rtol=1e-6, err_msg=symbol)

    def test_names(self):
        for symbol, node in self.nodes():
            self.assertEqual(self.attributes(symbol).name, node.get("name", ""), symbol)

    def test_semantic_features_bit_by_bit(self):
        for symbol, node in self.nodes():
            feature = numpy.asarray(self.attributes(symbol).semantic_feature, numpy.float32)
            self.assertEqual(feature.flatten().tolist(),
                             numpy.asarray(node["feature"], numpy.float32).tolist(), symbol)

    def test_boxes(self):
        for symbol, node in self.nodes():
            if "box" not in node:
                continue
            box = self.attributes(symbol).bounding_box
            self.assertEqual(box.type, spark_dsg.BoundingBoxType.AABB, symbol)
            numpy.testing.assert_allclose(box.min, node["box"][0], rtol=1e-6, atol=1e-6)
            numpy.testing.assert_allclose(box.max, node["box"][1], rtol=1e-6, atol=1e-6)

    def test_labels_are_task_indices(self):
        for symbol, node in self.nodes():
            if "label" in node:
                self.assertEqual(self.attributes(symbol).semantic_label, node["label"], symbol)

    def test_times_seen(self):
        for symbol, node in self.nodes():
            if "seen" in node:
                attributes = self.attributes(symbol)
                self.assertEqual([attributes.first_observed_ns, attributes.last_observed_ns],
                                 [[node["seen"][0]], [node["seen"][1]]], symbol)

    def test_distances_of_places(self):
        for symbol, node in self.expected["places"].items():
            self.assertAlmostEqual(self.attributes(symbol).distance, node["distance"], 6)

    def test_meshes_lie_in_their_boxes(self):
        for symbol, node in self.nodes():
            if "num_vertices" not in node:
                continue
            mesh = self.attributes(symbol).mesh()
            self.assertEqual(mesh.num_vertices(), node["num_vertices"], symbol)
            self.assertEqual(mesh.num_faces(), node["num_faces"], symbol)
            center = self.attributes(symbol).bounding_box.world_P_center.reshape(3, 1)
            world = mesh.get_vertices()[:3] + center
            numpy.testing.assert_allclose(world.min(axis=1), node["box"][0], atol=2e-4)
            numpy.testing.assert_allclose(world.max(axis=1), node["box"][1], atol=2e-4)
            self.assertLess(mesh.get_faces().max(), mesh.num_vertices(), symbol)

    def test_edges_are_exactly_those_written(self):
        loaded = {frozenset((edge.source, edge.target)) for edge in self.graph.edges}
        wanted = {frozenset(map(node_id, edge)) for edge in self.expected["edges"]}
        self.assertEqual(loaded, wanted)

    def test_weights_of_place_edges(self):
        for source, target, weight in self.expected["place_edges"]:
            edge = self.graph.get_edge(node_id(source), node_id(target))
            self.assertAlmostEqual(edge.info.weight, weight, 6)

    def test_nesting(self):
        for child, parent in self.expected["parents"].items():
            self.assertEqual(self.graph.get_node(node_id(child)).get_parent(), node_id(parent), child)

    def test_metadata(self):
        metadata = self.graph.metadata.get()
        for key, value in self.expected["metadata"].items():
            self.assertEqual(metadata[key], value)
        for key, value in self.expected["config"].items():
            self.assertAlmostEqual(metadata["config"][key], value, 7)

    def test_saved_again_it_is_the_same(self):
        path = sys.argv[1] + ".again.json"
        self.graph.save(path)
        again = spark_dsg.DynamicSceneGraph.load(path)
        self.assertEqual(again.num_nodes(), self.graph.num_nodes())
        self.assertEqual(again.num_edges(), self.graph.num_edges())


if __name__ == "__main__":
    LoadedGraph.graph = spark_dsg.DynamicSceneGraph.load(sys.argv[1])
    LoadedGraph.expected = json.loads(pathlib.Path(sys.argv[2]).read_text(encoding="utf-8"))
    unittest.main(argv=sys.argv[:1])
