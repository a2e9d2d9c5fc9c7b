# SPDX-License-Identifier: BSD-3-Clause
"""Files that appear together when all are written, or not at all."""
import os

from .frames import DatasetError


class OutputFiles:
    """Context: hands out temporary names; what was not committed is removed at its end."""

    def __init__(self):
        self.pending = []

    def add(self, path):
        """A temporary name beside `path`."""
        self.pending.append((path + ".part", path))
        return path + ".part"

    def commit(self):
        """Gives every file its name; returns the names."""
        for temporary, path in self.pending:
            os.replace(temporary, path)
        paths = [path for _, path in self.pending]
        self.pending = []
        return paths

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for temporary, _ in self.pending:
            if os.path.exists(temporary):
                os.remove(temporary)


def prepare(path):
    """Makes an output file's folder. Raises DatasetError where no file can be written there."""
    if os.path.isdir(path) or path.endswith(os.sep):
        raise DatasetError(f"--output {path}: a folder, expected a file name such as "
                           f"{os.path.join(path, 'walk.bag')}")
    folder = os.path.dirname(os.path.abspath(path))
    try:
        os.makedirs(folder, exist_ok=True)
    except FileExistsError:
        raise DatasetError(f"--output {path}: {folder} is a file, expected a folder")
    except OSError as error:
        raise DatasetError(f"--output {path}: {folder} cannot be made ({error.strerror}: "
                           f"{error.filename})")
    if not (os.access(folder, os.W_OK) and os.access(folder, os.X_OK)):
        raise DatasetError(f"--output {path}: no permission to write into {folder}")
