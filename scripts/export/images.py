# SPDX-License-Identifier: BSD-3-Clause
"""The photographs that exports are checked with (and random networks calibrated)."""
import pathlib


def default_folder():
    """The two photographs that ultralytics brings along, or None."""
    try:
        from ultralytics.utils import ASSETS
    except ImportError:
        return None
    return pathlib.Path(ASSETS)


def load_views(folder, count=8):
    """Views of photographs: each whole and its quarters, as RGB PIL images."""
    from PIL import Image
    folder = pathlib.Path(folder) if folder else default_folder()
    paths = sorted(p for p in folder.glob("*") if p.suffix.lower() in (".jpg", ".jpeg", ".png")) if folder else []
    if not paths:
        raise SystemExit("no photographs to check with in '%s': name a folder of .jpg or .png files with --images" % folder)
    views = []
    for path in paths:
        image = Image.open(path).convert("RGB")
        width, height = image.size
        views.append(image)
        for left, top in ((0, 0), (width // 2, 0), (0, height // 2), (width // 2, height // 2)):
            views.append(image.crop((left, top, left + width // 2, top + height // 2)))
    step = max(1, len(views) // count)
    return views[::step][:count]
