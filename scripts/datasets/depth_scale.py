# SPDX-License-Identifier: BSD-3-Clause
"""The unit of depth images."""
import argparse
from typing import NamedTuple

import numpy as np

from .frames import DatasetError
from .images import NO_READING

LIMITS_M_PER_UNIT = (1e-6, 0.1)  # of integer images


class DepthScale(NamedTuple):
    units_per_m: float
    source: str

    @property
    def is_millimetres(self):
        return self.units_per_m == 1000.0

    def to_metres(self, raw):
        """float32, 0 where there is no reading: 65535 in integers; NaN, inf, negative in floats."""
        if raw.dtype == np.uint16:
            return np.where(raw == NO_READING, 0, raw / self.units_per_m).astype(np.float32)
        with np.errstate(invalid="ignore"):
            return np.where(np.isfinite(raw) & (raw > 0), raw / self.units_per_m,
                            0).astype(np.float32)

    def require_type(self, raw, path, is_given):
        """Float images need a unit said by the user; whole metres make no sense in integers."""
        if raw.dtype != np.uint16 and not is_given:
            raise DatasetError(f"{path}: 32-bit float image, expected 16-bit integers; if its unit "
                               "is metres: --depth-scale 1, millimetres: --depth-scale 0.001")
        if raw.dtype == np.uint16 and self.units_per_m < 1.0 / LIMITS_M_PER_UNIT[1]:
            raise DatasetError(f"{path}: 16-bit integers, expected a --depth-scale below 0.1 m per "
                               "unit; 1 (metres) is for float images")

    def describe(self):
        return (f"{self.units_per_m:g} units per metre ({1.0 / self.units_per_m:g} m per unit), "
                f"{self.source}")


def parse_option(text):
    """Up to 1: metres per unit; above 1: units per metre. Raises argparse.ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}', expected a number")
    if not value > 0.0:
        raise argparse.ArgumentTypeError(f"{text}, expected more than 0")
    m_per_unit = value if value <= 1.0 else 1.0 / value
    low, high = LIMITS_M_PER_UNIT
    if m_per_unit != 1.0 and not low * (1 - 1e-9) <= m_per_unit <= high * (1 + 1e-9):
        raise argparse.ArgumentTypeError(
            f"{text} is {m_per_unit:g} m per unit, expected {low:g} to {high:g} (metres per unit "
            "up to 1, like 0.001; units per metre above 1, like 5000), or 1 for float images in "
            "metres")
    units_per_m = value if value > 1.0 else float(f"{1.0 / value:.12g}")
    return DepthScale(units_per_m, f"--depth-scale {text}")
