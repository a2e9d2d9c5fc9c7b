# SPDX-License-Identifier: BSD-3-Clause
"""scripts/dataset_to_bag: types of images, broken ones, colour and depth of different sizes."""
import os
import sys
import unittest

import numpy as np
from PIL import Image

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from dataset_folder import (COLOR, DEPTH, INFO, ReplicaFolder, ScanNetFolder,  # noqa: E402
                            ThreeDMatchFolder, TumFolder, color, color_pixels, depth, depth_pixels,
                            stamps_ns)
from datasets import images, intrinsics, size_match  # noqa: E402
from datasets.frames import BrokenFile, Camera  # noqa: E402


class ImageTypes(ThreeDMatchFolder):
    DEPTH_NAME = "frame-000000.depth.png"

    def expect_depth_refused(self, pixels, *parts, **options):
        self.write_frames(1)
        self.save(self.DEPTH_NAME, pixels, **options)
        self.expect_error(self.DEPTH_NAME, *parts)

    def test_depth_of_8_bits_is_refused_by_type(self):
        self.expect_depth_refused(np.ones((6, 8), np.uint8), "8-bit grey PNG", "16 bits")

    def test_depth_in_colours_is_refused_by_type(self):
        for channels in (3, 4):
            self.expect_depth_refused(np.ones((6, 8, channels), np.uint8), "colour PNG", "16 bits")

    def test_depth_of_a_palette_or_one_bit_is_refused_by_type(self):
        for mode, name in (("P", "8-bit palette"), ("1", "1-bit"), ("LA", "8-bit grey")):
            self.write_frames(1)
            Image.new(mode, (8, 6)).save(self.path(self.DEPTH_NAME))
            self.expect_error(self.DEPTH_NAME, name, "16 bits")

    def test_depth_as_jpeg_under_another_ending_is_refused_by_type(self):
        self.expect_depth_refused(np.ones((6, 8), np.uint8), "8-bit grey JPEG", format="JPEG")

    def test_depth_as_jpeg_is_refused_by_type(self):
        self.write_frames(1)
        os.remove(self.path(self.DEPTH_NAME))
        self.save("frame-000000.depth.jpg", np.ones((6, 8), np.uint8))
        self.expect_error("frame-000000.depth.jpg", "8-bit grey JPEG", "16 bits")

    def test_all_frames_of_a_wrong_type_are_no_broken_files(self):
        self.write_frames(2)
        for i in range(2):
            self.save(f"frame-{i:06d}.depth.png", np.ones((6, 8), np.uint8))
        self.expect_error("none of 2 frames could be read", "8-bit grey",
                          arguments=["--skip-broken"])

    def write_tiff(self, values, **options):
        self.write_frames(1)
        os.remove(self.path(self.DEPTH_NAME))
        self.save("frame-000000.depth.tiff", values, **options)

    def test_float_depth_asks_for_its_unit(self):
        self.write_tiff(np.full((6, 8), 1.25, np.float32))
        self.expect_error("frame-000000.depth.tiff", "32-bit float", "--depth-scale 1", "0.001")

    def test_float_depth_with_a_unit_becomes_metres(self):
        values = np.full((6, 8), 1250.0, np.float32)
        values[0, :4] = [np.nan, np.inf, -1.0, 0.0]
        self.write_tiff(values)
        pixels = depth_pixels(self.convert("--depth-scale", "0.001")[DEPTH][0])
        np.testing.assert_allclose(pixels[0], [0, 0, 0, 0, 1.25, 1.25, 1.25, 1.25], rtol=1e-6)
        self.write_tiff(values / np.float32(1000))
        pixels = depth_pixels(self.convert("--depth-scale", "1")[DEPTH][0])
        np.testing.assert_allclose(pixels[1], 1.25, rtol=1e-6)

    def test_one_frame_of_another_type_is_named(self):
        self.write_frames(2)
        os.remove(self.path("frame-000001.depth.png"))
        self.save("frame-000001.depth.tiff", np.ones((6, 8), np.float32))
        self.expect_error("frame-000001.depth.tiff", "float32 image, expected uint16")

    def test_16_bits_in_any_byte_order_are_depth(self):
        self.write_frames(1)
        os.remove(self.path(self.DEPTH_NAME))
        image = Image.frombytes("I;16B", (8, 6), depth(0).astype(">u2").tobytes())
        image.save(self.path("frame-000000.depth.tiff"))
        np.testing.assert_array_equal(depth_pixels(self.convert()[DEPTH][0]), depth(0))

    def test_depth_beyond_16_bits_is_refused(self):
        self.write_tiff(np.full((6, 8), 70000, np.int32))
        self.expect_error("frame-000000.depth.tiff", "70000", "expected 0 to 65535")

    def test_grey_colour_is_taken_16_bit_grey_and_float_are_refused(self):
        self.write_frames(1)
        self.save("frame-000000.color.png", np.full((6, 8), 77, np.uint8))
        np.testing.assert_array_equal(color_pixels(self.convert()[COLOR][0]), 77)
        os.remove(self.output)
        self.save("frame-000000.color.png", np.full((6, 8), 7777, np.uint16))
        self.expect_error("frame-000000.color.png", "16-bit grey PNG", "8-bit colour")
        self.save("frame-000000.color.png", np.ones((6, 8), np.float32), format="TIFF")
        self.expect_error("frame-000000.color.png", "32-bit float TIFF", "8-bit colour")

    def test_transparency_and_palettes_become_colours(self):
        self.write_frames(2)
        self.save("frame-000000.color.png", np.full((6, 8, 4), (10, 20, 30, 255), np.uint8))
        Image.fromarray(color(1)).quantize(4).save(self.path("frame-000001.color.png"))
        first, second = self.convert()[COLOR]
        np.testing.assert_array_equal(color_pixels(first)[0, 0], [10, 20, 30])
        np.testing.assert_allclose(color_pixels(second), color(1), atol=4)


