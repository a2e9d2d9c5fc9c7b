# SPDX-License-Identifier: BSD-3-Clause
"""The program render_apartments: images, labels and what describes them."""
import json
import os
import subprocess
import tempfile
import unittest

import numpy as np
from PIL import Image

PROGRAM = os.path.join(os.environ["TSG_BUILD_DIR"], "devel", "lib", "task_scene_graph",
                       "render_apartments")


def read(folder, name, kind):
    return np.array(Image.open(os.path.join(folder, f"{name}.{kind}.png")))


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=300)


class RenderApartments(unittest.TestCase):
    def render(self, folder, *arguments):
        done = run("--output", folder, "--first-seed", "7", "--views", "3", "--width", "160",
                   "--height", "120", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(folder, "7.json")) as file:
            return json.load(file)

    def test_labels_are_ids_of_described_instances(self):
        with tempfile.TemporaryDirectory() as folder:
            info = self.render(folder)
            self.assertEqual(len(info["views"]), 3)
            known = {i["id"] for i in info["instances"]}
            for view in info["views"]:
                self.assertEqual(read(folder, view["name"], "color").shape, (120, 160, 3))
                labels = read(folder, view["name"], "labels")
                self.assertEqual(labels.shape, (120, 160))
                self.assertLessEqual(set(np.unique(labels)) - {0}, known)
                self.assertLessEqual(sum(view["rooms"].values()), 1.0 + 1e-9)

    def test_other_surfaces_change_the_images_only(self):
        with tempfile.TemporaryDirectory() as own, tempfile.TemporaryDirectory() as other:
            a, b = self.render(own), self.render(other, "--surfaces", "held_out")
            self.assertEqual(a["instances"], b["instances"])
            name = a["views"][0]["name"]
            np.testing.assert_array_equal(read(own, name, "labels"), read(other, name, "labels"))
            changed = read(own, name, "color") != read(other, name, "color")
            self.assertGreater(np.mean(changed), 0.3)

    def test_a_wrong_set_of_surfaces_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run("--output", folder, "--surfaces", "shiny")
            self.assertEqual(done.returncode, 2)
            self.assertIn("shiny", done.stderr)


if __name__ == "__main__":
    unittest.main()
