#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""export_openlex3d: its files, read back as the OpenLex3D toolbox reads them."""
import json
import os
import subprocess
import tempfile
import unittest

import numpy as np

PROGRAM = os.path.join(os.environ["TSG_BUILD_DIR"], "devel", "lib", "task_scene_graph",
                       "export_openlex3d")


def make_node(index, layer, center, embedding, points, colors=None):
    mesh = {"points": points, "faces": [[0, 1, 2]] if points else []}
    if colors is not None:
        mesh["colors"] = [dict(zip("rgba", color + [255])) for color in colors]
    return {"id": (ord("O" if layer == 2 else "s") << 56) + index, "layer": layer, "partition": 0,
            "attributes": {
                "type": "KhronosObjectAttributes", "position": center, "name": "",
                "bounding_box": {"type": "AABB", "dimensions": [1, 1, 1], "world_P_center": center,
                                 "world_R_center": {"w": 1, "x": 0, "y": 0, "z": 0}},
                "semantic_feature": embedding, "mesh": mesh}}


def read_pcd(path):
    """Points and RGB of a binary PCD file with x, y, z and rgb."""
    with open(path, "rb") as file:
        content = file.read()
    head, _, data = content.partition(b"DATA binary\n")
    fields = dict(line.split(" ", 1) for line in head.decode().splitlines() if line[:1] != "#")
    assert fields["FIELDS"] == "x y z rgb" and fields["SIZE"] == "4 4 4 4", fields
    assert fields["WIDTH"] == fields["POINTS"] and fields["HEIGHT"] == "1", fields
    rows = np.frombuffer(data, dtype=[("p", "<f4", 3), ("bgr", "u1", 3), ("", "u1")])
    assert len(rows) == int(fields["POINTS"]), fields
    return rows["p"], rows["bgr"][:, ::-1]


class ExportOpenLex3d(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.map = os.path.join(self.folder.name, "scene_graph.json")
        self.output = os.path.join(self.folder.name, "predictions", "office0")
        self.write([
            make_node(0, 1, [1, 0, 0], [3.0, 4.0], [[0, 0, 0], [0.5, 0, 0], [0.001, 0, 0]],
                      [[255, 0, 7], [0, 9, 0], [1, 1, 1]]),
            make_node(1, 1, [9, 0, 0], [1.0, 1.0], []),
            make_node(2, 1, [0, 5, 2], [0.0, -2.0], [[0, 0, 0], [0, 0, 0.1], [0.2, 0.2, 0.2]]),
            make_node(3, 2, [0, 0, 0], [1.0, 0.0], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])])

    def write(self, nodes):
        with open(self.map, "w", encoding="utf-8") as file:
            json.dump({"nodes": nodes, "edges": []}, file)

    def export(self, *options):
        return subprocess.run([PROGRAM, "--map", self.map, "--output", self.output] + list(options),
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120,
                              universal_newlines=True, check=False)

    def read(self):
        return (np.load(os.path.join(self.output, "embeddings.npy")),
                np.load(os.path.join(self.output, "index.npy")),
                *read_pcd(os.path.join(self.output, "point_cloud.pcd")))

    def test_each_point_has_the_embedding_of_its_primitive(self):
        done = self.export("--cell", "0")
        self.assertEqual(done.returncode, 0, done.stdout)
        embeddings, index, points, colors = self.read()
        self.assertTrue(np.allclose(embeddings, [[0.6, 0.8], [0.0, -1.0]]))
        self.assertEqual(embeddings.dtype, np.float32)
        self.assertEqual(index.tolist(), [0, 0, 0, 1, 1, 1])
        self.assertTrue(np.allclose(points, [[1, 0, 0], [1.5, 0, 0], [1.001, 0, 0], [0, 5, 2],
                                             [0, 5, 2.1], [0.2, 5.2, 2.2]]), points)
        self.assertEqual(colors[:3].tolist(), [[255, 0, 7], [0, 9, 0], [1, 1, 1]])
        self.assertEqual(colors[3].tolist(), [128, 128, 128])

    def test_a_cell_keeps_one_point_of_an_object(self):
        self.assertEqual(self.export("--cell", "0.05").returncode, 0)
        _, index, points, _ = self.read()
        self.assertEqual(index.tolist(), [0, 0, 1, 1, 1])
        self.assertEqual(len(points), 5)

    def test_objects_are_exported_on_request(self):
        self.assertEqual(self.export("--layer", "objects").returncode, 0)
        embeddings, index, points, _ = self.read()
        self.assertEqual(embeddings.tolist(), [[1.0, 0.0]])
        self.assertEqual(index.tolist(), [0, 0, 0])
        self.assertEqual(len(points), 3)

    def test_map_without_meshes_is_named(self):
        self.write([make_node(0, 1, [0, 0, 0], [1.0, 0.0], [])])
        done = self.export()
        self.assertEqual(done.returncode, 1)
        self.assertIn("scene_graph.json", done.stdout)
        self.assertIn("none of 1 objects has a mesh", done.stdout)
        self.assertFalse(os.path.exists(self.output))

    def test_embeddings_of_different_sizes_are_refused(self):
        points = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        self.write([make_node(0, 1, [0, 0, 0], [1.0, 0.0], points),
                    make_node(1, 1, [0, 0, 0], [1.0, 0.0, 0.0], points)])
        done = self.export()
        self.assertEqual(done.returncode, 1)
        self.assertIn("3 numbers", done.stdout)

    def test_wrong_words_are_answered_with_the_right_ones(self):
        done = self.export("--layer", "rooms")
        self.assertEqual(done.returncode, 2)
        self.assertIn("segments or objects", done.stdout)


if __name__ == "__main__":
    unittest.main()
