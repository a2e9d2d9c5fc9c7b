# SPDX-License-Identifier: BSD-3-Clause
"""Which value of a parameter holds: order of the sources, what outlasts a run, numbers, paths; live under one
master, through the launch file, and offline."""
import os
import pathlib
import signal
import tempfile
import unittest

import yaml

from ros_session import PROGRAMS, SOURCE, Session, wait_until

TASKS = SOURCE / "test" / "data" / "box_tasks.yaml"
NODE = "/task_scene_graph"


class LiveTest(unittest.TestCase):
    """Each test has a master of its own, under which it may launch more than once."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(os.path.realpath(self.temporary.name))
        self.session = Session(self.folder)
        self.addCleanup(self.session.close)
        self.num_launched = 0

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def write_model_set(self, name, alpha):
        for network in ("segmenter.onnx", "image.onnx"):
            self.write("models/" + network, "only has to be there")
        return self.write("models/%s.yaml" % name,
                          "{name: %s, segmenter: segmenter.onnx, image_encoder: image.onnx, embedding_size: 4,"
                          " alpha: %s}" % (name, alpha))

    def launch(self, *arguments, cwd=None, tasks=TASKS, until_running=True):
        self.num_launched += 1
        given = ["object_tasks:=%s" % tasks] if tasks else []
        launched = self.session.start(
            ["roslaunch", "task_scene_graph", "task_scene_graph.launch", "rviz:=false",
             "recorded_segmentation:=true"] + given + list(arguments), "launch_%d" % self.num_launched, cwd)
        if until_running:
            wait_until(lambda: self.is_up(launched), "the chain")
        return launched

    def is_up(self, launched):
        if not launched.is_running():
            raise AssertionError("roslaunch ended:\n" + launched.output())
        done = self.session.list_parameters("--node", NODE)
        waiting = [line for line in done.stderr.splitlines() if "does not run" in line]
        return done.returncode == 0 and waiting == [NODE + "/segmenter does not run: as it would start now"]

    def settings(self):
        """Value and source of every parameter in force."""
        done = self.session.list_parameters("--effective", "--node", NODE)
        self.assertEqual(done.returncode, 0, done.stderr)
        running = [line for line in done.stderr.splitlines() if "does not run" in line]
        self.assertEqual(len(running), 1, done.stderr)  # the segmenter
        return read_settings(done.stdout)

    def value(self, name):
        return self.settings()[name][0]


def remove_run(text):
    """Settings of stages that both know, but for where they are written."""
    settings = yaml.safe_load(text)
    for name in ("made_with", "segmenter"):  # there was no segmenter live
        settings.pop(name, None)
    for stage in ("mesh_fusion", "scene_graph"):
        settings[stage].pop("output")
    return settings


def read_settings(text):
    found = {}
    for line in text.splitlines():
        name, rest = line.split(": ", 1)
        value, origin = rest.split("  # ", 1)
        found[name] = (yaml.safe_load(value), origin)
    return found


class OrderOfSources(LiveTest):
    def test_users_file_wins_over_the_packages_defaults(self):
        config = self.write("my.yaml", "input: {world_frame: map, camera_frame: eye}\n"
                                       "tracker: {window_s: 3, input: {sync_tolerance_s: 0.05}}\n"
                                       "output: maps/today\n")
        self.launch("config:=%s" % config)
        settings = self.settings()
        origin = "file '%s'" % config
        self.assertEqual(settings["tracker/input/sync_tolerance_s"], (0.05, origin))
        self.assertEqual(settings["mesh_fusion/input/sync_tolerance_s"], (0.02, "packaged default"))
        self.assertEqual(settings["tracker/window_s"], (3, origin))
        for stage in ("tracker/input", "mesh_fusion/input", "scene_graph"):
            self.assertEqual(settings[stage + "/world_frame"], ("map", origin), stage)
        self.assertEqual(settings["mesh_fusion/input/camera_frame"], ("eye", origin))
        self.assertEqual(settings["scene_graph/output"], (str(self.folder / "maps/today"), origin))
        self.assertEqual(settings["mesh_fusion/output"], (str(self.folder / "maps/today"), origin))
        self.assertEqual(settings["mesh_fusion/queue_size"][1], "default")

    def test_launch_argument_wins_over_the_file_only_where_it_was_given(self):
        config = self.write("my.yaml", "input: {world_frame: map, camera_frame: eye}\n"
                                       "mesh_fusion: {output: /from/file, input: {world_frame: odom}}\n"
                                       "scene_graph: {output: /from/file}\n")
        self.launch("config:=%s" % config, "world_frame:=earth", "output:=none")
        settings = self.settings()
        for name in ("tracker/input/world_frame", "mesh_fusion/input/world_frame", "scene_graph/world_frame"):
            self.assertEqual(settings[name], ("earth", "parameter server"), name)
        self.assertEqual(settings["tracker/input/camera_frame"][0], "eye")
        self.assertEqual(settings["mesh_fusion/output"], ("", "parameter server"))

    def test_topics_of_launch_arguments_win_over_the_file_only_where_they_were_given(self):
        config = self.write("my.yaml", "input: {color_topic: /file/color, depth_topic: /file/depth,\n"
                                       "        segmentation_topic: /file/segments}\n"
                                       "mesh_fusion: {input: {color_topic: /file/own}}\n")
        self.launch("config:=%s" % config, "color_topic:=/given/color", "segmentation_topic:=/given/segments")
        settings = self.settings()
        for stage in ("segmenter", "tracker", "mesh_fusion"):
            self.assertEqual(settings[stage + "/input/color_topic"], ("/given/color", "parameter server"))
            self.assertEqual(settings[stage + "/input/segmentation_topic"][0], "/given/segments")
            self.assertEqual(settings[stage + "/input/depth_topic"], ("/file/depth", "file '%s'" % config))
        for topic in ("/given/color", "/given/segments", "/file/depth", "/camera/color/camera_info"):
            self.assertIn(NODE, self.subscribers(topic), topic)
        for topic in ("/file/color", "/file/own", "/file/segments", "/camera/color/image_raw"):
            self.assertEqual(self.subscribers(topic), "", topic)

    def subscribers(self, topic):
        done = self.session.run("rostopic", "info", topic)
        return done.stdout.partition("Subscribers:")[2] if done.returncode == 0 else ""

    def test_topics_reach_the_chain_through_every_launch_file(self):
        given = ["%s_topic:=/given/%s" % (name, name) for name in ("color", "depth", "camera_info", "segmentation")]
        for name in ("demo", "clio_dataset"):
            done = self.session.run("roslaunch", "--dump-params", "task_scene_graph", name + ".launch", "bag:=x.bag",
                                    "object_tasks:=%s" % TASKS, "rviz:=false", *given)
            parameters = yaml.safe_load(done.stdout)
            for topic in ("color", "depth", "camera_info", "segmentation"):
                self.assertEqual(parameters["%s/input/%s_topic" % (NODE, topic)], "/given/" + topic, name)

    def test_slash_before_a_frame_is_taken_off_in_every_stage(self):
        config = self.write("my.yaml", "input: {camera_frame: /eye}\nmesh_fusion: {input: {pose_frame: /body}}\n")
        self.launch("config:=%s" % config, "world_frame:=/map")
        settings = self.settings()
        for name in ("tracker/input/world_frame", "mesh_fusion/input/world_frame", "scene_graph/world_frame"):
            self.assertEqual(settings[name][0], "map", name)
        self.assertEqual(settings["tracker/input/camera_frame"][0], "eye")
        self.assertEqual(settings["mesh_fusion/input/pose_frame"][0], "body")

    def test_without_any_word_the_map_goes_to_the_home_folder(self):
        self.launch()
        self.assertEqual(self.settings()["scene_graph/output"],
                         (str(self.folder / "task_scene_graph_map"), "packaged default"))

    def test_model_set_suggests_and_the_users_file_wins(self):
        models = self.write_model_set("low", 0.11)
        config = self.write("my.yaml", "scene_graph: {object_alpha: 0.3}\n")
        first = self.launch("models:=%s" % models)
        self.assertEqual(self.settings()["scene_graph/object_alpha"], (0.11, "model set 'low'"))
        first.interrupt()
        self.launch("models:=%s" % models, "config:=%s" % config)
        self.assertEqual(self.value("scene_graph/object_alpha"), 0.3)

    def test_all_may_stand_in_the_file(self):
        self.write("tasks.yaml", TASKS.read_text())
        config = self.write("my.yaml", "models: models/low.yaml\noutput: map\n"
                                       "scene_graph: {object_tasks: tasks.yaml}\n")
        self.write_model_set("low", 0.11)
        self.launch("config:=%s" % config, tasks=None)
        settings = self.settings()
        self.assertEqual(settings["scene_graph/object_tasks"][0], str(self.folder / "tasks.yaml"))
        self.assertEqual(settings["scene_graph/object_alpha"][0], 0.11)


class NothingOutlastsARun(LiveTest):
    def dynparam(self, *words):
        done = self.session.run("rosrun", "dynamic_reconfigure", "dynparam", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_alpha_is_that_of_the_second_launchs_model_set(self):
        first = self.launch("models:=%s" % self.write_model_set("low", 0.11))
        self.assertEqual(self.value("scene_graph/object_alpha"), 0.11)
        first.kill()
        self.launch("models:=%s" % self.write_model_set("high", 0.4))
        self.assertEqual(self.settings()["scene_graph/object_alpha"], (0.4, "model set 'high'"))

    def test_what_was_tuned_is_forgotten_even_after_kill_9(self):
        first = self.launch()
        self.dynparam("set", NODE + "/scene_graph", "place_top_k", "7")
        self.dynparam("set", NODE + "/scene_graph", "object_delta", "1e-3")
        tuned = yaml.safe_load(self.dynparam("get", NODE + "/scene_graph"))
        self.assertEqual((tuned["place_top_k"], tuned["object_delta"]), (7, 1e-3))
        self.assertEqual(self.settings()["scene_graph/place_top_k"], (7, "dynamic_reconfigure"))
        self.assertEqual(self.settings()["scene_graph/place_alpha"], (0.21, "packaged default"))
        first.kill()
        self.launch()
        self.assertEqual(self.settings()["scene_graph/place_top_k"], (1, "default"))
        again = yaml.safe_load(self.dynparam("get", NODE + "/scene_graph"))
        self.assertEqual((again["place_top_k"], float(again["object_delta"])), (1, 1e-5))

    def test_a_run_writes_no_parameter(self):
        self.launch()
        before = self.session.run("rosparam", "dump").stdout
        self.dynparam("set", NODE + "/scene_graph", "place_top_k", "7")
        self.assertEqual(self.session.run("rosparam", "dump").stdout, before)

    def test_yesterdays_file_and_what_was_set_by_hand_are_gone(self):
        first = self.launch("config:=%s" % self.write("my.yaml", "tracker: {window_s: 3}\n"))
        self.assertEqual(self.value("tracker/window_s"), 3)
        first.kill()
        for name, value in (("tracker/window_s", "9"), ("input/world_frame", "moon"),
                            ("scene_graph/object_delta", "0.5")):
            self.session.run("rosparam", "set", NODE + "/" + name, value)
        self.launch()
        settings = self.settings()
        self.assertEqual(settings["tracker/window_s"], (5, "packaged default"))
        self.assertEqual(settings["tracker/input/world_frame"][0], "world")
        self.assertEqual(settings["scene_graph/object_delta"][0], 1e-5)

    def test_value_out_of_range_or_unknown_leaves_what_holds(self):
        launched = self.launch()
        self.dynparam("set", NODE + "/scene_graph", "object_alpha", "5.0")
        self.assertEqual(self.value("scene_graph/object_alpha"), 1)
        self.dynparam("set", NODE + "/scene_graph", "object_alpha", "nan")
        self.assertEqual(self.value("scene_graph/object_alpha"), 1)
        wait_until(lambda: "object_alpha = 5.000000 is out of range" in launched.output(), "a warning")
        wait_until(lambda: "refused, nothing is changed" in launched.output(), "a warning")


# Texts, and which kinds of parameters take them from a file (n: number, i: whole number, b: boolean, s: string).
LITERALS = {"1e-3": "ns", "1e-1": "ns", "1E-1": "ns", ".5": "ns", "0.5": "ns", "1.": "nis", "+1": "nis",
            "1": "nis", "1.0": "nis", "1e0": "nis", "1_0": "is", "010": "s", "08": "s", "0x1": "nis",
            "0b1": "nis", "0o1": "s", "1:30": "s", ".inf": "s", "-.inf": "s", ".nan": "s", "yes": "bs",
            "no": "bs", "on": "bs", "off": "bs", "true": "bs", "FALSE": "bs", "y": "bs", "'0.5'": "ns",
            "'on'": "bs", "\"1\"": "nis", "~": "", "null": "", "": "", "abc": "s", "'~'": "s", "2024-01-01": "s",
            "0,5": "s", "[1]": "", "{a: 1}": "", "1.5": "s", "-1": "s", "'1e-3 '": "s"}
FIELDS = {"n": "scene_graph/place_delta", "i": "tracker/min_observations", "b": "scene_graph/prune_null",
          "s": "input/world_frame"}
READ_AS = {"n": "scene_graph/place_delta", "i": "tracker/min_observations", "b": "scene_graph/prune_null",
           "s": "mesh_fusion/input/world_frame"}


class SameTextSameValue(LiveTest):
    """Literals in a file (offline, as live: stages read the file themselves) and through rosparam's loader."""

    def read_file(self, kind, literal):
        section, name = FIELDS[kind].split("/")
        config = self.write("literal.yaml", "%s:\n  %s: %s\n" % (section, name, literal))
        return config, self.session.list_parameters("--config", config, "--value", READ_AS[kind])

    def read_server(self, kind, config):
        self.session.run("rosparam", "delete", NODE)
        if self.session.run("rosparam", "load", config, NODE).returncode != 0:
            return None
        return self.session.list_parameters("--node", NODE, "--value", READ_AS[kind])

    def test_each_literal_is_one_value_or_an_error_that_names_parameter_and_file(self):
        num_same = 0
        for literal, kinds in LITERALS.items():
            for kind in FIELDS:
                with self.subTest(literal=literal, parameter=FIELDS[kind]):
                    config, from_file = self.read_file(kind, literal)
                    self.assertEqual(from_file.returncode, 0 if kind in kinds else 1, from_file.stderr)
                    if from_file.returncode != 0:
                        self.assertIn(FIELDS[kind].split("/")[1], from_file.stderr)
                        self.assertIn(str(config), from_file.stderr)
                        continue
                    from_server = self.read_server(kind, config)
                    if from_server is None:
                        continue  # rosparam itself refuses it
                    if from_server.returncode != 0:
                        self.assertIn(FIELDS[kind].split("/")[1], from_server.stderr)
                        self.assertIn("parameter server", from_server.stderr)
                        continue
                    self.assertEqual(from_server.stdout, from_file.stdout)
                    num_same += 1
        self.assertGreater(num_same, 40)

    def test_number_in_scientific_notation_reaches_the_running_stage(self):
        config = self.write("my.yaml", "scene_graph: {object_delta: 1e-3, place_delta: .25, place_top_k: 3.0}\n")
        self.launch("config:=%s" % config)
        settings = self.settings()
        self.assertEqual(settings["scene_graph/object_delta"][0], 1e-3)
        self.assertEqual(settings["scene_graph/place_delta"][0], 0.25)
        self.assertEqual(settings["scene_graph/place_top_k"][0], 3)
        tuned = yaml.safe_load(self.session.run("rosrun", "dynamic_reconfigure", "dynparam", "get",
                                                NODE + "/scene_graph").stdout)
        self.assertEqual(tuned["object_delta"], 1e-3)


