# SPDX-License-Identifier: BSD-3-Clause
"""Whatever is used has a package in each list of scripts/packages-*.txt and a line in package.xml."""
import ast
import os
import pathlib
import re
import unittest
import xml.etree.ElementTree as ElementTree

import yaml

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
SHARED = pathlib.Path(os.environ.get("TSG_SHARED") or SOURCE.parent / "shared")
REFERENCE = SHARED / "reference" / "apt-ubuntu2004.txt"
NAMES = yaml.safe_load((SOURCE / "test/data/package_names.yaml").read_text())
OWN = "task_scene_graph"
# Of these CMake uses more than headers; roslib's own are in ros/.
GENERATORS = {"catkin", "message_generation", "roslib", "rostest"}


def read_list(path):
    """The names in a list of packages, in order."""
    lines = (line.split("#")[0].strip() for line in path.read_text().splitlines())
    return [line for line in lines if line]


LISTS = {path.stem[len("packages-"):]: read_list(path) for path in (SOURCE / "scripts").glob("packages-*.txt")}


def read_cmake():
    """The text of all CMake files without comments."""
    paths = [SOURCE / "CMakeLists.txt", *sorted((SOURCE / "cmake").glob("*.cmake"))]
    return re.sub(r"(?<!\S)#[^\n]*", "", "\n".join(path.read_text() for path in paths))


def components_of_cmake():
    """(ROS packages, other packages) that find_package asks for."""
    ros, others = {"catkin"}, set()
    for name, arguments in re.findall(r"find_package\(([\w-]+)([^)]*)\)", read_cmake()):
        if name == "catkin":
            ros.update(arguments.split("COMPONENTS")[1].split())
        elif name in NAMES["libraries"] or name in NAMES["cmake_modules"]:
            others.add(name)
        else:
            ros.add(name)
    return ros, others - set(NAMES["cmake_modules"])


def included_headers():
    """What stands in the #include <...> of all sources, standard C++ left out."""
    headers = set()
    for folder in ("include", "src", "test"):
        for path in (SOURCE / folder).rglob("*"):
            if path.suffix in (".h", ".cpp"):
                headers.update(re.findall(r"^\s*#\s*include <([^>]+)>", path.read_text(), re.MULTILINE))
    return {header for header in headers if re.search(r"[/.]|^Ogre|^Q", header)}


def components_of_headers():
    """(ROS packages, libraries) whose headers are included."""
    ros, libraries = set(), set()
    for header in included_headers():
        owner = next((name for name, entry in NAMES["libraries"].items()
                      if header.startswith(tuple(entry["headers"]))), None)
        if owner:
            libraries.add(owner)
        elif not header.startswith(tuple(NAMES["system_headers"])):
            folder = header.split("/")[0]
            ros.add("roscpp" if folder == "ros" else folder)
    return ros, libraries


def launched_packages():
    """Packages whose nodes the launch files and rostests start."""
    paths = [*(SOURCE / "launch").glob("*.launch"), *(SOURCE / "test/ros").glob("*.test")]
    nodes = [node for path in paths for node in ElementTree.parse(path).getroot().iter()
             if node.tag in ("node", "test")]
    return {node.get("pkg") for node in nodes} - {OWN}


def imports_of(text):
    """The first names of the modules that a Python program imports."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.split(".")[0]


def imported_modules():
    """Third-party modules that the system's Python must find for the scripts of this package."""
    texts = [path.read_text() for folder in ("cfg", "scripts/datasets") for path in (SOURCE / folder).glob("*")
             if path.suffix in (".py", ".cfg")]
    for path in (SOURCE / "scripts").glob("*"):
        text = path.read_text() if path.is_file() else ""
        texts += re.findall(r"<< ?'PYTHON'[^\n]*\n(.*?)\nPYTHON\n", text, re.DOTALL)
        if text.startswith("#!/usr/bin/python3"):
            texts.append(text)
    modules = {module for text in texts for module in imports_of(text)}
    # Python's own modules lie in no site folder; 3.8 has no list of them.
    return {module for module in modules if module in NAMES["python"] or module not in standard_modules()} - {
        OWN, OWN + "_client"}


def standard_modules():
    folder = pathlib.Path(os.__file__).parent
    return {path.stem for path in folder.glob("*") if not path.name.endswith("-packages")} | {
        path.name.split(".")[0] for path in folder.glob("lib-dynload/*")} | set(__import__("sys").builtin_module_names)


def called_programs(names):
    """Which of the programs the shell scripts call."""
    texts = [path.read_text() for path in (SOURCE / "scripts").glob("*") if path.is_file()]
    code = "\n".join(re.sub(r"(?<!\S)#[^\n]*", "", text) for text in texts if text.startswith("#!/usr/bin/env bash"))
    return {name for name in names if re.search(rf"(?<![\w./-]){name}(?![\w.=/-])", code)}


def packages_of_ros(name, system):
    if name in NAMES["ros"]:
        return NAMES["ros"][name][system]
    dashed = name.replace("_", "-")
    if system == "ubuntu":
        return [f"ros-noetic-{dashed}"]
    is_messages = name.endswith(("_msgs", "_srvs"))
    return [f"lib{dashed}-dev"] + ([f"ros-{dashed}", f"python3-{dashed}"] if is_messages else [])


