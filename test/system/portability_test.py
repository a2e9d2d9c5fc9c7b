# SPDX-License-Identifier: BSD-3-Clause
"""Nothing is used that the oldest supported system, Ubuntu 20.04, lacks: Python 3.8, CMake 3.16 and the
libraries of its time. What a compiler of that time tells is scripts/check_older_system's part."""
import ast
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import yaml

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
CACHE = os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "task_scene_graph")
VERMIN = os.environ.get("TSG_VERMIN_PATH") or os.path.join(CACHE, "vermin")
NEWER_NAMES = yaml.safe_load((SOURCE / "test/data/newer_names.yaml").read_text())
FOLDERS = ("cfg", "cmake", "include", "scripts", "src", "test", "training")


def find_files(*suffixes):
    """All files of this repository with one of these suffixes ("" : none)."""
    files = itertools.chain(SOURCE.glob("*"), *((SOURCE / folder).rglob("*") for folder in FOLDERS))
    return sorted(path for path in files if path.is_file() and path.suffix in suffixes)


def find_scripts(interpreter):
    """Files without a suffix whose first line names the interpreter."""
    for path in find_files(""):
        with open(path, "rb") as file:
            if re.match(rb"#!.*\b" + interpreter + rb"\d?\s*$", file.readline()):
                yield path


def find_inline_python():
    """(name, text) of each Python program between <<'PYTHON' and PYTHON in a shell script."""
    for path in find_scripts(b"bash"):
        programs = re.findall(r"<< ?'PYTHON'[^\n]*\n(.*?)\nPYTHON\n", path.read_text(), re.DOTALL)
        for number, program in enumerate(programs):
            yield f"{path.name}_{number}.py", program


def strip_comments(text, pattern):
    """The text without what the pattern finds, with the same lines."""
    return re.sub(pattern, lambda match: "\n" * match.group().count("\n"), text, flags=re.DOTALL)


def find_newer(kind, text):
    """(line, entry) of each name of that kind in newer_names.yaml that the text uses."""
    return [(text.count("\n", 0, match.start()) + 1, entry)
            for entry in NEWER_NAMES[kind] for match in re.finditer(entry["pattern"], text)]


def find_joined_types(text):
    """Lines of a Python program whose annotations join types with |, as only 3.10 and later do. (vermin takes
    other uses of | for these.)"""
    for node in ast.walk(ast.parse(text)):
        for annotation in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            parts = ast.walk(annotation) if annotation is not None else ()
            yield from (part.lineno for part in parts
                        if isinstance(part, ast.BinOp) and isinstance(part.op, ast.BitOr))


def run_vermin(paths):
    """(whether no file needs a Python newer than 3.8, output) of vermin."""
    command = [sys.executable, "-c", "from vermin import main; main()", "--target=3.8-", "--violations",
               "--eval-annotations", "--no-tips", *map(str, paths)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300,
                          universal_newlines=True, env={**os.environ, "PYTHONPATH": VERMIN})
    # What this Python itself cannot parse is told, but not by the exit status.
    is_old = done.returncode == 0 and not re.search(r"^\s+error: ", done.stdout, re.MULTILINE)
    return is_old, done.stdout


@unittest.skipUnless(os.path.isdir(os.path.join(VERMIN, "vermin")),
                     "vermin is not here (scripts/install_test_tools gets it)")
class PythonLevel(unittest.TestCase):
    def setUp(self):
        self.programs = {str(path.relative_to(SOURCE)): path.read_text()
                         for path in [*find_files(".py", ".cfg"), *find_scripts(b"python")]}
        self.programs.update(find_inline_python())
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_every_kind_of_script_is_looked_at(self):
        self.assertLessEqual({"scripts/count_tests", "cfg/SceneGraphTuning.cfg", "install_engine_0.py",
                              "test/support/run_unittest", "scripts/datasets/bag.py"}, set(self.programs))

    def test_scripts_need_no_python_newer_than_3_8(self):
        for name, text in self.programs.items():
            (self.folder / name.replace("/", "_")).write_text(text)
        is_old, output = run_vermin(sorted(self.folder.iterdir()))
        self.assertTrue(is_old, output)

    def test_annotations_join_no_types_with_a_bar(self):
        found = {name: lines for name, lines in
                 ((name, list(find_joined_types(text))) for name, text in self.programs.items()) if lines}
        self.assertEqual(found, {})
        self.assertEqual(list(find_joined_types("x: int | None = a | b\ndef f(c: str | int) -> d: pass\n")), [1, 2])

    def test_newer_syntax_types_and_methods_are_found(self):
        for program in ("match x:\n  case 1: pass\n", "def f(a: list[int]): pass\n", "a = b'x'.removeprefix(b'y')\n",
                        "import tomllib\n", "from functools import cache\n",
                        "with (open(a) as b, open(c) as d): pass\n"):
            path = self.folder / "program.py"
            path.write_text(program)
            self.assertFalse(run_vermin([path])[0], program)


class NewerNames(unittest.TestCase):
    def check(self, kind, paths, comment):
        """No file uses a name of the kind."""
        self.assertGreater(len(paths), 5)
        found = [f"{path.relative_to(SOURCE)}:{line}: {entry['since']}; instead: {entry['instead']}"
                 for path in paths
                 for line, entry in find_newer(kind, strip_comments(path.read_text(), comment))]
        self.assertEqual(found, [])

    def test_sources_use_no_name_that_the_oldest_libraries_lack(self):
        self.check("cpp", find_files(".h", ".cpp"), r"//[^\n]*|/\*.*?\*/")

    def test_cmake_files_use_no_name_that_3_16_lacks(self):
        self.check("cmake", find_files(".cmake") + [SOURCE / "CMakeLists.txt"], r"(?<!\S)#[^\n]*")

    def test_scripts_use_no_option_that_cmake_3_16_lacks(self):
        self.check("scripts", list(find_scripts(b"bash")), r"(?<!\S)#[^\n]*")

    def test_each_entry_finds_its_example_and_says_what_to_do(self):
        for kind, entries in NEWER_NAMES.items():
            for entry in entries:
                self.assertIn(entry, [found for _, found in find_newer(kind, entry["example"])])
                self.assertTrue(entry["since"] and entry["instead"])

    def test_line_of_a_newer_name_is_told_after_a_comment_of_several_lines(self):
        text = strip_comments("/* two\nlines of Eigen::all */\nm(Eigen::all, 0);\n", r"/\*.*?\*/")
        self.assertEqual([line for line, _ in find_newer("cpp", text)], [3])


class LanguageLevel(unittest.TestCase):
    def test_cmake_asks_for_3_16_and_for_cpp_17_without_extensions(self):
        text = strip_comments((SOURCE / "CMakeLists.txt").read_text(), r"#[^\n]*")
        self.assertEqual(re.findall(r"cmake_minimum_required\((.*?)\)", text), ["VERSION 3.16"])
        self.assertEqual(re.findall(r"set\((CMAKE_CXX_STANDARD\w*|CMAKE_CXX_EXTENSIONS) (\w+)\)", text),
                         [("CMAKE_CXX_STANDARD", "17"), ("CMAKE_CXX_STANDARD_REQUIRED", "ON"),
                          ("CMAKE_CXX_EXTENSIONS", "OFF")])

    def test_no_cmake_file_raises_the_policies_or_the_standard(self):
        for path in find_files(".cmake"):
            text = strip_comments(path.read_text(), r"#[^\n]*")
            self.assertNotRegex(text, r"cmake_minimum_required|cmake_policy\(VERSION|CXX_STANDARD|cxx_std_|-std=",
                                path.name)


if __name__ == "__main__":
    unittest.main()