class Paths(LiveTest):
    def test_launch_arguments_are_relative_to_where_roslaunch_was_started(self):
        work = self.folder / "work"
        work.mkdir()
        self.write("work/tasks.yaml", TASKS.read_text())
        self.write("work/my.yaml", "tracker: {window_s: 3}\n")
        self.launch("config:=my.yaml", "output:=../maps/a", cwd=work, tasks="tasks.yaml")
        settings = self.settings()
        self.assertEqual(settings["tracker/window_s"], (3, "file '%s'" % (work / "my.yaml")))
        self.assertEqual(settings["scene_graph/object_tasks"][0], str(work / "tasks.yaml"))
        self.assertEqual(settings["scene_graph/output"][0], str(self.folder / "maps/a"))

    def test_home_variables_and_file_scheme_are_expanded(self):
        self.write("tasks.yaml", TASKS.read_text())
        self.write("my.yaml", "tracker: {window_s: 3}\n")
        self.write_model_set("low", 0.11)
        self.launch("config:=~/my.yaml", "output:=$HOME/my map", "models:=file://~/models/low.yaml",
                    tasks="~/tasks.yaml")
        settings = self.settings()
        self.assertEqual(settings["tracker/window_s"][0], 3)
        self.assertEqual(settings["scene_graph/output"][0], str(self.folder / "my map"))
        self.assertEqual(settings["scene_graph/object_alpha"][0], 0.11)
        self.assertEqual(settings["scene_graph/object_tasks"][0], str(self.folder / "tasks.yaml"))

    def assert_refused(self, words, *arguments, tasks=TASKS):
        launched = self.launch(*arguments, tasks=tasks, cwd=self.folder, until_running=False)
        wait_until(lambda: not launched.is_running(), "the end of roslaunch")
        for word in words:
            self.assertIn(word, launched.output())

    def test_missing_file_is_named_by_its_full_path(self):
        self.assert_refused(["'%s/none.yaml' is not there" % self.folder], tasks="none.yaml")
        self.assert_refused(["'%s/none.yaml' is not there" % self.folder], "config:=~/none.yaml")
        self.assert_refused(["TSG_NO_SUCH"], "config:=$TSG_NO_SUCH/a.yaml")

    def test_wrong_value_is_named_with_its_file(self):
        config = self.write("my.yaml", "tracker: {window_s: soon}\n")
        self.assert_refused(["window_s' is 'soon', expected double (file '%s')" % config], "config:=%s" % config)