def used_ros_packages():
    programs = called_programs(NAMES["ros_programs"])
    used = (components_of_cmake()[0] | components_of_headers()[0] | launched_packages() |
            {NAMES["ros_programs"][program] for program in programs} |
            (imported_modules() - set(NAMES["python"])))
    return used - set(NAMES["optional"])


def used_libraries():
    return components_of_cmake()[1] | components_of_headers()[1]


def needed_packages(system):
    """{package: what needs it} on "debian" or "ubuntu"."""
    needed = {}
    for name in used_ros_packages():
        needed.update((package, name) for package in packages_of_ros(name, system))
    for name in used_libraries():
        packages = NAMES["libraries"][name]["packages"]
        needed.update((package, name) for package in (packages[system] if isinstance(packages, dict) else packages))
    for name in imported_modules() & set(NAMES["python"]):
        needed.update((package, name) for package in NAMES["python"][name]["packages"])
    for name in called_programs(NAMES["programs"]):
        needed.update((package, name) for package in NAMES["programs"][name])
    return needed


class Lists(unittest.TestCase):
    def test_there_is_a_list_for_each_supported_system(self):
        self.assertEqual(set(LISTS), {"debian11", "debian12", "ubuntu2004"})
        for system in LISTS:
            self.assertIn(f"packages-{system}.txt", (SOURCE / "scripts/install").read_text())

    def test_no_list_names_a_package_twice(self):
        for system, names in LISTS.items():
            self.assertEqual(sorted(set(names)), sorted(names), system)

    def test_whatever_is_used_has_a_package_in_each_list(self):
        missing = [f"scripts/packages-{system}.txt lacks {package}, which {user} needs"
                   for system, names in LISTS.items()
                   for package, user in sorted(needed_packages(re.sub(r"\d", "", system)).items())
                   if package not in names]
        self.assertEqual(missing, [])

    def test_what_is_used_is_found_in_every_place_where_it_can_stand(self):
        self.assertLessEqual({"roscpp", "tf2_msgs", "cv_bridge", "rviz", "rostest", "rosbash", "nodelet", "rospy",
                              "xmlrpcpp", "genpy"}, used_ros_packages())
        self.assertEqual(used_libraries(), set(NAMES["libraries"]))
        self.assertEqual(imported_modules() & set(NAMES["python"]), {"PIL", "numpy", "yaml"})
        self.assertEqual(called_programs(NAMES["programs"]), set(NAMES["programs"]) - {"ccache"})

    @unittest.skipUnless(REFERENCE.is_file(), f"{REFERENCE} is not here (TSG_SHARED names its folder)")
    def test_names_for_ubuntu_are_spelled_as_in_the_reference_list(self):
        reference = set(read_list(REFERENCE))
        for name in LISTS["debian12"]:
            if name in reference:
                self.assertIn(name, LISTS["ubuntu2004"])
        unknown = {name for name in LISTS["ubuntu2004"] if name.startswith("ros-")} - reference
        by_rule = {f"ros-noetic-{name.replace('_', '-')}" for name in used_ros_packages()}
        self.assertEqual(unknown - by_rule, set())


class Cmake(unittest.TestCase):
    def test_it_asks_for_no_ros_package_of_which_nothing_is_included(self):
        self.assertEqual(components_of_cmake()[0] - components_of_headers()[0] - GENERATORS, set())

    def test_it_asks_for_no_library_of_which_nothing_is_included(self):
        self.assertEqual(components_of_cmake()[1] - components_of_headers()[1] - {"Qt5"}, set())


class PackageXml(unittest.TestCase):
    def setUp(self):
        root = ElementTree.parse(SOURCE / "package.xml").getroot()
        self.depends = {kind: {node.text for node in root.iter(kind)}
                        for kind in ("depend", "build_depend", "exec_depend", "test_depend", "buildtool_depend")}
        self.named = set().union(*self.depends.values())

    def test_it_names_every_ros_package_in_use(self):
        self.assertEqual(used_ros_packages() - self.named, set())

    def test_it_names_every_library_and_python_module_in_use(self):
        keys = {NAMES["libraries"][name]["key"] for name in used_libraries()}
        keys |= {NAMES["python"][name]["key"] for name in imported_modules() & set(NAMES["python"])}
        self.assertEqual(keys - self.named, set())

    def test_what_launch_files_and_scripts_start_is_there_when_the_package_runs(self):
        started = {node.get("pkg") for path in (SOURCE / "launch").glob("*.launch")
                   for node in ElementTree.parse(path).getroot().iter("node")} - {OWN}
        self.assertEqual(started - self.depends["depend"] - self.depends["exec_depend"], set())

    def test_it_names_nothing_twice(self):
        for kind in ("build_depend", "exec_depend", "test_depend"):
            self.assertEqual(self.depends[kind] & self.depends["depend"], set(), kind)


if __name__ == "__main__":
    unittest.main()
