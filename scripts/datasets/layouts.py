# SPDX-License-Identifier: BSD-3-Clause
"""Which known layout a folder has, and what to say where it has none."""
import collections
import os

from . import replica, scannet, three_d_match, tum
from .frames import DatasetError

LAYOUTS = {layout.NAME: layout for layout in (three_d_match, tum, replica, scannet)}
# What folders without a known layout turn out to be: file ending or name -> what to do.
KNOWN_OTHERS = (
    (".sens", "ScanNet's packed recording: export it first with ScanNet's SensReader (reader.py "
     "--export_depth_images --export_color_images --export_poses --export_intrinsics)"),
    (".bag", "a rosbag already: process_bag reads it"),
    (".db3", "a ROS 2 bag: convert it to a ROS 1 bag (rosbags-convert), process_bag reads that"),
    (".mcap", "a ROS 2 bag: convert it to a ROS 1 bag (rosbags-convert), process_bag reads that"),
    (".zip", "packed: unpack it first"), (".tar", "packed: unpack it first"),
    (".tgz", "packed: unpack it first"), (".gz", "packed: unpack it first"),
    (".7z", "packed: unpack it first"), (".klg", "a Kintinuous log: export its images first"),
    ("transforms.json", "NeRF's layout: not read here; write one of the layouts above"),
)


def find_layout(folder, name, has_trajectory):
    """The reader's module. Raises DatasetError where none or several fit, or the named does not."""
    require_folder(folder)
    if name != "auto":
        absent = LAYOUTS[name].find_absent(folder, has_trajectory)
        if absent:
            raise DatasetError(f"{folder}: --format {name}, but absent: {', '.join(absent)}; "
                               f"expected {LAYOUTS[name].LOOKS_FOR}. {describe_content(folder)}")
        return LAYOUTS[name]
    found = list_matches(folder, has_trajectory)
    if not found:
        raise DatasetError(describe_no_layout(folder, has_trajectory))
    if len(found) > 1:
        raise DatasetError(f"{folder}: {len(found)} layouts match, {' and '.join(found)}; --format "
                           "says which is meant")
    return LAYOUTS[found[0]]


def list_matches(folder, has_trajectory):
    return [name for name, layout in LAYOUTS.items()
            if not layout.find_absent(folder, has_trajectory)]


def require_folder(folder):
    if os.path.isdir(folder):
        return
    if not os.path.exists(folder):
        raise DatasetError(f"--input {folder}: absent (looked for it in {os.getcwd()}), expected a "
                           "folder" if not os.path.isabs(folder)
                           else f"--input {folder}: absent, expected a folder")
    hints = find_hints([os.path.basename(folder)])
    raise DatasetError(f"--input {folder}: a file, expected a folder of images{hints}")


def describe_no_layout(folder, has_trajectory):
    lines = [f"{folder}: 0 layouts match. Looked for, each in the folder itself:"]
    for name, layout in LAYOUTS.items():
        absent = layout.find_absent(folder, has_trajectory)
        lines.append(f"  {name}: {layout.LOOKS_FOR} (absent: {', '.join(absent)})")
    lines.append(describe_content(folder) + find_hints(os.listdir(folder)))
    below = [f"{name} ({' and '.join(found)})" for name, found in list_subfolders(folder)]
    if below:
        lines.append(f"Subfolders that fit: {', '.join(below[:5])}; give one of them as --input")
    lines.append("--format NAME takes one layout and says what it lacks")
    return "\n".join(lines)


def describe_content(folder):
    """What lies in a folder, in a line: folders by name, files by ending."""
    names = sorted(os.listdir(folder))
    folders = [name for name in names if os.path.isdir(os.path.join(folder, name))]
    inside = [f"{name}/ ({count_endings(os.listdir(os.path.join(folder, name)))})"
              for name in folders[:8]]
    files = count_endings(name for name in names if name not in folders)
    return "Found: " + (", ".join(inside + ([files] if files else [])) or "nothing at all")


def count_endings(names):
    """Of files and folders: '300 .jpg, 2 .txt'."""
    endings = collections.Counter(os.path.splitext(name)[1].lower() or "without ending"
                                  for name in names)
    return ", ".join(f"{count} {ending}" for ending, count in endings.most_common(6))


def find_hints(names):
    hints = []
    for name in sorted(names):
        hint = next((text for ending, text in KNOWN_OTHERS if name.lower().endswith(ending)), None)
        if hint and not any(hint in known for known in hints):
            hints.append(f"; {name} is {hint}")
    return "".join(hints[:3])


def list_subfolders(folder):
    """[(name, matching layouts)] one level below."""
    found = ((name, list_matches(os.path.join(folder, name), False))
             for name in sorted(os.listdir(folder))[:200]
             if os.path.isdir(os.path.join(folder, name)))
    return [(name, layouts) for name, layouts in found if layouts]
