# SPDX-License-Identifier: BSD-3-Clause
"""A map by the live chain, under a ROS master of its own, with the recording played at its own pace: what
the machine cannot follow is dropped, as on a robot."""
import json
import os
import re
import signal
import socket
import subprocess
import time

from . import results

SAVE_MAP = "/task_scene_graph/scene_graph/save_map"
START_S = 60.0
END_S = 120.0
SAVE_S = 600.0


def find_free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Session:
    """roslaunch in the background; a with block ends it."""

    def __init__(self, arguments, log, node_logs):
        """node_logs: folder for the nodes' own; their command lines name it."""
        port = find_free_port()
        self.env = dict(os.environ, ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1")
        self.env["ROS_LOG_DIR"] = self.node_logs = os.path.abspath(node_logs)
        self.log = log
        self.launch = subprocess.Popen(["roslaunch", "-p", str(port), f"--sigint-timeout={END_S / 2.0:g}"] + arguments, env=self.env, stdout=log,
                                       stderr=log, start_new_session=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.launch.send_signal(signal.SIGINT)
        try:
            self.launch.wait(END_S)
        except subprocess.TimeoutExpired:  # its nodes are in sessions of their own
            subprocess.run(["pkill", "-KILL", "-f", f"__log:={re.escape(self.node_logs)}/"], check=False)
            self.launch.kill()
            self.launch.wait()

    def call(self, *command, timeout_s=START_S):
        """What it prints. Raises RuntimeError if it fails or takes longer."""
        try:
            done = subprocess.run(command, env=self.env, stdout=subprocess.PIPE, stderr=self.log,
                                  universal_newlines=True, check=False, timeout=timeout_s)
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"{' '.join(command[:3])} took more than {timeout_s:g} s; see {self.log.name}")
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command[:3])} ended with status {done.returncode}; see {self.log.name}")
        return done.stdout

    def has(self, service):
        try:
            return service in self.call("rosservice", "list").split()
        except RuntimeError:  # no master yet
            return False

    def wait_for(self, service):
        deadline = time.monotonic() + START_S
        while not self.has(service):
            if self.launch.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError(f"the chain did not come up: no service {service} after {START_S:g} s; "
                                   f"see {self.log.name}")
            time.sleep(0.5)


def read_bag(bag):
    """(Number of images, seconds). Raises RuntimeError."""
    try:
        import rosbag  # of ROS's Python, which a driver without this method need not have
        with rosbag.Bag(bag) as file:
            return (file.get_message_count(topic_filters=["/camera/color/image_raw"]),
                    file.get_end_time() - file.get_start_time())
    except Exception as error:  # rosbag's own are no RuntimeError
        raise RuntimeError(f"bag '{bag}' cannot be read: {error}")


def count_untracked(answer):
    """Segmented frames that the tracker dropped, from what save_map says of its stages."""
    found = re.search(r"([0-9]+) segmented frames were dropped", answer)
    return int(found.group(1)) if found else 0


def count_poses(folder):
    with open(os.path.join(folder, "trajectory.txt"), encoding="utf-8") as file:
        return sum(1 for line in file if line.strip() and not line.startswith("#"))


def make_map(root, log_path, recording, tasks, config, target):
    """In `target`, unless it is there. Raises RuntimeError where the map is not whole."""
    if os.path.exists(os.path.join(target, "done.json")):
        return target
    os.makedirs(target, exist_ok=True)
    path = os.path.abspath(os.path.join(target, "config.yaml"))
    with open(path, "w", encoding="utf-8") as file:
        json.dump(config, file)  # JSON is YAML
    arguments = [os.path.join(root, "launch", "task_scene_graph.launch"), "use_sim_time:=true", "rviz:=false",
                 "recorded_segmentation:=true", f"config:={path}",
                 f"object_tasks:={os.path.abspath(tasks)}",
                 f"place_tasks:={os.path.abspath(recording.place_tasks)}", f"output:={os.path.abspath(target)}"]
    num_frames, duration_s = read_bag(recording.bag)
    started = time.monotonic()
    with open(log_path, "a", encoding="utf-8") as log:
        log.write("$ roslaunch " + " ".join(arguments) + "\n")
        log.flush()
        with Session(arguments, log, os.path.join(target, "ros_logs")) as session:
            session.wait_for(SAVE_MAP)
            session.call("rosbag", "play", "--clock", "--quiet", os.path.abspath(recording.bag),
                         timeout_s=2.0 * duration_s + SAVE_S)
            answer = session.call("rosservice", "call", SAVE_MAP, timeout_s=SAVE_S)
        if "success: True" not in answer:
            raise RuntimeError(f"save_map of {target}: {answer.strip() or 'no answer'}")
    results.write(os.path.join(target, "done.json"),
                  {"wall_s": time.monotonic() - started, "frames": num_frames,
                   "frames_in_map": count_poses(target), "frames_not_tracked": count_untracked(answer)})
    return target