class BrokenImages(ThreeDMatchFolder):
    """Frames 0 and 2 are whole, one image of frame 1 is not."""

    def write_three(self, ending):
        self.write_frames(3)
        if ending == ".color.jpg":
            os.remove(self.path("frame-000001.color.png"))
            noise = np.random.RandomState(1).randint(0, 255, (6, 8, 3)).astype(np.uint8)
            self.save("frame-000001.color.jpg", noise, quality=95)
        return "frame-000001" + ending

    def expect_skippable(self, name, *parts):
        self.expect_error(name, "--skip-broken", *parts)
        messages = self.convert("--skip-broken", "--rate", "10")
        self.assertEqual(stamps_ns(messages[COLOR]), [1000000000, 1200000000])
        self.assertEqual(len(messages["/tf"]), 2)
        self.assertIn("1 broken files or lines skipped", self.text.splitlines()[-1])
        self.assertTrue(any(name in line for line in self.warnings()), self.text)
        os.remove(self.output)

    def test_truncated_images_are_named_and_skipped(self):
        for ending in (".depth.png", ".color.png", ".color.jpg"):
            for share in (0.05, 0.5, 0.9):
                name = self.write_three(ending)
                self.cut(name, share)
                self.expect_skippable(name)
                os.remove(self.path(name))

    def test_empty_images_and_texts_are_named_and_skipped(self):
        for ending in (".depth.png", ".color.png"):
            for data, fault in ((b"", "empty file"), (b"<html>404</html>", "no known image type")):
                name = self.write_three(ending)
                self.write_bytes(name, data)
                self.expect_skippable(name, fault)

    def test_a_tail_of_zeros_is_damage(self):
        """What a crashed machine leaves: the size is right, the last blocks were never written."""
        for ending in (".depth.png", ".color.png", ".color.jpg"):
            name = self.write_three(ending)
            data = self.read_bytes(name)
            kept = int(len(data) * 0.7)
            self.write_bytes(name, data[:kept] + bytes(len(data) - kept))
            self.expect_skippable(name)
            os.remove(self.path(name))

    def test_one_flipped_bit_in_a_png_is_damage(self):
        name = self.write_three(".depth.png")
        data = bytearray(self.read_bytes(name))
        data[data.index(b"IDAT") + 12] ^= 0x10
        self.write_bytes(name, bytes(data))
        self.expect_skippable(name)

    def test_one_image_of_another_size_is_named_and_skipped(self):
        for ending, pixels in ((".depth.png", depth(0, 4, 3)), (".color.png", color(0, 4, 3))):
            name = self.write_three(ending)
            self.save(name, pixels)
            self.expect_skippable(name, "4x3", "8x6")

    def test_one_image_of_another_type_is_named_and_skipped(self):
        name = self.write_three(".depth.png")
        self.save(name, np.ones((6, 8), np.uint8))
        self.expect_skippable(name, "8-bit grey")

    def test_the_first_image_may_be_the_broken_one(self):
        self.write_frames(3)
        self.cut("frame-000000.color.png", 0.02)
        self.save("frame-000000.depth.png", depth(0, 4, 3))
        self.assertEqual(len(self.convert("--skip-broken")[COLOR]), 2)

    def test_a_broken_pose_file_is_named_and_skipped(self):
        for text in ("", "1 2 3\n", "one two\n"):
            self.write_frames(3)
            self.write("frame-000001.pose.txt", text)
            self.expect_skippable("frame-000001.pose.txt")
        self.write_bytes("frame-000001.pose.txt", bytes(100))
        self.expect_skippable("frame-000001.pose.txt", "zero bytes")
        self.write_bytes("frame-000001.pose.txt", b"\xff\xfe\x81")
        self.expect_skippable("frame-000001.pose.txt", "binary data")

    def test_broken_files_beyond_a_few_are_only_counted(self):
        self.write_frames(9)
        for i in range(1, 9):
            self.write_bytes(f"frame-{i:06d}.depth.png", b"")
        self.convert("--skip-broken")
        self.assertIn("skipped: 3 more", self.warnings()[-1])
        self.assertIn("1 frames over 0.00 s, 8 broken files", self.text.splitlines()[-1])

    def test_broken_label_images_are_skipped_with_their_frame(self):
        self.write_frames(3)
        for i in range(3):
            self.save(f"frame-{i:06d}.labels.png", np.full((6, 8), 1, np.uint16))
        np.savez(self.path("embeddings.npz"), instance_ids=np.int32([1]),
                 embeddings=np.float32([[1]]), task_names=np.array(["a"]),
                 task_embeddings=np.float32([[1]]))
        self.cut("frame-000001.labels.png")
        self.expect_skippable("frame-000001.labels.png")

    def test_whole_images_of_each_format_pass(self):
        noise = np.random.RandomState(1).randint(0, 255, (60, 80, 3)).astype(np.uint8)
        for name, options in (("a.png", {}), ("a.jpg", {}), ("b.jpg", {"progressive": True}),
                              ("a.tiff", {}), ("b.tiff", {"compression": "tiff_deflate"})):
            self.save(name, noise, **options)
            self.assertEqual(images.read_color(self.path(name)).shape, (60, 80, 3))

    def test_an_end_mark_inside_a_thumbnail_is_not_the_images_own(self):
        """A JPEG that ends in zeros, with a whole small JPEG in its header."""
        noise = np.random.RandomState(1).randint(0, 255, (60, 80, 3)).astype(np.uint8)
        self.save("small.jpg", noise[:8, :8])
        self.save("a.jpg", noise)
        small, data = self.read_bytes("small.jpg"), self.read_bytes("a.jpg")
        segment = b"\xff\xe1" + (len(small) + 2).to_bytes(2, "big") + small
        data = data[:2] + segment + data[2:]
        self.write_bytes("a.jpg", data)
        self.assertEqual(images.read_color(self.path("a.jpg")).shape, (60, 80, 3))
        self.write_bytes("a.jpg", data[:-500] + bytes(500))
        with self.assertRaises(BrokenFile):
            images.read_color(self.path("a.jpg"))


