#!/usr/bin/env python3
"""compare.py FOLDER: for every .uvmap the package gives the values of the NPY file next to it, and it refuses damaged ones."""
import pathlib
import sys

import numpy as np
import zstandard
from fresco.uv_maps import read_uv_map

files = sorted(pathlib.Path(sys.argv[1]).glob("*.uvmap"))
assert len(files) >= 30
for file in files:
    read = read_uv_map(file)
    assert set(read) == {"uv", "depth", "cosine", "valid"}
    for name, values in read.items():
        expected = np.load(file.with_suffix(f".{name}.npy"))
        assert values.dtype == (bool if name == "valid" else np.float32), (file, name, values.dtype)
        assert values.shape == expected.shape and (values == expected).all(), (file, name)

whole = files[0].read_bytes()
damaged = files[0].with_suffix(".damaged")
for offset in range(0, len(whole), 7):
    damaged.write_bytes(whole[:offset] + bytes([whole[offset] ^ 16]) + whole[offset + 1 :])
    try:
        read = read_uv_map(damaged)
    except (ValueError, zstandard.ZstdError):
        continue
    assert all((values == np.load(files[0].with_suffix(f".{name}.npy"))).all() for name, values in read.items()), offset
print(f"{len(files)} packed uv maps read with NumPy")
