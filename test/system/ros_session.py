# SPDX-License-Identifier: BSD-3-Clause
"""A ROS master of its own, and programs under it, for the tests of what runs live."""
import os
import pathlib
import signal
import socket
import subprocess
import time

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph"
DEADLINE_S = 120.0


def find_free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(predicate, what, timeout_s=DEADLINE_S):
    deadline = time.monotonic() + timeout_s
    while True:
        result = predicate()
        if result:
            return result
        if time.monotonic() > deadline:
            raise AssertionError("waited %g s in vain for %s" % (timeout_s, what))
        time.sleep(0.1)


class Program:
    """A program with its output in a file; ended with all its children at the latest by kill()."""

    def __init__(self, command, log, env, cwd=None):
        self.log = pathlib.Path(log)
        with open(str(log), "w") as stream:
            self.process = subprocess.Popen([str(word) for word in command], stdout=stream,
                                            stderr=subprocess.STDOUT, env=env, cwd=cwd and str(cwd),
                                            start_new_session=True)

    def output(self):
        return self.log.read_text()

    def is_running(self):
        return self.process.poll() is None

    def interrupt(self, number=signal.SIGINT):
        """Sends a signal to the program alone, as Ctrl-C in roslaunch; returns its exit status."""
        self.process.send_signal(number)
        try:
            return self.process.wait(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError("does not end by signal %d:\n%s" % (number, self.output()))

    def kill(self):
        """kill -9 for the program and everything that it started."""
        children = list_descendants(self.process.pid)
        for pid in [self.process.pid] + children:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.process.wait()


def list_descendants(pid):
    """Ids of all processes below one; roslaunch puts each of its own into a session of its own."""
    done = subprocess.run(["ps", "-eo", "pid=,ppid="], stdout=subprocess.PIPE, universal_newlines=True)
    pairs = [tuple(map(int, line.split())) for line in done.stdout.splitlines()]
    found, open_ids = [], [pid]
    while open_ids:
        parent = open_ids.pop()
        below = [child for child, its_parent in pairs if its_parent == parent]
        found += below
        open_ids += below
    return found


class Session:
    """A master, and the environment in which programs find it."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        port = find_free_port()
        self.env = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:%d" % port,
                    "ROS_HOSTNAME": "127.0.0.1", "HOME": str(self.folder),
                    "ROS_HOME": str(self.folder / ".ros"), "ROSCONSOLE_STDOUT_LINE_BUFFERED": "1",
                    "PYTHONUNBUFFERED": "1"}  # roslaunch: what it says is waited for
        self.env.pop("ROS_NAMESPACE", None)
        self.programs = []
        self.start(["rosmaster", "--core", "-p", str(port)], "master")
        wait_until(lambda: self.run("rosparam", "list").returncode == 0, "the master")

    def start(self, command, name, cwd=None):
        program = Program(command, self.folder / (name + ".log"), self.env, cwd)
        self.programs.append(program)
        return program

    def run(self, *command, cwd=None):
        return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, env=self.env,
                              cwd=cwd and str(cwd), timeout=DEADLINE_S)

    def close(self):
        for program in reversed(self.programs):
            if program.is_running():
                program.kill()

    def list_parameters(self, *options):
        return self.run(PROGRAMS / "list_parameters", *options)
