# SPDX-License-Identifier: BSD-3-Clause
"""From a recording to a map and from a map to scores, by the package's programs."""
import json
import os
import subprocess
import time

from . import live, methods, results

PROGRAMS = os.path.join("devel", "lib", "task_scene_graph")


class Runner:
    """Runs the package's programs; what they say goes to a log that is named if one fails."""

    def __init__(self, root, log):
        self.root = root
        self.log = log

    def __call__(self, command):
        script = os.path.join(self.root, "scripts", command[0])
        program = script if os.path.exists(script) else os.path.join(self.root, PROGRAMS, command[0])
        with open(self.log, "a", encoding="utf-8") as log:
            log.write("$ " + " ".join(command) + "\n")
            log.flush()
            status = subprocess.call([program] + command[1:], stdout=log, stderr=log)
        if status != 0:
            raise RuntimeError(f"{command[0]} ended with status {status}; see {self.log}")


def process_bag(run, recording, tasks, config, target, program="process_bag"):
    """A map in `target`, unless it is there. config: what --config holds; None: no such option."""
    if os.path.exists(os.path.join(target, "done.json")):
        return target
    os.makedirs(target, exist_ok=True)
    command = [program, "--bag", recording.bag, "--output", target]
    if config is not None:
        path = os.path.join(target, "config.yaml")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(config, file)  # JSON is YAML
        command += ["--object-tasks", tasks, "--place-tasks", recording.place_tasks,
                    "--config", path]
    started = time.monotonic()
    run(command)
    results.write(os.path.join(target, "done.json"), {"wall_s": time.monotonic() - started})
    return target


def cluster(run, base, tasks, options, target):
    """The objects that the primitives of a map make at once, as a folder with a scene graph alone.
    Neighbours are those of the chain (object_reach), unless the options say otherwise."""
    if "--reach" not in options:
        options = ["--reach", methods.REACH] + options
    if not os.path.exists(os.path.join(target, "done.json")):
        os.makedirs(target, exist_ok=True)
        started = time.monotonic()
        run(["cluster_scene_graph", "--input", os.path.join(base, "scene_graph.json"), "--tasks",
             tasks, "--output", os.path.join(target, "scene_graph.json")] + options)
        results.write(os.path.join(target, "done.json"), {"wall_s": time.monotonic() - started})
    return target


def make_map(run, recording, tasks, name, folder):
    """Runs a front end of `methods` unless its map is there. Returns the map's folder."""
    front_end = methods.FRONT_ENDS[name]
    target = os.path.join(folder, name)
    if front_end.base is not None:
        base = make_map(run, recording, tasks, front_end.base, folder)
        return cluster(run, base, tasks, [], target)
    if front_end.program == "roslaunch":
        return live.make_map(run.root, run.log, recording, tasks, front_end.config, target)
    return process_bag(run, recording, tasks, front_end.config, target, front_end.program)


def read_stage_times(folder):
    """Work of each stage for one tracked frame in ms, from timing.json; empty where not told."""
    try:
        with open(os.path.join(folder, "timing.json"), encoding="utf-8") as file:
            stages = json.load(file)["stages"]
        return {name: stage["mean_ms"] * stage["frames"] / stages["tracking"]["frames"]
                for name, stage in stages.items()}
    except (OSError, ValueError, KeyError, ZeroDivisionError):
        return {}


def read_frames(folder):
    """(in the map, not tracked, in the recording) of a map made live; None of others."""
    with open(os.path.join(folder, "done.json"), encoding="utf-8") as file:
        done = json.load(file)
    return (done["frames_in_map"], done["frames_not_tracked"], done["frames"]) if "frames" in done else None


def evaluate(run, recording, tasks, map_folder, scores, layer="objects", keep=()):
    """Scores of a map, by all truth that the recording has for it; kept in the file `scores`.
    keep: options that say which objects count."""
    command = ["evaluate_scene_graph", "--map", map_folder, "--truth", tasks.truth, "--tasks",
               tasks.tasks, "--layer", layer, "--json", scores] + list(keep)
    has_floor = os.path.exists(os.path.join(map_folder, "floor_0.yaml"))
    if has_floor and os.path.exists(recording.rooms):
        command += ["--rooms", recording.rooms]
    if has_floor and os.path.exists(recording.mesh):
        command += ["--true-mesh", recording.mesh]
    if (layer == "objects" and os.path.exists(os.path.join(map_folder, "mesh.ply")) and
            os.path.exists(tasks.labels)):
        command += ["--labels", tasks.labels]
    run(command)
    with open(scores, encoding="utf-8") as file:
        return json.load(file)
