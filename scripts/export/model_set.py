# SPDX-License-Identifier: BSD-3-Clause
"""The model set's YAML file, and the check that our own programs read it."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

import numpy

import checks


def write(path, values):
    """Writes a flat map; JSON's scalars and lists are YAML."""
    lines = ["%s: %s\n" % (key, json.dumps(value)) for key, value in values.items()]
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_text("# Written by scripts/export_models. Paths are relative to this file.\n" + "".join(lines))
    os.replace(str(temporary), str(path))


def find_program(name):
    """One of our own programs, if it is built: $TSG_<NAME>, this checkout's build, or on the PATH."""
    root = pathlib.Path(__file__).resolve().parents[2]
    built = root / "build" / "devel" / "lib" / "task_scene_graph" / name
    candidates = [os.environ.get("TSG_" + name.upper(), ""), str(built), shutil.which(name) or ""]
    return next((path for path in candidates if path and os.access(path, os.X_OK)), None)


def check_with_our_segmenter(yaml_path, image_path):
    """Runs our C++ segmenter, which knows the layouts that others give. Returns a line of text."""
    program = find_program("segment_images")
    if not program:
        return "our own segmenter: not built, not checked (scripts/build segment_images)"
    with tempfile.TemporaryDirectory(dir=str(yaml_path.parent)) as folder:
        done = subprocess.run([program, "--models", str(yaml_path), "--output", folder, str(image_path)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    text = done.stdout.decode(errors="replace").strip()
    if done.returncode != 0:
        raise checks.Mismatch("segment_images refuses the model set: " + text)
    return "our own segmenter: " + text.split(": ", 1)[-1]


def parse_embeddings(path):
    """Rows of what encode_tasks writes."""
    rows = []
    for line in pathlib.Path(path).read_text().splitlines():
        name, found, values = line.partition("embedding: ")
        if found:
            rows.append(json.loads(values))
    return numpy.array(rows)


def check_with_our_encoder(yaml_path, texts, expected):
    """Compares our C++ tokenizer and encoder with the source framework. Returns a line of text."""
    program = find_program("encode_tasks")
    if not program:
        return "our own text encoder: not built, not checked (scripts/build encode_tasks)"
    # A task has to be a name: those that are none are left out.
    kept = [i for i, text in enumerate(texts) if text.strip()]
    tasks, result = yaml_path.with_name("check_tasks.yaml"), yaml_path.with_name("check_result.yaml")
    tasks.write_text("".join("- %s\n" % json.dumps(texts[i].strip()) for i in kept))
    done = subprocess.run([program, "--models", str(yaml_path), "--tasks", str(tasks), "--output", str(result)],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        raise checks.Mismatch("encode_tasks refuses the model set: " + done.stdout.decode(errors="replace").strip())
    actual = parse_embeddings(result)
    tasks.unlink()
    result.unlink()
    return checks.compare_embeddings("our own text encoder", expected[kept], actual)
