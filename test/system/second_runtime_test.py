# SPDX-License-Identifier: BSD-3-Clause
"""The segmenter against a recomputation with NumPy, Pillow and onnx's reference evaluator."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np
from PIL import Image

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"], "devel", "lib", "task_scene_graph")


def run(*command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=600)
    if done.returncode != 0:
        raise AssertionError(done.stdout)


@unittest.skipUnless("TSG_EXPORT_PYTHON" in os.environ,
                     "needs a Python with onnx 1.13 or newer, Pillow and PyYAML: name it in TSG_EXPORT_PYTHON")
class SecondRuntime(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.folder.name)
        models = SOURCE / "models" / "demo" / "models.yaml"
        run(PROGRAMS / "render_apartments", "--output", folder, "--first-seed", "5", "--views", "1",
            "--width", "384", "--height", "288")
        image = next(folder.glob("*.color.png"))
        (folder / "segmenter.yaml").write_text("encoder: {fit: squash}\n")
        run(PROGRAMS / "segment_images", "--models", models, "--config", folder / "segmenter.yaml", "--data",
            "--output", folder / "ours", image)
        run(os.environ["TSG_EXPORT_PYTHON"], SOURCE / "test" / "support" / "recompute_segments.py", models,
            image, folder / "theirs.npz")
        stem = image.name[:-len(".png")]
        cls.labels = np.array(Image.open(folder / "ours" / (stem + ".labels.png")))
        cls.ours = json.loads((folder / "ours" / (stem + ".json")).read_text())
        cls.theirs = dict(np.load(folder / "theirs.npz"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_scores_agree(self):
        self.assertGreater(len(self.theirs["scores"]), 2)
        self.assertEqual(len(self.ours["scores"]), len(self.theirs["scores"]))
        np.testing.assert_allclose(self.ours["scores"], self.theirs["scores"], atol=1e-4)

    def test_pixels_agree(self):
        # A logit of zero may fall to either side.
        self.assertLess(np.mean(self.labels != self.theirs["labels"]), 1e-4)

    def test_embeddings_agree(self):
        same = [i for i in range(len(self.theirs["scores"]))
                if np.array_equal(self.labels == i + 1, self.theirs["labels"] == i + 1)]
        self.assertGreater(len(same), 1)
        differences = np.abs(np.array(self.ours["embeddings"])[same] - self.theirs["embeddings"][same])
        # Our crops are those of Pillow 9 bit by bit; Pillow 13 rounds a few pixels otherwise.
        self.assertLess(np.median(differences.max(axis=1)), 1e-4)
        self.assertLess(differences.max(), 1e-3)


if __name__ == "__main__":
    unittest.main()