class BrokenFilesOfOtherLayouts(unittest.TestCase):
    def test_a_truncated_depth_image_is_named_and_skipped_in_every_layout(self):
        for layout, name in ((TumFolder, "depth/2.png"), (ReplicaFolder, "results/depth000001.png"),
                             (ScanNetFolder, "depth/1.png")):
            folder = layout()
            folder.setUp()
            folder.write_frames()
            folder.cut(name)
            folder.expect_error(name, "--skip-broken")
            folder.convert("--skip-broken")
            self.assertIn("1 broken files or lines skipped", folder.text)
            folder.doCleanups()


class DifferentSizes(ThreeDMatchFolder):
    def write_sizes(self, color_size, depth_size, intrinsics_of_color="20 0 8\n0 22 6\n0 0 1\n"):
        self.write_frames(2, color_size=color_size, depth_size=depth_size)
        self.write("camera-intrinsics.txt", intrinsics_of_color)

    def test_they_are_refused_with_both_sizes_files_and_the_option(self):
        self.write_sizes((16, 12), (8, 6))
        self.expect_error("frame-000000.color.png: 16x12", "frame-000000.depth.png: 8x6",
                          "--match-size color-to-depth", "--match-size depth-to-color")

    def test_colour_is_brought_to_depth(self):
        self.write_sizes((16, 12), (8, 6))
        messages = self.convert("--match-size", "color-to-depth")
        np.testing.assert_array_equal(depth_pixels(messages[DEPTH][1]), depth(1))
        np.testing.assert_array_equal(color_pixels(messages[COLOR][1]), color(1))
        self.expect_camera(messages[INFO][0], 10.0, 11.0, 3.75, 2.75)  # (c + 0.5) / 2 - 0.5
        self.assertEqual((messages[INFO][0].width, messages[INFO][0].height), (8, 6))

    def test_depth_is_brought_to_colour_and_never_mixed(self):
        self.write_sizes((16, 12), (8, 6))
        messages = self.convert("--match-size", "depth-to-color")
        np.testing.assert_array_equal(depth_pixels(messages[DEPTH][1]),
                                      depth(1).repeat(2, axis=0).repeat(2, axis=1))
        np.testing.assert_array_equal(color_pixels(messages[COLOR][1]), color(1, 16, 12))
        self.expect_camera(messages[INFO][0], 20.0, 22.0, 8.0, 6.0)

    def test_depth_larger_than_colour_goes_both_ways(self):
        self.write_sizes((8, 6), (16, 12), "10 0 3.75\n0 11 2.75\n0 0 1\n")
        pixels = depth_pixels(self.convert("--match-size", "depth-to-color")[DEPTH][0])
        self.assertEqual(pixels.shape, (6, 8))
        self.assertTrue(set(pixels.ravel()) <= set(depth(0, 16, 12).ravel()))
        messages = self.convert("--match-size", "color-to-depth")
        np.testing.assert_array_equal(color_pixels(messages[COLOR][0]), color(0, 16, 12))
        self.expect_camera(messages[INFO][0], 20.0, 22.0, 8.0, 6.0)

    def test_another_aspect_is_refused_without_both_intrinsics(self):
        self.write_sizes((16, 12), (8, 5))
        for mode in size_match.MODES:
            self.expect_error("16x12", "8x5", "--depth-intrinsics", arguments=["--match-size", mode])
        self.convert("--depth-intrinsics", "10,11,3.75,2")

    def test_an_aspect_within_1_percent_is_scaled_in_each_direction(self):
        """As ScanNet's: 1296x968 and 640x480."""
        self.write_sizes((1296, 968), (640, 480), "1170 0 647.75\n0 1170 483.75\n0 0 1\n")
        info = self.convert("--match-size", "color-to-depth", "--max-frames", "1")[INFO][0]
        self.expect_camera(info, 1170 / 2.025, 1170 * 480 / 968, 648.25 / 2.025 - 0.5,
                           484.25 * 480 / 968 - 0.5)

    def test_every_layout_matches_sizes(self):
        for layout, name in ((TumFolder, "rgb/{}.png"), (ReplicaFolder, "results/frame00000{}.jpg")):
            folder = layout()
            folder.setUp()
            folder.write_frames()
            for i in range(2):
                folder.save(name.format(i), color(i, 16, 12))
            if layout is TumFolder:
                folder.save(name.format(2), color(2, 16, 12))
            folder.write("camera-intrinsics.txt", "20 0 8\n0 22 6\n0 0 1\n")
            folder.expect_error("16x12", "8x6", "--match-size")
            messages = folder.convert("--match-size", "color-to-depth")
            self.assertEqual((messages[COLOR][0].width, messages[DEPTH][0].width), (8, 8))
            folder.doCleanups()