class EndOfTheChain(LiveTest):
    def test_without_a_frame_one_line_says_that_no_map_was_written_and_why(self):
        launched = self.launch("output:=%s" % (self.folder / "map"))
        launched.interrupt()
        lines = [line for line in launched.output().splitlines() if "no map was written" in line]
        self.assertEqual(len(lines), 1, launched.output())
        self.assertIn("no map was written: no colour image arrived", lines[0])
        self.assertFalse((self.folder / "map").exists())
        self.assertFalse((self.folder / "~").exists())

    def test_one_line_says_which_files_were_written_and_process_bag_takes_their_settings(self):
        bag, output = self.folder / "home.bag", self.folder / "map"
        self.session.run(PROGRAMS / "simulate_apartment", "--output", bag, "--seed", "3", "--width", "160",
                         "--height", "120", "--duration", "4")
        launched = self.launch("output:=%s" % output, "use_sim_time:=true",
                               tasks=self.folder / "home.object_tasks.yaml")
        self.session.run("rosbag", "play", "--clock", "--quiet", bag)
        saved = self.session.run("rosservice", "call", NODE + "/scene_graph/save_map")
        self.assertIn("success: True", saved.stdout, saved.stderr + launched.output())
        launched.interrupt()
        lines = [line for line in launched.output().splitlines() if "wrote %s: " % output in line]
        self.assertEqual(len(lines), 2, launched.output())  # save_map, end
        for line in lines:
            self.assertRegex(line, r"scene_graph\.json \(\d+ objects?, \d+ regions?, \d+ places?\)")
            self.assertRegex(line, r"mesh\.ply \(\d+ vertices\)")
            self.assertIn("settings.yaml", line)
        again = self.session.run(PROGRAMS / "process_bag", "--bag", bag, "--config", output / "settings.yaml",
                                 "--output", self.folder / "again")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(*(remove_run((folder / "settings.yaml").read_text())
                           for folder in (output, self.folder / "again")))

    def start_chain(self, *arguments):
        self.session.run("rosparam", "set", "/scene_graph/object_tasks", TASKS)
        chain = self.session.start([PROGRAMS / "chain_node", "--recorded-segmentation", *arguments], "chain")
        wait_until(lambda: "/scene_graph/flush" in self.session.run("rosservice", "list").stdout, "the chain")
        return chain

    def test_exit_status_is_one_where_a_map_was_asked_for_and_none_written(self):
        for stage in ("scene_graph", "mesh_fusion"):
            self.session.run("rosparam", "set", "/%s/output" % stage, self.folder / "map")
        chain = self.start_chain()
        self.assertEqual(chain.interrupt(), 1, chain.output())
        self.assertIn("no map was written", chain.output())

    def test_exit_status_is_zero_where_no_map_was_asked_for(self):
        chain = self.start_chain()
        self.assertEqual(chain.interrupt(signal.SIGTERM), 0, chain.output())
        self.assertNotIn("no map was written", chain.output())

    def test_tasks_without_a_task_are_a_warning(self):
        tasks = self.write("none.yaml", "tasks: []\n")
        launched = self.launch(tasks=tasks)
        self.assertIn("task file '%s' holds no task: there will be no objects" % tasks, launched.output())


