# SPDX-License-Identifier: BSD-3-Clause
"""correct_map: a map built with drifting poses that follows the true ones."""
import json
import math
import pathlib
import shutil
import tempfile
import unittest

from map_folders import run

DURATION_S = 12.0


def read_poses(path):
    lines = pathlib.Path(path).read_text().splitlines()
    return [line.split() for line in lines if line and not line.startswith("#")]


def drift(poses):
    """Each pose turned about the vertical through the origin and shifted, more and more."""
    first = float(poses[0][0])
    drifted = []
    for stamp, *numbers in poses:
        x, y, z, qx, qy, qz, qw = map(float, numbers)
        way = float(stamp) - first
        half = 0.5 * 0.008 * way
        c, s = math.cos(2 * half), math.sin(2 * half)
        a, b = math.cos(half), math.sin(half)
        q = (a * qx - b * qy, a * qy + b * qx, a * qz + b * qw, a * qw - b * qz)
        drifted.append([stamp, c * x - s * y + 0.03 * way, s * x + c * y - 0.02 * way, z, *q])
    return drifted


def write_poses(path, poses):
    path.write_text("".join(" ".join(str(value) for value in pose) + "\n" for pose in poses))


def read_objects(folder):
    summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
    return [(thing["task"], [0.5 * (low + high) for low, high in zip(thing["box_min_m"], thing["box_max_m"])])
            for room in summary["rooms"] for thing in room["objects"]]


def mean_error(objects, truth):
    """Of each true object to the nearest of its task; 1 m where there is none so near."""
    errors = [min([math.dist(a, b) for task, b in objects if task == of] + [1.0]) if hasattr(math, "dist") else
              min([math.sqrt(sum((p - q) ** 2 for p, q in zip(a, b))) for task, b in objects if task == of] + [1.0])
              for of, a in truth]
    return sum(errors) / len(errors)


