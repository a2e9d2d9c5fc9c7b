# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dataset_to_bag: intrinsics and the unit of depth."""
import argparse
import os
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from dataset_folder import (DEPTH, INFO, ReplicaFolder, ScanNetFolder, ThreeDMatchFolder,  # noqa: E402
                            TumFolder, color, depth, depth_pixels)
from datasets import depth_scale, intrinsics  # noqa: E402
from datasets.frames import Camera, DatasetError  # noqa: E402

MATRIX_3X3 = "10 0 4\n0 11 3\n0 0 1\n"
MATRIX_4X4 = "10 0 4 0\n0 11 3 0\n0 0 1 0\n0 0 0 1\n"


class IntrinsicsFiles(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "k.txt")
            with open(path, "w") as file:
                file.write(text)
            return intrinsics.read_camera(path)

    def expect(self, text, *numbers):
        np.testing.assert_allclose(self.read(text)[:4], numbers or (10, 11, 4, 3))

    def expect_refused(self, text, *parts):
        with self.assertRaises(DatasetError) as caught:
            self.read(text)
        for part in ("k.txt", *parts):
            self.assertIn(part, str(caught.exception))

    def test_matrices_and_lines_are_read(self):
        for text in (MATRIX_3X3, MATRIX_4X4, "10 0 4 0\n0 11 3 0\n0 0 1 0\n", "10 11 4 3", "10,11,4,3\n",
                     "# fx fy cx cy\n10 11 4 3\n", "[[10, 0, 4], [0, 11, 3], [0, 0, 1]]",
                     MATRIX_3X3.replace(" ", ",  "), "\ufeff" + MATRIX_3X3,
                     MATRIX_3X3.replace("\n", "\r\n"), "1e1 0 4e0; 0 11 3; 0 0 1"):
            self.expect(text)

    def test_distortion_after_the_four_numbers_is_kept(self):
        self.assertEqual(self.read("10 11 4 3 0.1 -0.2 0.01 0.02").distortion, (0.1, -0.2, 0.01, 0.02))
        self.assertEqual(self.read("10 11 4 3 0.1 0 0 0 0.3").distortion, (0.1, 0, 0, 0, 0.3))
        self.assertEqual(self.read(MATRIX_3X3).distortion, ())

    def test_calibrations_in_yaml_and_json_are_read(self):
        ros = ("image_width: 8\nimage_height: 6\ncamera_name: c\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
               "  data: [10, 0, 4, 0, 11, 3, 0, 0, 1]\ndistortion_model: plumb_bob\n"
               "distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}\n")
        self.expect(ros)
        self.assertEqual(self.read(ros).size, (8, 6))
        self.assertEqual(self.read(ros).distortion, (0.1, 0, 0, 0, 0))
        self.expect("%YAML:1.0\n---\ncamera_matrix: !!opencv-matrix\n  rows: 3\n  cols: 3\n  dt: d\n"
                    "  data: [10, 0, 4, 0, 11, 3, 0, 0, 1]\n")
        self.expect("%YAML:1.0\nCamera.fx: 10\nCamera.fy: 11\nCamera.cx: 4.0\nCamera.cy: 3.0\n")
        self.expect('{"width": 8, "height": 6, "intrinsic_matrix": [10, 0, 0, 0, 11, 0, 4, 3, 1]}')
        self.expect('{"camera": {"fx": 10, "fy": 11, "cx": 4, "cy": 3, "scale": 1000}}')
        self.expect("K: [10, 0, 4, 0, 11, 3, 0, 0, 1]\nD: [0, 0, 0, 0, 0]\n")
        self.expect("K: [[10, 0, 4], [0, 11, 3], [0, 0, 1]]\n")

    def test_a_distortion_that_camera_info_cannot_hold_is_refused(self):
        text = "K: [10, 0, 4, 0, 11, 3, 0, 0, 1]\nD: [0.1, 0.2, 0, 0]\ndistortion_model: equidistant\n"
        self.expect_refused(text, "equidistant", "plumb_bob")
        self.expect(text.replace("0.1, 0.2", "0, 0"))

    def test_what_is_no_camera_is_refused(self):
        for text, part in (("10 0 0\n0 11 0\n4 3 1\n", "transposed"), ("1 2 3", "3 numbers"),
                           ("10 2 4\n0 11 3\n0 0 1", "expected fx 0 cx"), ("hello", "expected fx fy"),
                           ("", "0 numbers"), ("10 0 4\n0 -11 3\n0 0 1", "positive"),
                           ("10 nan 4 3", "expected numbers"), ("fx: 10\nfy: 11\n", "expected fx fy"),
                           ("fx: ten\nfy: 11\ncx: 4\ncy: 3\n", "expected numbers"),
                           ("inf 11 4 3", "expected numbers")):
            self.expect_refused(text, part)

    def test_plausibility_is_judged_by_the_field_of_view_and_the_centre(self):
        def misfit(fx, fy, cx, cy):
            return intrinsics.find_misfit(Camera(fx, fy, cx, cy, ""), (640, 480))
        self.assertIsNone(misfit(525, 525, 319.5, 239.5))
        self.assertIsNone(misfit(320 / np.tan(np.radians(79)), 240 / np.tan(np.radians(79)), 320, 240))
        self.assertIsNone(misfit(320 / np.tan(np.radians(6)), 240 / np.tan(np.radians(6)), 320, 240))
        self.assertIn("degrees", misfit(320 / np.tan(np.radians(81)), 525, 320, 240))
        self.assertIn("degrees", misfit(525, 240 / np.tan(np.radians(4)), 320, 240))
        self.assertIn("cx 640", misfit(525, 525, 640, 240))
        self.assertIn("cy -3", misfit(525, 525, 320, -3))
        self.assertIn("hold for 320x240", intrinsics.find_misfit(
            Camera(262, 262, 160, 120, "", (320, 240)), (640, 480)))