class Programs(LiveTest):
    NODES = ("chain_node", "segmenter_node", "tracker_node", "mesh_fusion_node", "scene_graph_node")

    def test_signals_end_the_programs_while_there_is_no_master(self):
        self.session.env["ROS_MASTER_URI"] = "http://127.0.0.1:1"
        for name in self.NODES:
            for number in (signal.SIGINT, signal.SIGTERM):
                program = self.session.start([PROGRAMS / name], name)
                wait_until(lambda: "no ROS master" in program.output(), "the message of " + name)
                self.assertEqual(program.interrupt(number), 128 + number, name)
                self.assertIn("http://127.0.0.1:1", program.output())

    def test_help_is_help_and_needs_no_master(self):
        self.session.env["ROS_MASTER_URI"] = "http://127.0.0.1:1"
        for name in self.NODES:
            done = self.session.run(PROGRAMS / name, "--help")
            self.assertEqual(done.returncode, 0, name)
            self.assertIn("usage: " + name, done.stdout)

    def test_unknown_option_is_refused(self):
        done = self.session.run(PROGRAMS / "chain_node", "--recorded")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--recorded", done.stderr)

    def test_manager_may_be_named_relative_to_where_the_launch_file_is_included(self):
        launch = self.write("robot.launch",
                            '<launch><group ns="robot">'
                            '<include file="$(find task_scene_graph)/launch/task_scene_graph.launch">'
                            '<arg name="manager" value="camera"/><arg name="recorded_segmentation" value="true"/>'
                            '<arg name="object_tasks" value="%s"/><arg name="rviz" value="false"/>'
                            '</include></group></launch>' % TASKS)
        launched = self.session.start(["roslaunch", launch], "robot")
        wait_until(lambda: "waiting for the nodelet manager /robot/camera" in launched.output(), "the message")
        manager = self.session.start(
            ["rosrun", "nodelet", "nodelet", "manager", "__name:=camera", "__ns:=/robot"], "camera")
        services = ["/robot/task_scene_graph/%s/flush" % stage
                    for stage in ("tracker", "mesh_fusion", "scene_graph")]
        wait_until(lambda: set(services) <= set(self.session.run("rosservice", "list").stdout.split()),
                   "the stages")
        manager.interrupt()  # there, each stage says its own last words
        self.assertIn("[/robot/task_scene_graph/mesh_fusion] no map was written: no colour image arrived",
                      manager.output())

    def test_rviz_is_started_in_the_frame_of_the_map(self):
        launch = ["roslaunch", "--args", "/rviz", "task_scene_graph", "task_scene_graph.launch",
                  "object_tasks:=%s" % TASKS]
        self.assertIn(" -f map", self.session.run(*launch, "world_frame:=map").stdout)
        self.assertIn("start_rviz", self.session.run(*launch).stdout)

    def test_a_robot_of_several_has_its_topics_in_its_namespace(self):
        launch = self.write("robots.launch", """<launch><group ns="robot1">
          <include file="$(find task_scene_graph)/launch/task_scene_graph.launch">
            <arg name="robot" value="/robot1"/><arg name="object_tasks" value="tasks.yaml"/>
            <arg name="rviz" value="false"/></include></group></launch>""")
        command = self.session.run("roslaunch", "--args", "/robot1/task_scene_graph/manager", launch).stdout
        for topic in ("camera/color/image_raw", "camera/aligned_depth_to_color/image_raw",
                      "camera/color/camera_info", "segmentation"):
            self.assertIn("%s:=/robot1/%s" % (topic, topic), command)
        command = self.session.run("roslaunch", "--args", "/task_scene_graph/manager", "task_scene_graph",
                                   "task_scene_graph.launch", "object_tasks:=%s" % TASKS).stdout
        self.assertIn(" segmentation:=/segmentation", command)

    def test_frame_of_the_map_is_known_before_the_stages_run(self):
        config = self.write("my.yaml", "input: {world_frame: odom}\n")
        self.session.run("rosparam", "set", NODE + "/config_file", config)
        done = self.session.list_parameters("--node", NODE, "--value", "scene_graph/world_frame")
        self.assertEqual(done.stdout, "odom\n", done.stderr)


