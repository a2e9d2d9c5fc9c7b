# SPDX-License-Identifier: BSD-3-Clause
"""Maps made of bags and of parts of bags, and what they hold, for tests."""
import json
import pathlib
import subprocess

import rosbag

from ros_session import PROGRAMS


def run(program, *arguments, timeout=300, **options):
    return subprocess.run([str(PROGRAMS / program), *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, universal_newlines=True, timeout=timeout, **options)


def run_well(program, *arguments):
    """What it printed; it must have ended well."""
    done = run(program, *arguments, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def cut_bag(source, target, first_s, end_s):
    """Copies what lies between two times, and all transforms, which lead there."""
    with rosbag.Bag(str(source)) as read, rosbag.Bag(str(target), "w") as written:
        start = read.get_start_time()
        for topic, message, when in read.read_messages():
            if topic in ("/tf", "/tf_static") or first_s <= when.to_sec() - start < end_s:
                written.write(topic, message, when)


def read_objects(folder):
    """Task, lower and upper corner of each object."""
    summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
    return [(thing["task"], thing["box_min_m"], thing["box_max_m"])
            for room in summary["rooms"] for thing in room["objects"]]


def compute_iou(a, b):
    shared, volume_a, volume_b = 1.0, 1.0, 1.0
    for i in range(3):
        shared *= max(0.0, min(a[2][i], b[2][i]) - max(a[1][i], b[1][i]))
        volume_a *= a[2][i] - a[1][i]
        volume_b *= b[2][i] - b[1][i]
    return shared / (volume_a + volume_b - shared)


def find_lost(objects, others, least=0.5):
    """Those for which none of the same task among the others has a box that overlaps."""
    return [a for a in objects if not any(a[0] == b[0] and compute_iou(a, b) >= least for b in others)]


def list_files(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in pathlib.Path(folder).rglob("*")
            if path.is_file()}