class Grids(unittest.TestCase):
    """Images whose value is a function of the ray: after matching it still is the same function."""
    LARGE, LARGE_SIZE = Camera(100.0, 110.0, 47.3, 36.1, ""), (96, 72)
    SMALL, SMALL_SIZE = Camera(40.0, 40.0, 21.0, 15.0, ""), (40, 30)

    def ramp(self, camera, size):
        u, v = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
        x, y = (u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px
        return 128.0 + 120.0 * x + 60.0 * y

    def test_colour_keeps_its_rays_in_both_directions(self):
        for source, target in (((self.LARGE, self.LARGE_SIZE), (self.SMALL, self.SMALL_SIZE)),
                               ((self.SMALL, self.SMALL_SIZE), (self.LARGE, self.LARGE_SIZE))):
            grid = size_match.make_grid(*source, *target)
            image = np.rint(self.ramp(*source)).astype(np.uint8)[..., None].repeat(3, axis=2)
            moved = grid.average(image)[..., 0].astype(float)
            inner = np.zeros(moved.shape, bool)
            inner[4:-4, 4:-4] = grid.is_inside()[4:-4, 4:-4]
            for shift in ((4, 0), (-4, 0), (0, 4), (0, -4)):
                inner &= np.roll(grid.is_inside(), shift, (0, 1))
            self.assertGreater(inner.sum(), 200)
            self.assertLess(np.abs(moved - self.ramp(*target))[inner].max(), 1.2)

    def test_nearest_takes_the_closest_pixel_and_0_outside(self):
        grid = size_match.make_grid(self.LARGE, self.LARGE_SIZE, self.SMALL, self.SMALL_SIZE)
        source = np.arange(1, 96 * 72 + 1, dtype=np.uint16).reshape(72, 96)
        taken = grid.take_nearest(source)
        for v in range(30):
            for u in range(40):
                column = (u - 21.0) / 40.0 * 100.0 + 47.3
                row = (v - 15.0) / 40.0 * 110.0 + 36.1
                inside = -0.5 <= column < 95.5 and -0.5 <= row < 71.5
                expected = source[int(np.floor(row + 0.5)), int(np.floor(column + 0.5))] if inside else 0
                self.assertEqual(taken[v, u], expected)
        self.assertTrue((taken == 0).any())

    def test_the_ratio_of_sizes_maps_edges_to_edges(self):
        small = intrinsics.scale(self.LARGE, (96, 72), (32, 24))
        grid = size_match.make_grid(self.LARGE, (96, 72), small, (32, 24))
        for axis, count in ((grid.x, 32), (grid.y, 24)):
            for u in (0, 5, count - 1):
                self.assertAlmostEqual(axis.scale * u + axis.offset, (u + 0.5) * 3 - 0.5)

    def test_equal_cameras_change_nothing(self):
        grid = size_match.make_grid(self.LARGE, self.LARGE_SIZE, self.LARGE, self.LARGE_SIZE)
        noise = np.random.RandomState(2).randint(0, 255, (72, 96, 3)).astype(np.uint8)
        np.testing.assert_array_equal(grid.average(noise), noise)
        np.testing.assert_array_equal(grid.take_nearest(noise[..., 0]), noise[..., 0])


class PartialView(ScanNetFolder):
    def test_depth_beyond_colours_view_is_dropped_and_its_share_told(self):
        self.write_frames()
        self.write("intrinsic/intrinsic_color.txt", "40 0 11.5 0\n0 42 8.5 0\n0 0 1 0\n0 0 0 1\n")
        pixels = depth_pixels(self.convert()[DEPTH][0])
        self.assertEqual(pixels[0, 0], 0)
        self.assertTrue((pixels[3:6, 4:8] > 0).all())
        self.assertIn("of the depth readings lie outside the colour image", self.text)

    def test_scannet_can_keep_colours_size(self):
        self.write_frames()
        messages = self.convert("--match-size", "depth-to-color")
        self.assertEqual((messages[DEPTH][0].width, messages[COLOR][0].width), (24, 24))
        self.expect_camera(messages[INFO][0], 20, 21, 11.5, 8.5)
        self.assertTrue(set(depth_pixels(messages[DEPTH][1]).ravel())
                        <= set(depth(1, 12, 9).ravel()) | {0})

    def test_two_cameras_of_one_size_are_matched_too(self):
        self.write_frames()
        for i in range(3):
            self.save(f"color/{i}.jpg", color(i, 12, 9))
        self.write("intrinsic/intrinsic_color.txt", "12 0 5.5 0\n0 12 4 0\n0 0 1 0\n0 0 0 1\n")
        self.expect_camera(self.convert()[INFO][0], 10.0, 10.5, 5.5, 4.0)
        self.assertIn("colour 12x9 brought to depth's 12x9", self.text)


if __name__ == "__main__":
    unittest.main()
