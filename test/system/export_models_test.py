#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""scripts/export_models: its comparisons refuse what they should; with torch, a whole export.

The whole export runs with the Python named by $TSG_EXPORT_PYTHON, one that has torch, open_clip,
ultralytics, onnx and onnxruntime.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy
import yaml

SOURCE = pathlib.Path(os.environ.get("TSG_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(SOURCE / "scripts" / "export"))
sys.dont_write_bytecode = True

import checks  # noqa: E402
import model_set  # noqa: E402

ROWS = numpy.random.default_rng(1).normal(size=(5, 16))


class Comparison(unittest.TestCase):
    def test_equal_outputs_pass_and_say_how_many(self):
        self.assertIn("x: 5 inputs, largest difference 0", checks.compare_rows("x", ROWS, ROWS.copy(), 1e-4))

    def test_rounding_passes_and_a_larger_difference_is_refused(self):
        changed = ROWS.copy()
        changed[3, 7] += 1e-6
        self.assertIn("x: 5 inputs", checks.compare_rows("x", ROWS, changed, 1e-4))
        changed[3, 7] += 1e-2
        with self.assertRaisesRegex(checks.Mismatch, "x: differs by"):
            checks.compare_rows("x", ROWS, changed, 1e-4)

    def test_output_that_ignores_the_input_is_refused(self):
        constant = numpy.tile(ROWS[:1], (5, 1))
        with self.assertRaisesRegex(checks.Mismatch, "nothing was checked"):
            checks.compare_rows("x", constant, constant, 1e-4)

    def test_other_shapes_and_values_that_are_not_finite_are_refused(self):
        with self.assertRaisesRegex(checks.Mismatch, r"gives \[5, 15\], its source \[5, 16\]"):
            checks.compare_rows("x", ROWS, ROWS[:, 1:], 1e-4)
        broken = ROWS.copy()
        broken[0, 0] = numpy.nan
        with self.assertRaisesRegex(checks.Mismatch, "the export gives NaN"):
            checks.compare_rows("x", ROWS, broken, 1e-4)

    def test_length_of_embeddings_does_not_matter(self):
        self.assertIn("x: 5 inputs", checks.compare_embeddings("x", ROWS, 3 * ROWS))
        with self.assertRaises(checks.Mismatch):
            checks.compare_embeddings("x", ROWS, ROWS[::-1])


class ModelSetFile(unittest.TestCase):
    def test_yaml_reads_back(self):
        values = {"name": 'a "b": c', "embedding_size": 512, "image_mean": [0.1, 0.2, 0.3], "alpha": 0.23}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "models.yaml"
            model_set.write(path, values)
            self.assertEqual(yaml.safe_load(path.read_text()), values)
            self.assertEqual([p.name for p in path.parent.iterdir()], ["models.yaml"])


class OurSegmenter(unittest.TestCase):
    PROGRAM = os.path.join(os.environ.get("TSG_BUILD_DIR", "build"), "devel/lib/task_scene_graph/segment_images")

    def check(self, network):
        networks = SOURCE / "test" / "data" / "networks"
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "models.yaml"
            model_set.write(path, {"segmenter": str((networks / network).resolve()), "embedding_size": 4,
                                   "image_encoder": str((networks / "encoder.onnx").resolve())})
            image = pathlib.Path(folder) / "image.ppm"
            image.write_bytes(b"P6 64 64 255\n" + bytes(range(256)) * 48)
            os.environ["TSG_SEGMENT_IMAGES"] = self.PROGRAM
            try:
                return model_set.check_with_our_segmenter(path, image)
            except checks.Mismatch as mismatch:
                if "scripts/install_engine" in str(mismatch):
                    self.skipTest(str(mismatch))
                raise
            finally:
                del os.environ["TSG_SEGMENT_IMAGES"]
                self.assertEqual(sorted(os.listdir(folder)), ["image.ppm", "models.yaml"])

    def test_accepts_the_layout_of_fastsam(self):
        self.assertRegex(self.check("segmenter.onnx"), "our own segmenter: [0-9]+ segments")

    def test_refuses_an_onnx_file_of_another_layout(self):
        with self.assertRaisesRegex(checks.Mismatch, "NMS inside"):
            self.check("segmenter_nms.onnx")


def run_export(*options):
    python = os.environ.get("TSG_EXPORT_PYTHON", sys.executable)
    return subprocess.run([python, str(SOURCE / "scripts" / "export_models"), *options], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True)


class Program(unittest.TestCase):
    def test_unknown_segmenter_is_refused_by_name(self):
        done = run_export("--output", "/nowhere", "--segmenter", "fastsam-xl")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--segmenter is 'fastsam-xl', expected fastsam-s, fastsam-x or a file", done.stdout)

    def test_missing_photographs_are_reported(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run_export("--output", folder + "/out", "--images", folder)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn("no photographs to check with", done.stdout)
            self.assertEqual(os.listdir(folder), [])

    @unittest.skipUnless("TSG_EXPORT_PYTHON" in os.environ,
                         "needs a Python with torch, open_clip and ultralytics: name it in TSG_EXPORT_PYTHON")
    def test_random_networks_are_exported_and_checked(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run_export("--output", folder + "/out", "--random-weights", "--clip", "mobileclip2-s0")
            self.assertEqual(done.returncode, 0, done.stdout)
            for part in ("segmenter, boxes", "image encoder", "text encoder"):
                self.assertIn(part + ": ", done.stdout)
            values = yaml.safe_load(pathlib.Path(folder, "out", "models.yaml").read_text())
            self.assertEqual(values["embedding_size"], 512)
            self.assertEqual(values["image_encoder_input_size_px"], 256)


if __name__ == "__main__":
    unittest.main()