class Effective(unittest.TestCase):
    """list_parameters --effective without a master."""

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(os.path.realpath(self.temporary.name))

    def run_program(self, *options):
        return Session.run(self, PROGRAMS / "list_parameters", *options)

    env = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"}

    def test_every_parameter_is_listed_with_its_source(self):
        config = self.folder / "my.yaml"
        config.write_text("input: {sync_tolerance_s: 5e-2}\ntracker: {preset: khronos}\n")
        done = self.run_program("--effective", "--config", config)
        self.assertEqual(done.returncode, 0, done.stderr)
        settings = read_settings(done.stdout)
        origin = "file '%s'" % config
        self.assertEqual(settings["mesh_fusion/input/sync_tolerance_s"], (0.05, origin))
        self.assertEqual(settings["tracker/preset"], ("khronos", origin))
        self.assertEqual(settings["tracker/window_s"], (5, "default"))
        table = self.run_program().stdout
        for name in settings:
            self.assertIn("| `%s` |" % name.split("/", 1)[1], table)

    def test_packaged_defaults_are_the_built_in_ones(self):
        built_in = read_settings(self.run_program("--effective").stdout)
        packaged = read_settings(
            self.run_program("--effective", "--config", SOURCE / "config" / "default.yaml").stdout)
        for name, (value, _) in built_in.items():
            if not name.endswith("/output"):  # the launch file's: a folder in the home folder
                self.assertEqual(packaged[name][0], value, name)

    def effective(self, name, text):
        config = self.folder / "folder" / "my.yaml"
        config.parent.mkdir(exist_ok=True)
        config.write_text(text)
        done = self.run_program("--effective", "--config", config, "--value", name)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.rstrip("\n")

    def test_intrinsics_are_numbers_or_a_file_beside_the_configuration(self):
        for stage in ("segmenter", "tracker", "mesh_fusion"):
            name = stage + "/input/intrinsics"
            self.assertEqual(self.effective(name, "input: {intrinsics: K.yaml}\n"), str(self.folder / "folder/K.yaml"))
            self.assertEqual(self.effective(name, "input: {intrinsics: ../K.yaml}\n"), str(self.folder / "K.yaml"))
            self.assertEqual(self.effective(name, "input: {intrinsics: ~/K.yaml}\n"),
                             os.path.join(os.path.expanduser("~"), "K.yaml"))
            self.assertEqual(self.effective(name, "input: {intrinsics: '500, 500, 320.5, 2.4e2'}\n"),
                             "500, 500, 320.5, 2.4e2")

    def test_choices_have_one_name_and_go_by_others(self):
        for text, axes in (("optical", "optical"), ("opencv", "optical"), ("opengl", "opengl"), ("body", "body"),
                           ("flu", "body"), ("ros", "body")):
            self.assertEqual(self.effective("tracker/input/camera_axes", "input: {camera_axes: %s}\n" % text), axes)
        self.assertEqual(self.effective("tracker/input/pose_direction",
                                        "input: {pose_direction: world-to-camera}\n"), "world_to_camera")
        self.assertEqual(self.effective("tracker/input/match_size", "input: {match_size: color-to-depth}\n"),
                         "color_to_depth")

    def test_wrong_combinations_are_usage_errors(self):
        self.assertEqual(self.run_program("--node", "/x", "--config", "y").returncode, 2)
        self.assertEqual(self.run_program("--nonsense").returncode, 2)
        self.assertEqual(self.run_program("--value", "no/such").returncode, 1)
        self.assertIn("no ROS master", self.run_program("--node", "/x").stderr)


if __name__ == "__main__":
    unittest.main()
