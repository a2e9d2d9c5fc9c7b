# SPDX-License-Identifier: BSD-3-Clause
"""scripts/check_older_system says what it wants before it does anything."""
import os
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(os.environ["TSG_SOURCE_DIR"], "scripts", "check_older_system")


def run(*arguments):
    return subprocess.run([str(SCRIPT), *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          universal_newlines=True, timeout=60)


class CheckOlderSystem(unittest.TestCase):
    def test_help_names_every_option(self):
        done = run("--help")
        self.assertEqual(done.returncode, 0)
        for option in ("--root DIR", "--quick"):
            self.assertIn(option, done.stdout)

    def test_unknown_option_is_named(self):
        done = run("--rot", "/tmp/x")
        self.assertEqual(done.returncode, 2)
        self.assertIn("unknown option '--rot'", done.stdout)

    def test_folder_with_other_files_is_refused_and_left_as_it_is(self):
        with tempfile.TemporaryDirectory() as folder:
            other = pathlib.Path(folder, "root", "thesis.txt")
            other.parent.mkdir()
            other.write_text("years of work")
            done = run("--root", str(other.parent))
            self.assertEqual(done.returncode, 2)
            self.assertIn("holds files, but no Debian 11 root made by this script" if os.getuid() == 0
                          else "needs root: sudo scripts/check_older_system", done.stdout)
            self.assertEqual([path.name for path in other.parent.iterdir()], [other.name])

    def test_the_machines_own_root_is_refused(self):
        done = run("--root", "/usr/..")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--root is '/'", done.stdout)


if __name__ == "__main__":
    unittest.main()