class CorrectMap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.tasks = cls.folder / "home.object_tasks.yaml"
        done = run("simulate_apartment", "--output", cls.folder / "home.bag", "--seed", "3", "--width", "160",
                   "--height", "120", "--duration", DURATION_S, "--rate", "10")
        assert done.returncode == 0, done.stderr
        cls.process("truth")
        poses = read_poses(cls.folder / "truth" / "trajectory.txt")
        write_poses(cls.folder / "drifted.tum", drift(poses))
        cls.process("drifted", "input: {trajectory: drifted.tum}\nmesh_fusion: {occupancy: {enabled: true}}\n")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def process(cls, name, text=""):
        config = cls.folder / (name + ".yaml")
        config.write_text(text)
        done = run("process_bag", "--bag", cls.folder / "home.bag", "--object-tasks", cls.tasks, "--output",
                   cls.folder / name, "--config", config)
        assert done.returncode == 0, done.stderr

    def path(self, name):
        return self.folder / name

    def correct(self, output, *arguments):
        done = run("correct_map", "--map", self.path("drifted"), "--output", self.path(output), *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_objects_and_poses_are_where_they_truly_are(self):
        said = self.correct("mended", "--trajectory", self.path("truth") / "trajectory.txt")
        self.assertRegex(said, r"keyframes moved by up to 0\.\d+ m")
        truth = read_objects(self.path("truth"))
        self.assertGreater(len(truth), 3)
        before = mean_error(read_objects(self.path("drifted")), truth)
        after = mean_error(read_objects(self.path("mended")), truth)
        self.assertLess(after, 0.3 * before, (before, after))
        true_poses = {pose[0]: pose[1:4] for pose in read_poses(self.path("truth") / "trajectory.txt")}
        for stamp, *numbers in read_poses(self.path("mended") / "trajectory.txt"):
            for found, expected in zip(numbers[:3], true_poses[stamp]):
                self.assertAlmostEqual(float(found), float(expected), delta=0.01)

    def test_ids_stay_and_the_map_can_be_gone_on_from_and_asked(self):
        self.correct("mended_again", "--trajectory", self.path("truth") / "trajectory.txt")

        def read_ids(name):
            graph = json.loads((self.path(name) / "scene_graph.json").read_text())
            return sorted(node["id"] for node in graph["nodes"] if node["layer"] == 1)
        self.assertGreater(len(read_ids("drifted")), 0)
        self.assertEqual(read_ids("mended_again"), read_ids("drifted"))
        files = {path.name for path in self.path("mended_again").iterdir()}
        self.assertGreater(files, {"map.json", "mesh.ply", "map.bt", "map.ot", "scene_graph.json"})
        went_on = run("process_bag", "--bag", self.path("home.bag"), "--object-tasks", self.tasks, "--map",
                      self.path("mended_again"), "--output", self.path("went_on"), "--config",
                      self.path("drifted.yaml"))
        self.assertEqual(went_on.returncode, 0, went_on.stderr)

    def test_poses_of_another_body_with_the_old_ones_of_it_do_the_same(self):
        def lift(source, name):
            write_poses(self.path(name), [[p[0], p[1], p[2], float(p[3]) + 2.0, *p[4:]] for p in source])
        lift(read_poses(self.path("drifted.tum")), "old.tum")
        lift(read_poses(self.path("truth") / "trajectory.txt"), "new.tum")
        self.correct("by_body", "--old", self.path("old.tum"), "--trajectory", self.path("new.tum"))
        self.correct("by_camera", "--trajectory", self.path("truth") / "trajectory.txt")
        a, b = read_objects(self.path("by_body")), read_objects(self.path("by_camera"))
        self.assertEqual(len(a), len(b))
        self.assertLess(mean_error(a, b), 1e-3)

    def test_its_own_trajectory_changes_nothing(self):
        self.correct("same", "--trajectory", self.path("drifted") / "trajectory.txt")
        for name in ("scene_graph.json", "mesh.ply", "trajectory.txt", "map.ot", "floor_0.pgm"):
            before, after = self.path("drifted") / name, self.path("same") / name
            if before.exists():
                self.assertEqual(before.read_bytes(), after.read_bytes(), name)

    def test_faults_are_named_and_nothing_is_written(self):
        poses = read_poses(self.path("drifted.tum"))
        write_poses(self.path("later.tum"), [[float(pose[0]) + 1e4, *pose[1:]] for pose in poses])
        write_poses(self.path("far.tum"), [[pose[0], 900.0, *pose[2:]] for pose in poses])
        self.path("empty.tum").write_text("# nothing\n")
        self.path("bad.tum").write_text("1 2 3\n")
        for name, expected in (("later.tum", "lie within the map's"), ("far.tum", "max_motion_m"),
                               ("empty.tum", "holds no pose"), ("bad.tum", "bad.tum"), ("none.tum", "none.tum")):
            done = run("correct_map", "--map", self.path("drifted"), "--trajectory", self.path(name), "--output",
                       self.path("not_there"))
            self.assertEqual(done.returncode, 1, name)
            self.assertIn(expected, done.stderr)
            self.assertFalse(self.path("not_there").exists(), name)
        no_map = run("correct_map", "--map", self.folder, "--trajectory", self.path("drifted.tum"), "--output",
                     self.path("not_there"))
        self.assertEqual(no_map.returncode, 1)
        self.assertIn("map.json", no_map.stderr)
        self.assertEqual(run("correct_map", "--map", self.folder).returncode, 2)

    def test_a_map_can_be_corrected_in_place(self):
        shutil.copytree(str(self.path("drifted")), str(self.path("in_place")))
        done = run("correct_map", "--map", self.path("in_place"), "--output", self.path("in_place"), "--trajectory",
                   self.path("truth") / "trajectory.txt")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.correct("beside", "--trajectory", self.path("truth") / "trajectory.txt")
        self.assertEqual((self.path("in_place") / "mesh.ply").read_bytes(),
                         (self.path("beside") / "mesh.ply").read_bytes())


if __name__ == "__main__":
    unittest.main()
