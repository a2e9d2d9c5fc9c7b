# SPDX-License-Identifier: BSD-3-Clause
"""Trains the demo models on the simulation's own renders. See docs/demo_models.md."""
