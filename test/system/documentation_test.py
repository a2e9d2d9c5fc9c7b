# SPDX-License-Identifier: BSD-3-Clause
"""The documents say what is: generated tables are current, examples run, links lead somewhere."""
import os
import pathlib
import re
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

SOURCE = pathlib.Path(os.environ["TSG_SOURCE_DIR"])
PROGRAMS = pathlib.Path(os.environ["TSG_BUILD_DIR"]) / "devel" / "lib" / "task_scene_graph"
DOCUMENTS = [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("*.md"))]


def run(program, *arguments):
    return subprocess.run([str(PROGRAMS / program), *arguments], check=True, stdout=subprocess.PIPE,
                          universal_newlines=True, timeout=60).stdout


class Documentation(unittest.TestCase):
    def test_parameter_table_is_current(self):
        self.assertTrue((SOURCE / "docs/parameters.md").read_text() == run("list_parameters"),
                        "run: rosrun task_scene_graph list_parameters > docs/parameters.md")

    def test_example_of_the_readme_is_the_one_that_is_compiled(self):
        code = (SOURCE / "test/examples/library_example.cpp").read_text()
        self.assertIn(code.split("\n", 1)[1].strip(), (SOURCE / "README.md").read_text())

    def test_robot_programs_shown_are_the_ones_that_the_tests_run(self):
        text = (SOURCE / "docs/robot_interface.md").read_text()
        for name in ("fetch_example.py", "ros_fetch_example.cpp"):
            self.assertIn((SOURCE / "test/examples" / name).read_text().split("\n", 1)[1].strip(), text, name)

    def test_example_finds_two_objects_and_says_why(self):
        lines = run("library_example").splitlines()
        self.assertEqual(lines[:2], ["2 primitives serve task 1", "1 primitives serve task 2"])
        self.assertRegex(lines[2], r"^joining 2 and 3 would lose 0\.[3-9]\d* of the information$")

    def test_links_to_files_lead_somewhere(self):
        for document in DOCUMENTS:
            prose = re.sub(r"```.*?```", "", document.read_text(), flags=re.DOTALL)
            for target in re.findall(r"\]\(([^)#]+)[^)]*\)", prose):
                if not target.startswith("http"):
                    self.assertTrue((document.parent / target).exists(), f"{document.name}: {target}")

    def test_every_launch_argument_is_documented_and_says_whether_it_is_optional(self):
        for launch in sorted((SOURCE / "launch").glob("*.launch")):
            for arg in ElementTree.parse(str(launch)).getroot().findall("arg"):
                doc, where = arg.get("doc", ""), f"{launch.name}: {arg.get('name')}"
                self.assertTrue(doc, where)
                is_needed = arg.get("default") is None or "needed here or" in doc
                self.assertEqual(doc.startswith("optional: "), not is_needed, where)

    def test_programs_and_scripts_named_in_the_documents_exist(self):
        for document in DOCUMENTS:
            text = document.read_text()
            for name in re.findall(r"rosrun task_scene_graph (\w+)", text):
                self.assertTrue(any((folder / name).exists() for folder in (PROGRAMS, SOURCE / "scripts")),
                                f"{document.name}: rosrun {name}")
            for name in re.findall(r"\bscripts/(\w+)", text):
                self.assertTrue(list((SOURCE / "scripts").glob(f"{name}*")),
                                f"{document.name}: scripts/{name}")


if __name__ == "__main__":
    unittest.main()
