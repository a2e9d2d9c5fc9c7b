#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""The program encode_tasks: task file in, task file with embeddings out."""
import math
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import yaml

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
PROGRAM = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph" / "encode_tasks"
NETWORK = SOURCE / "test" / "unit" / "language" / "networks" / "text_encoder.onnx"
VOCABULARY = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache",
                          "task_scene_graph", "bpe_simple_vocab_16e6.txt.gz")


@unittest.skipUnless(VOCABULARY.is_file(), "CLIP's vocabulary is not here (scripts/install_vocabulary gets it)")
class EncodeTasks(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, str(self.folder))
        self.output = self.folder / "out.yaml"

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return str(path)

    def write_models(self, embedding_size=12):
        # Only the text encoder is run; the others just have to be there.
        files = "".join("%s: %s\n" % (key, NETWORK) for key in ("segmenter", "image_encoder", "text_encoder"))
        return self.write("models.yaml", files + "name: small\nembedding_size: %d\n" % embedding_size)

    def run_program(self, *options):
        done = subprocess.run([str(PROGRAM), *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              universal_newlines=True)
        if "scripts/install_engine" in done.stdout:
            self.skipTest(done.stdout)
        return done

    def encode(self, tasks, *options):
        done = self.run_program("--models", self.write_models(), "--tasks", self.write("tasks.yaml", tasks),
                                "--output", str(self.output), *options)
        self.assertEqual(done.returncode, 0, done.stdout)
        return yaml.safe_load(self.output.read_text())["tasks"]

    def test_tasks_keep_their_order_and_get_unit_vectors(self):
        tasks = self.encode("wash the dishes: [[1, 2]]\nget a mug: []\n")
        self.assertEqual([task["name"] for task in tasks], ["wash the dishes", "get a mug"])
        for task in tasks:
            self.assertEqual(len(task["embedding"]), 12)
            self.assertAlmostEqual(math.fsum(x * x for x in task["embedding"]), 1.0, places=5)
        self.assertNotEqual(tasks[0]["embedding"], tasks[1]["embedding"])

    def test_template_is_what_the_task_is_embedded_in(self):
        plain = self.encode("- an image of a mug\n")
        filled = self.encode("- a mug\n", "--template", "an image of {}")
        self.assertEqual(plain[0]["embedding"], filled[0]["embedding"])
        self.assertNotEqual(self.encode("- a mug\n")[0]["embedding"], filled[0]["embedding"])

    def test_output_can_be_the_input_of_another_run(self):
        first = self.encode("- a mug\n- a bed\n")
        self.assertEqual(self.encode(self.output.read_text()), first)

    def test_size_that_the_model_set_does_not_have_is_an_error_and_nothing_is_written(self):
        done = self.run_program("--models", self.write_models(512), "--tasks", self.write("tasks.yaml", "- a mug\n"),
                                "--output", str(self.output))
        self.assertEqual(done.returncode, 1)
        self.assertIn("gives embeddings of 12 values, but model set 'small' (", done.stdout)
        self.assertIn("says embedding_size 512", done.stdout)
        self.assertFalse(self.output.exists())

    def test_options_that_are_missing_or_unknown_are_named(self):
        for options, message in ((["--tasks", "x"], "the option '--models' is required"),
                                 (["--taks", "x"], "unrecognised option '--taks'")):
            done = self.run_program(*options)
            self.assertEqual(done.returncode, 2)
            self.assertIn(message, done.stdout)


if __name__ == "__main__":
    unittest.main()