class IntrinsicsOfFolders(ThreeDMatchFolder):
    def test_defaults_hold_for_their_own_size_only(self):
        for layout, size, fx in ((ThreeDMatchFolder, (640, 480), 585.0), (TumFolder, (640, 480), 525.0),
                                 (ReplicaFolder, (1200, 680), 600.0)):
            folder = layout()
            folder.setUp()
            names = {ThreeDMatchFolder: ("frame-000000.color.png", "frame-000000.depth.png"),
                     TumFolder: ("rgb/2.png", "depth/2.png"),
                     ReplicaFolder: ("results/frame000000.jpg", "results/depth000000.png")}[layout]
            if layout is ThreeDMatchFolder:
                folder.write_frames(1)
            elif layout is ReplicaFolder:
                folder.write_frames((0,))
            else:
                folder.write_frames()
                folder.write("rgb.txt", "10.2 rgb/2.png\n")
            os.remove(folder.path("camera-intrinsics.txt"))
            folder.expect_error("8x6 pixels do not fit the intrinsics", "--intrinsics")
            folder.save(names[0], color(0, *size))
            folder.save(names[1], depth(0, *size))
            self.assertEqual(folder.convert()[INFO][0].K[0], fx)
            folder.doCleanups()

    def test_a_default_for_resized_images_is_refused_with_the_scaled_numbers(self):
        self.write_frames(1, with_intrinsics=False, color_size=(320, 240), depth_size=(320, 240))
        self.expect_error("frame-000000.color.png: 320x240 pixels", "7-Scenes' published values",
                          "they hold for 640x480", "if the images were resized from 640x480: "
                          "--intrinsics 292.5,292.5,159.75,119.75")

    def test_a_principal_point_outside_the_image_is_refused_with_the_option(self):
        self.write_frames(1)
        self.write("camera-intrinsics.txt", "20 0 8.5\n0 20 6\n0 0 1\n")
        self.expect_error("camera-intrinsics.txt", "cx 8.5 lies outside the image", "--intrinsics")

    def test_an_implausible_focal_length_is_refused_with_the_option(self):
        self.write_frames(1)
        self.write("camera-intrinsics.txt", "525 0 4\n0 525 3\n0 0 1\n")
        self.expect_error("camera-intrinsics.txt", "fx 525", "degrees", "--intrinsics")

    def test_a_centre_far_from_the_images_is_remarked(self):
        self.write_frames(1)
        self.convert()
        self.assertEqual(self.warnings(), [])
        self.convert("--intrinsics", "10,10,1.5,3")
        self.assertIn("cx 1.5", self.warnings()[0])

    def test_intrinsics_of_depth_given_for_larger_colour_images_are_remarked(self):
        folder = ScanNetFolder()
        folder.setUp()
        folder.write_frames()
        folder.convert("--intrinsics", "10,10.5,5.5,4")
        self.assertIn("cx 5.5", folder.warnings()[0])
        folder.doCleanups()

    def test_the_option_goes_before_the_folders_file_before_the_layouts(self):
        folder = ScanNetFolder()
        folder.setUp()
        folder.write_frames()
        mode = ["--match-size", "depth-to-color"]
        folder.expect_camera(folder.convert(*mode)[INFO][0], 20, 21, 11.5, 8.5)
        folder.write("camera-intrinsics.txt", "22 23 11 8")
        folder.expect_camera(folder.convert(*mode)[INFO][0], 22, 23, 11, 8)
        folder.expect_camera(folder.convert(*mode, "--intrinsics", "24,25,11,8")[INFO][0], 24, 25, 11, 8)
        folder.doCleanups()

    def test_every_layout_takes_the_option_as_numbers_and_as_a_file(self):
        for layout in (TumFolder, ReplicaFolder):
            folder = layout()
            folder.setUp()
            folder.write_frames()
            folder.expect_camera(folder.convert("--intrinsics", "12,13,4,3")[INFO][0], 12, 13, 4, 3)
            path = folder.write("own/k.txt", MATRIX_4X4)
            folder.expect_camera(folder.convert("--intrinsics", path)[INFO][0], 10, 11, 4, 3)
            folder.doCleanups()

    def test_a_wrong_option_is_refused_with_its_reason(self):
        self.write_frames(1)
        self.expect_usage_error("/no/k.txt", "absent", arguments=["--intrinsics", "/no/k.txt"])
        self.expect_usage_error("3 numbers", arguments=["--intrinsics", "1,2,3"])
        self.expect_usage_error("positive", arguments=["--intrinsics=-525,525,4,3"])

    def test_distortion_reaches_camera_info(self):
        self.write_frames(1)
        info = self.convert("--intrinsics", "10,11,4,3,0.1,-0.2,0.01,0.02")[INFO][0]
        self.assertEqual((info.distortion_model, list(info.D)),
                         ("plumb_bob", [0.1, -0.2, 0.01, 0.02, 0.0]))


