# SPDX-License-Identifier: BSD-3-Clause
"""Compares what an exported network computes with what its source computes. Needs NumPy only."""
import numpy


class Mismatch(Exception):
    """An export that does not do what its source does, or a check that could not tell."""


def require_same_shape(name, expected, actual):
    if expected.shape != actual.shape:
        raise Mismatch("%s: the export gives %s, its source %s" % (name, list(actual.shape), list(expected.shape)))
    for whose, values in (("export", actual), ("source", expected)):
        if not numpy.isfinite(values).all():
            raise Mismatch("%s: the %s gives NaN or infinite values" % (name, whose))


def measure_spread(rows):
    """Largest difference between any two rows: how much the output depends on the input at all."""
    return float((rows.max(axis=0) - rows.min(axis=0)).max())


def compare_rows(name, expected, actual, tolerance):
    """Compares outputs for several inputs, one per row (or per first index).

    The tolerance is relative to the largest value. A network that gives nearly the same for every
    input would pass with any weights, so that is a Mismatch, too. Returns a line of text.
    """
    expected = numpy.asarray(expected, dtype=numpy.float64)
    actual = numpy.asarray(actual, dtype=numpy.float64)
    require_same_shape(name, expected, actual)
    scale = max(float(numpy.abs(expected).max()), 1e-12)
    difference = float(numpy.abs(expected - actual).max()) / scale
    spread = measure_spread(expected.reshape(len(expected), -1)) / scale
    if difference > tolerance:
        raise Mismatch("%s: differs by %.2g of the largest value, at most %.2g is allowed" % (name, difference, tolerance))
    if spread < 100 * tolerance:
        raise Mismatch("%s: %d different inputs give outputs within %.2g of each other, so nothing was checked"
                       % (name, len(expected), spread))
    return "%s: %d inputs, largest difference %.2g (allowed %.2g); the inputs' own outputs differ by %.2g" % (
        name, len(expected), difference, tolerance, spread)


def normalize(rows):
    rows = numpy.asarray(rows, dtype=numpy.float64)
    return rows / numpy.linalg.norm(rows, axis=-1, keepdims=True)


def compare_embeddings(name, expected, actual, tolerance=1e-4):
    require_same_shape(name, numpy.asarray(expected), numpy.asarray(actual))
    return compare_rows(name, normalize(expected), normalize(actual), tolerance)


def run_onnx(path, values):
    """Outputs of an ONNX file of one input."""
    import onnxruntime
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    return session.run(None, {session.get_inputs()[0].name: values})
