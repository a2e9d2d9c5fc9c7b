#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Integration of depth and colour beside Open3D's two CPU volumes, milliseconds of CPU time per frame.

Needs `pip install 'open3d==0.19.*'` in any virtual environment and the program mapping_benchmark
(scripts/build mapping_benchmark). One thread each; engines take turns within a round; the median of
the rounds is printed as a Markdown table. Frames are decoded, and converted to what each engine
takes, before its clock starts. All get the same frames, depth range and truncation.

usage: compare_open3d.py --benchmark build/devel/lib/task_scene_graph/mapping_benchmark \
           --data ../shared/data [--sequences kitchen house_a] [--rounds 5]
"""
import argparse
import json
import os
import statistics
import subprocess
import time
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402  (the number of threads is read on import)
import open3d as o3d  # noqa: E402

FRAMES = range(0, 300, 5)  # as test/benchmark/mapping_benchmark.cpp
MIN_RANGE_M = 0.3
MAX_RANGE_M = 5.0
TRUNCATION_VOXELS = 4.0
VOXEL_SIZES_CM = (5, 2)


class Sequence:
    def __init__(self, folder):
        self.intrinsics = np.loadtxt(folder / "camera-intrinsics.txt").reshape(3, 3)
        self.frames = [self._load(folder, index) for index in FRAMES]

    @staticmethod
    def _load(folder, index):
        stem = folder / f"frame-{index:06d}"
        color = np.asarray(o3d.io.read_image(f"{stem}.color.jpg"))
        depth = np.asarray(o3d.io.read_image(f"{stem}.depth.png")).copy()
        depth[(depth < 1000 * MIN_RANGE_M) | (depth > 1000 * MAX_RANGE_M)] = 0
        return color, depth, np.linalg.inv(np.loadtxt(f"{stem}.pose.txt"))


def time_legacy(sequence, voxel_size_m):
    """ScalableTSDFVolume; conversion of the images to floats is not counted."""
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=voxel_size_m, sdf_trunc=TRUNCATION_VOXELS * voxel_size_m,
        color_type=o3d.pipelines.integration.TSDFVolumeColorType.RGB8)
    k = sequence.intrinsics
    camera = o3d.camera.PinholeCameraIntrinsic(640, 480, k[0, 0], k[1, 1], k[0, 2], k[1, 2])
    seconds = 0.0
    for color, depth, T_camera_world in sequence.frames:
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(color), o3d.geometry.Image(depth), depth_scale=1000.0,
            depth_trunc=MAX_RANGE_M, convert_rgb_to_intensity=False)
        begin = time.process_time()
        volume.integrate(image, camera, T_camera_world)
        seconds += time.process_time() - begin
    return 1e3 * seconds / len(sequence.frames)


def time_tensor(sequence, voxel_size_m):
    """VoxelBlockGrid: choice of blocks and integration."""
    core = o3d.core
    grid = o3d.t.geometry.VoxelBlockGrid(
        attr_names=("tsdf", "weight", "color"),
        attr_dtypes=(core.float32, core.float32, core.float32),
        attr_channels=((1), (1), (3)), voxel_size=voxel_size_m, block_resolution=16,
        block_count=20000, device=core.Device("CPU:0"))
    intrinsics = core.Tensor(sequence.intrinsics)
    seconds = 0.0
    for color, depth, T_camera_world in sequence.frames:
        color_image = o3d.t.geometry.Image(core.Tensor(color))
        depth_image = o3d.t.geometry.Image(core.Tensor(depth))
        extrinsics = core.Tensor(T_camera_world)
        begin = time.process_time()
        blocks = grid.compute_unique_block_coordinates(
            depth_image, intrinsics, extrinsics, 1000.0, MAX_RANGE_M, TRUNCATION_VOXELS)
        grid.integrate(blocks, depth_image, color_image, intrinsics, extrinsics, 1000.0,
                       MAX_RANGE_M, TRUNCATION_VOXELS)
        seconds += time.process_time() - begin
    return 1e3 * seconds / len(sequence.frames)


def time_ours(program, data, case):
    """`case`: name of a benchmark without its prefix, e.g. kitchen/5/1."""
    output = subprocess.run(
        [program, f"--benchmark_filter=integrateSequence/{case}$", "--benchmark_format=json",
         "--benchmark_min_time=0.2"],
        env={**os.environ, "TSG_SHARED": str(data.parent)}, check=True, capture_output=True)
    result = json.loads(output.stdout)["benchmarks"][0]
    if result.get("error_occurred"):
        raise RuntimeError(f"{case}: {result['error_message']}")
    return 1e3 * result["s/frame"]


def measure(arguments):
    times = {}
    for name in arguments.sequences:
        sequence = Sequence(arguments.data / name)
        for _ in range(arguments.rounds):
            for cm in VOXEL_SIZES_CM:
                row = times.setdefault((name, cm), {"legacy": [], "tensor": [], "ours": []})
                row["legacy"].append(time_legacy(sequence, 0.01 * cm))
                row["tensor"].append(time_tensor(sequence, 0.01 * cm))
                row["ours"].append(time_ours(arguments.benchmark, arguments.data, f"{name}/{cm}/1"))
            carving = times.setdefault((name + ", carving", 10), {"ours": []})
            carving["ours"].append(
                time_ours(arguments.benchmark, arguments.data, f"{name}_carving/10/1"))
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--benchmark", required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--sequences", nargs="+", default=["kitchen", "house_a"])
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    arguments.data = arguments.data.resolve()
    print(f"Open3D {o3d.__version__}, {len(FRAMES)} frames, one thread, {arguments.rounds} rounds")
    print("| images | voxel | ScalableTSDFVolume | VoxelBlockGrid | ours | better of the two / ours |")
    print("|---|---|---|---|---|---|")
    for (name, cm), row in measure(arguments).items():
        median = {engine: statistics.median(values) for engine, values in row.items()}
        cells = [f"{median[e]:.2f} ms" if e in median else "" for e in ("legacy", "tensor", "ours")]
        peers = [median[e] for e in ("legacy", "tensor") if e in median]
        ratio = f"{min(peers) / median['ours']:.2f}" if peers else ""
        print(f"| {name} | {cm} cm | " + " | ".join(cells) + f" | {ratio} |")


if __name__ == "__main__":
    main()
