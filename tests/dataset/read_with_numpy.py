#!/usr/bin/env python3
"""read_with_numpy.py ROOM: what plugins/dataset_write/README.md says of a dataset's folder, with NumPy alone."""
import json
import pathlib
import sys

import numpy as np

room = pathlib.Path(sys.argv[1])
manifest = json.loads((room / "dataset.json").read_text())
assert manifest["format"] == "fresco.dataset" and manifest["version"] == 1


def view(number, height):
    """The maps of one view at one height, texcoords in [0,1], and the world point that each pixel shows."""
    entry = manifest["views"][number]
    load = lambda name: np.load(room / f"views/{number:06d}" / f"{name}_{height}.npy")
    uv, depth, valid, color = load("uv"), load("depth"), load("valid").astype(bool), load("color")
    if uv.dtype == np.uint16:
        uv = uv.astype(np.float32) / 65535
    camera = entry["color_camera"]
    rows, columns = depth.shape
    scale = np.array([columns / camera["width"], rows / camera["height"]])
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    ray = np.stack([(x / scale[0] - camera["cx"]) / camera["fx"], (y / scale[1] - camera["cy"]) / camera["fy"], np.ones_like(x)], -1)
    pose = np.array(camera["world_from_camera"])
    points = (ray * depth[..., None]) @ pose[:, :3].T + pose[:, 3]
    return uv, valid, color, points


for number, entry in enumerate(manifest["views"]):
    for height, valid_pixels in zip(manifest["heights_px"], entry["valid_pixels"]):
        uv, valid, color, points = view(number, height)
        assert uv.shape == valid.shape + (2,) and color.shape == valid.shape + (3,) and color.dtype == np.uint8
        assert valid.sum() == valid_pixels and uv.min() >= 0 and uv.max() <= 1
        # The generated room is 4.5 x 3.6 x 2.6 m: a wrong axis or unit would leave it.
        size = np.ptp(points[valid], axis=0)
        assert (size < [4.7, 3.8, 2.8]).all() and size.max() > 1, size
for file in manifest["files"]:
    assert (room / file["name"]).stat().st_size == file["bytes"]
print(f"{len(manifest['views'])} views read with NumPy")
