#!/usr/bin/env python3
"""read_with_numpy.py ROOM: what plugins/dataset/write/README.md says of a dataset's folder, by the loader that stands in it (NumPy alone,
and PyTorch where it is)."""
import importlib.util
import json
import pathlib
import sys
import types

import numpy as np

room = pathlib.Path(sys.argv[1])
sys.path[:0] = (str(room), str(pathlib.Path(__file__).resolve().parents[1]))
sys.dont_write_bytecode = True
from fresco_dataset import Dataset, points, sampling_grid  # noqa: E402
from skipping import skip  # noqa: E402


def refuses(error, text, call):
    try:
        call()
    except error as found:
        assert text in str(found), found
        return
    raise AssertionError(f"{text}: not refused")


manifest = json.loads((room / "dataset.json").read_text())
assert manifest["writer"].startswith("fresco ")
# Contents are compared, or it is said that they were not.
Dataset(room).check(sizes_only=True)
if importlib.util.find_spec("xxhash"):
    Dataset(room).check()
else:
    skip("contents of a dataset against its manifest: python3 has no xxhash")
sys.modules["xxhash"] = types.SimpleNamespace(xxh3_128_hexdigest=lambda contents: "0" * 32)
refuses(ValueError, "has other contents than dataset.json lists", Dataset(room).check)
Dataset(room).check(sizes_only=True)
sys.modules["xxhash"] = None
refuses(ImportError, "pip install xxhash", Dataset(room).check)
for height, counts in zip(manifest["heights_px"], zip(*(view["valid_pixels"] for view in manifest["views"]))):
    dataset = Dataset(room, height_px=height)
    assert len(dataset) == len(counts) == len(list(dataset))
    for view, valid_pixels in zip(dataset, counts):
        assert view["uv"].shape == view["valid"].shape + (2,) and view["uv"].dtype == np.float32
        assert view["color"].shape == view["valid"].shape + (3,) and view["color"].dtype == np.uint8
        assert view["valid"].sum() == valid_pixels and view["uv"].min() >= 0 and view["uv"].max() <= 1
        # The generated room is 4.5 x 3.6 x 2.6 m: a wrong axis or unit would leave it.
        size = np.ptp(points(view)[view["valid"]], axis=0)
        assert (size < [4.7, 3.8, 2.8]).all() and size.max() > 1, size

# The mesh at a pixel's texcoord is the point that the pixel shows: uv, depth, pose, intrinsics and mesh belong together.
positions, triangles, texcoords = dataset.mesh()
view = dataset[0]
pixels = np.argwhere(view["valid"])[::97]
assert len(pixels) > 20
for y, x in pixels:
    around = texcoords.astype(float) - view["uv"][y, x]
    areas = np.stack([np.linalg.det(around[:, [(i + 1) % 3, (i + 2) % 3]]) for i in range(3)], 1)
    with np.errstate(all="ignore"):
        shares = areas / areas.sum(1, keepdims=True)
    inside = (shares > -1e-3).all(1)
    found = (positions[triangles[inside]] * shares[inside][..., None]).sum(1)
    assert inside.any() and np.linalg.norm(found - points(view)[y, x], axis=1).min() < 0.01, (x, y)

assert dataset.picture(0).dtype == np.uint8 and dataset.picture(0).shape[2] == 3
# What the depth camera measured is the mesh's surface, within the generated noise.
assert dataset.has_sensor_depth
seen = np.concatenate([points(view)[view["valid"]] for view in dataset])
low, high = seen.min(axis=0) - 0.1, seen.max(axis=0) + 0.1
for view in dataset:
    sensor = {"depth": view["sensor_depth"], "intrinsics": view["sensor_intrinsics"], "world_from_camera": view["world_from_sensor"]}
    measured = points(sensor)[view["sensor_depth"] > 0]
    assert len(measured) > 1000 and ((measured > low) & (measured < high)).all(-1).mean() > 0.99
assert dataset.style() is None or dataset.style().dtype == np.uint8

refuses(ValueError, "no height of 7 px", lambda: Dataset(room, height_px=7))
refuses(IndexError, "view 99 of", lambda: dataset[99])
refuses(FileNotFoundError, "dataset.json: is missing", lambda: Dataset(room / "views"))
print(f"{len(dataset)} views read with NumPy")

try:
    import torch
except ImportError:
    skip("the dataset read with PyTorch: python3 has no torch")
    sys.exit(0)
batch = next(iter(torch.utils.data.DataLoader(Dataset(room, tensors=True), batch_size=2)))
assert batch["color"].shape[:2] == (2, 3) and batch["color"].dtype == torch.float32 and batch["color"].max() <= 1
assert torch.equal(batch["uv"][1], torch.from_numpy(dataset[1]["uv"]))
assert torch.equal(batch["sensor_depth"][1], torch.from_numpy(dataset.sensor_depth(1)))
world = points(batch)
assert world.shape == batch["uv"].shape[:3] + (3,)
assert np.abs(world[1].numpy() - points(dataset[1])).max() < 1e-9
assert torch.equal(points(Dataset(room, tensors=True)[1]), world[1])
# A texture whose texels hold their own uv, sampled by the grid, gives the uv again.
size = 64
at = (torch.arange(size) + 0.5) / size
texture = torch.stack([at.expand(size, size), 1 - at[:, None].expand(size, size)])[None].repeat(2, 1, 1, 1)
sampled = torch.nn.functional.grid_sample(texture, sampling_grid(batch["uv"]), align_corners=False, padding_mode="border")
inner = ((batch["uv"] > 1 / size) & (batch["uv"] < 1 - 1 / size)).all(-1) & batch["valid"]
assert inner.sum() > 100 and (sampled.permute(0, 2, 3, 1)[inner] - batch["uv"][inner]).abs().max() < 1e-4
print(f"{len(dataset)} views read with PyTorch {torch.__version__}")
