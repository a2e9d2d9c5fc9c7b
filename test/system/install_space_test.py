# SPDX-License-Identifier: BSD-3-Clause
"""The installed package works on its own: plugins, launch files and programs are found and run."""
import os
import pathlib
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["TSG_BUILD_DIR"])
# Not below the package's own folder: roslaunch finds each file of a package in all of it.
TEMPORARY = tempfile.TemporaryDirectory()
INSTALL = pathlib.Path(TEMPORARY.name + os.environ["TSG_INSTALL_PREFIX"])


def run_with(setup_file, command, timeout_s=60):
    """Runs a shell command that sees one space only. Returns its output."""
    setup = f"set +u; unset ROS_PACKAGE_PATH CMAKE_PREFIX_PATH; source {setup_file}"
    done = subprocess.run(["bash", "-c", f"{setup}; {command}"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=timeout_s, text=True,
                          env={**os.environ, "ROS_CACHE_TIMEOUT": "0"})
    if done.returncode != 0:
        raise AssertionError(f"'{command}' exited {done.returncode}:\n{done.stdout}")
    return done.stdout


def run_installed(command):
    return run_with(INSTALL / "setup.bash", command)


class InstallSpace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        subprocess.run(["cmake", "--install", str(BUILD)], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "DESTDIR": TEMPORARY.name})

    @classmethod
    def tearDownClass(cls):
        TEMPORARY.cleanup()

    def test_package_is_found_in_the_install_space(self):
        self.assertEqual(run_installed("rospack find task_scene_graph").strip(),
                         str(INSTALL / "share/task_scene_graph"))

    def test_nodelet_plugins_are_exported_and_their_library_is_there(self):
        plugins = run_installed("rospack plugins --attrib=plugin nodelet")
        self.assertIn(str(INSTALL / "share/task_scene_graph/nodelet_plugins.xml"), plugins)
        self.assertTrue((INSTALL / "lib/libtsg_nodelets.so").exists())

    def test_rviz_display_is_exported_and_its_library_is_there_if_it_was_built(self):
        plugins = run_installed("rospack plugins --attrib=plugin rviz")
        self.assertIn(str(INSTALL / "share/task_scene_graph/rviz_plugins.xml"), plugins)
        self.assertEqual((INSTALL / "lib/libtsg_rviz.so").exists(),
                         (BUILD / "devel/lib/libtsg_rviz.so").exists())

    def test_libraries_resolve_without_the_build_folder(self):
        for name in ("core", "simulation", "evaluation", "ros", "nodelets"):
            library = f"libtsg_{name}.so"
            output = run_installed(f"ldd {INSTALL}/lib/{library}")
            self.assertNotIn("not found", output)
            self.assertNotIn(str(BUILD / "devel"), output)

    def test_launch_files_name_only_what_is_installed(self):
        launch = INSTALL / "share/task_scene_graph/launch/task_scene_graph.launch"
        nodes = run_installed(f"roslaunch --nodes {launch} recorded_segmentation:=true "
                              "object_tasks:=/tasks.yaml")
        self.assertIn("/task_scene_graph/", nodes)

    def test_demo_models_and_their_parameters_are_installed(self):
        for name in ("models/demo/models.yaml", "models/demo/segmenter.onnx", "config/demo.yaml"):
            self.assertTrue((INSTALL / "share/task_scene_graph" / name).exists(), name)

    def test_process_bag_runs(self):
        self.assertIn("--bag", run_installed("rosrun task_scene_graph process_bag --help"))

    def test_launch_files_are_found_once_in_the_devel_space(self):
        files = run_with(BUILD / "devel/setup.bash",
                         "roslaunch --files task_scene_graph task_scene_graph.launch "
                         "recorded_segmentation:=true object_tasks:=/tasks.yaml")
        self.assertIn("task_scene_graph.launch", files)


if __name__ == "__main__":
    unittest.main()