class DepthScale(ThreeDMatchFolder):
    def test_metres_per_unit_and_units_per_metre_are_told_apart(self):
        for text, units_per_m in (("0.001", 1000.0), ("1000", 1000.0), ("0.0002", 5000.0),
                                  ("5000", 5000.0), ("0.00025", 4000.0), ("1e-4", 10000.0),
                                  ("6553.5", 6553.5), ("1", 1.0), ("0.01", 100.0)):
            self.assertEqual(depth_scale.parse_option(text).units_per_m, units_per_m)

    def test_what_is_no_plausible_unit_is_refused(self):
        for text in ("0", "-1", "nan", "inf", "5", "0.5", "1e-7", "2e6", "mm"):
            with self.assertRaises(argparse.ArgumentTypeError, msg=text):
                depth_scale.parse_option(text)
        self.write_frames(1)
        self.expect_usage_error("0.2 m per unit", arguments=["--depth-scale", "5"])

    def test_its_meaning_is_told(self):
        self.write_frames(1)
        self.convert("--depth-scale", "0.0002")
        self.assertIn("5000 units per metre (0.0002 m per unit), --depth-scale 0.0002", self.text)

    def test_whole_metres_are_refused_for_integers(self):
        self.write_frames(1)
        self.expect_error("frame-000000.depth.png", "16-bit integers",
                          arguments=["--depth-scale", "1"])

    def test_it_goes_before_every_layouts_own(self):
        for layout in (TumFolder, ReplicaFolder, ScanNetFolder):
            folder = layout()
            folder.setUp()
            folder.write_frames()
            pixels = depth_pixels(folder.convert("--depth-scale", "0.0025")[DEPTH][0])
            factor = 10 if layout is ReplicaFolder else 1
            size = (12, 9) if layout is ScanNetFolder else (8, 6)
            np.testing.assert_allclose(pixels, depth(0, *size) * factor * 0.0025, rtol=1e-6)
            folder.doCleanups()

    def test_saturated_readings_are_none_in_every_unit(self):
        self.write_frames(1)
        pixels = depth(0)
        pixels[2, 3] = 65535
        self.save("frame-000000.depth.png", pixels)
        self.assertEqual(depth_pixels(self.convert("--depth-scale", "5000")[DEPTH][0])[2, 3], 0)


class DepthPlausibility(ThreeDMatchFolder):
    def warnings_for(self, metres, *arguments):
        self.write_frames(2)
        for i in range(2):
            self.save(f"frame-{i:06d}.depth.png", np.uint16(np.full((6, 8), metres * 1000)))
        self.convert(*arguments)
        return self.warnings()

    def test_plausible_depth_is_silent(self):
        for metres in (0.3, 2.0, 14.0):
            self.assertEqual(self.warnings_for(metres), [])

    def test_an_implausible_median_tells_units_that_make_it_plausible(self):
        near, = self.warnings_for(1.0, "--depth-scale", "5000")
        self.assertIn("median depth is 0.2 m", near)
        self.assertIn("--depth-scale 1000 makes it 1 m", near)
        far, = self.warnings_for(20.0)
        self.assertIn("--depth-scale 10000 makes it 2 m", far)

    def test_readings_out_of_range_are_told_even_where_the_median_is_not(self):
        self.write_frames(1)
        pixels = np.full((6, 8), 100, np.uint16)
        pixels[:, 3:] = 300
        pixels[0, :4] = 25000
        pixels[:, 6:] = 30000
        self.save("frame-000000.depth.png", pixels)
        self.convert()
        self.assertIn("of the readings lie within 0.2 to 20 m", self.warnings()[0])

    def test_images_without_a_reading_are_told(self):
        self.write_frames(1)
        for value in (0, 65535):
            self.save("frame-000000.depth.png", np.full((6, 8), value, np.uint16))
            self.convert()
            self.assertIn("no depth reading in 1 frames", self.warnings()[0])


if __name__ == "__main__":
    unittest.main()
