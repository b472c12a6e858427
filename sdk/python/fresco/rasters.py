"""Reads the packed rasters of a store, as sdk/docs/packed_rasters.md describes them. Needs NumPy and zstandard."""
from __future__ import annotations

import pathlib
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from .uv_maps import take_planes


def read_raster(path: str | pathlib.Path) -> npt.NDArray[Any]:
    """uint8, uint16 or float32: H x W, or H x W x C for several channels."""
    import zstandard  # Blender's Python lacks it, and needs no rasters.

    file = pathlib.Path(path).read_bytes()
    magic, kind, width, height, channels = struct.unpack_from("<8s4I", file)
    if magic != b"FRESCORA" or kind > 3:
        raise ValueError(f"{path}: no packed raster, or a damaged one")
    content = np.frombuffer(zstandard.ZstdDecompressor().decompress(file[24:]), np.uint8)
    size = (1, 2, 4, 1)[kind]
    planes = content.reshape(channels, -1)
    steps = np.stack([take_planes(channel, height, width, 8 * size) for channel in planes], -1).astype(f"<u{size}")
    raster: npt.NDArray[Any] = steps.view(np.float32) if kind == 2 else steps / np.float32(255) if kind == 3 else steps
    return raster[..., 0] if channels == 1 else raster
