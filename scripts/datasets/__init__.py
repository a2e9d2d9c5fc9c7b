# SPDX-License-Identifier: BSD-3-Clause
"""Folders of RGB-D images -> rosbags (`scripts/dataset_to_bag`).

A reader (one module per layout) lists the frames of a folder; `bag` writes them. Poses are
T_world_camera: camera optical frame (x right, y down, z forward) to world, metres.
"""
