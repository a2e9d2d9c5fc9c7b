# SPDX-License-Identifier: BSD-3-Clause
"""Numbers, stamps and matrices out of text files; every error names file, line and value."""
import re
from decimal import Decimal, InvalidOperation

import numpy as np

from .frames import BrokenFile, DatasetError

MAX_ROS_STAMP_S = 2**32  # ROS 1 counts seconds in 32 bits
# Microsoft's C library prints -1.#IND, 1.#QNAN, 1.#INF for what is not a number.
MICROSOFT_NAN = re.compile(r"[-+]?1\.#\w+")


def read_text(path):
    """The file's text; raises BrokenFile where there is none or it is not text."""
    try:
        with open(path, encoding="utf-8-sig") as file:
            text = file.read()
    except FileNotFoundError:
        raise BrokenFile(f"{path}: absent, expected a text file")
    except UnicodeDecodeError:
        raise BrokenFile(f"{path}: binary data, expected a text file")
    if "\0" in text:
        raise BrokenFile(f"{path}: zero bytes (damaged?), expected text")
    return text


def data_lines(path):
    """[(line number from 1, stripped text)] without empty lines and comments (#)."""
    lines = [(number, line.strip()) for number, line in enumerate(read_text(path).splitlines(), 1)]
    return [(number, line) for number, line in lines if line and not line.startswith("#")]


def parse_floats(text, place):
    """All numbers of a text, between blanks or commas; `place` (file:line) is for the error."""
    text = MICROSOFT_NAN.sub("nan", text.replace(",", " "))
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        raise BrokenFile(f"{place}: '{text.strip()[:60]}', expected numbers")


def parse_pose(text, place):
    """4x4 of one line: 16 numbers, or the 12 of its upper rows, row-major."""
    return to_pose(parse_floats(text, place), place)


def read_pose(path):
    """4x4 of a file of its own."""
    return to_pose([value for number, line in data_lines(path)
                    for value in parse_floats(line, f"{path}:{number}")], path)


def to_pose(values, place):
    """Raises BrokenFile for another count or last row; whether it is rigid is not looked at."""
    if len(values) not in (12, 16):
        raise BrokenFile(f"{place}: {len(values)} numbers, expected 16 (a 4x4 matrix)")
    T = np.array(values + [0.0, 0.0, 0.0, 1.0][: 16 - len(values)]).reshape(4, 4)
    if np.isfinite(T).all() and T.any() and not np.allclose(T[3], [0, 0, 0, 1], atol=1e-6):
        raise BrokenFile(f"{place}: last row {' '.join(f'{v:g}' for v in T[3])}, expected 0 0 0 1 "
                         "(a matrix written column by column must be transposed)")
    return T


def parse_seconds_ns(text, place):
    """Decimal seconds -> nanoseconds, exactly (a float has 0.2 us left at today's Unix time)."""
    try:
        seconds = Decimal(text)
        if not seconds.is_finite():
            raise ValueError
    except (InvalidOperation, ValueError):
        raise BrokenFile(f"{place}: '{text}', expected seconds")
    if not 0 <= seconds < MAX_ROS_STAMP_S:
        unit = next((name for name, digits in (("nanoseconds", 17), ("microseconds", 14),
                                               ("milliseconds", 11))
                     if seconds >= 10**digits), "")
        guess = f" (it looks like {unit})" if unit else ""
        raise DatasetError(f"{place}: '{text}', expected seconds from 0 to {MAX_ROS_STAMP_S - 1}"
                           f"{guess}")
    return int((seconds * 1000000000).to_integral_value())
