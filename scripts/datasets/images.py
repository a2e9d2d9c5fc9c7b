# SPDX-License-Identifier: BSD-3-Clause
"""Images, decoded to the last row and checked for their type before anything is taken from them."""
import collections
import io
import struct
import zlib

import numpy as np
from PIL import Image

from .frames import BrokenFile

NO_READING = 65535  # the largest value of 16 bits: 7-Scenes' mark, elsewhere a saturated reading
GREY_16_BITS = ("I", "I;16", "I;16B", "I;16L", "I;16N")
# What Pillow raises for damaged files, by format and version.
DECODING_ERRORS = (OSError, SyntaxError, ValueError, EOFError, IndexError, TypeError,
                   OverflowError, MemoryError, struct.error, zlib.error,
                   Image.DecompressionBombError)


def read_color(path):
    """H x W x 3, uint8, RGB."""
    image = open_image(path)
    if image.mode in GREY_16_BITS or image.mode == "F":
        raise BrokenFile(f"{path}: {describe_type(image)}, expected an 8-bit colour or grey image")
    return np.asarray(image.convert("RGB"))


def read_depth(path):
    """H x W in the file's own unit: uint16, or float32 for a float image."""
    image = open_image(path)
    if image.mode == "F":
        return np.asarray(image, np.float32)
    if image.mode not in GREY_16_BITS:
        raise BrokenFile(f"{path}: {describe_type(image)}, expected depth as one channel of "
                         "16 bits")
    return to_uint16(path, image)


def read_labels(path):
    """H x W, uint16: instance ids, from 8 or 16 bits or the indices of a palette."""
    image = open_image(path)
    if image.mode not in GREY_16_BITS + ("L", "P", "1"):
        raise BrokenFile(f"{path}: {describe_type(image)}, expected ids as one channel of 8 or 16 "
                         "bits")
    return to_uint16(path, image)


def to_uint16(path, image):
    pixels = np.asarray(image)
    if pixels.min(initial=0) < 0 or pixels.max(initial=0) > 65535:
        raise BrokenFile(f"{path}: values {pixels.min()} to {pixels.max()}, expected 0 to 65535")
    return pixels.astype(np.uint16)


def describe_type(image):
    names = {"L": "8-bit grey", "LA": "8-bit grey", "P": "8-bit palette", "1": "1-bit",
             "F": "32-bit float", "RGB": "colour", "RGBA": "colour"}
    names.update((mode, "16-bit grey") for mode in GREY_16_BITS)
    return f"{names.get(image.mode, image.mode)} {image.format} image"


def open_image(path):
    """The whole file, decoded; raises BrokenFile for one that is absent, empty, cut or damaged."""
    data = read_bytes(path)
    try:
        image = Image.open(io.BytesIO(data))
        image.load()
        if image.format == "PNG":
            Image.open(io.BytesIO(data)).verify()  # checksums
    except DECODING_ERRORS as error:
        raise BrokenFile(f"{path}: {len(data)} bytes, cannot be decoded ({explain(error)}), "
                         "expected a whole image")
    # libjpeg fills up what it cannot decode: a file that ends in zeros shows only by its end.
    if image.format == "JPEG" and data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda"):
        raise BrokenFile(f"{path}: JPEG without its end mark (truncated?), expected a whole image")
    return image


def read_bytes(path):
    try:
        with open(path, "rb") as file:
            data = file.read()
    except FileNotFoundError:
        raise BrokenFile(f"{path}: absent, expected an image")
    except OSError as error:
        raise BrokenFile(f"{path}: {error.strerror}, expected a readable image")
    if not data:
        raise BrokenFile(f"{path}: empty file, expected an image")
    return data


def explain(error):
    """A decoder's words without the address of the buffer that it read from."""
    if "cannot identify" in str(error):
        return "no known image type, or damaged at its start"
    return str(error) or type(error).__name__


def read_size(path):
    """(width, height) from the header; None where it cannot be read."""
    try:
        with Image.open(path) as image:
            return image.size
    except DECODING_ERRORS:
        return None


def find_common_size(paths):
    """(the most frequent size among a sample of the images, the first path that has it); raises
    BrokenFile where no header can be read."""
    step = max(1, len(paths) // 20)
    sizes = [(read_size(path), path) for path in paths[::step]]
    known = [size for size, _ in sizes if size]
    if not known:
        open_image(paths[0])
        raise BrokenFile(f"{paths[0]}: size cannot be read, expected an image")
    common = collections.Counter(known).most_common(1)[0][0]
    return common, next(path for size, path in sizes if size == common)
