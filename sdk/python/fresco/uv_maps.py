#!/usr/bin/env python3
"""Reads the packed uv maps of a store, as sdk/docs/uv_maps.md describes them. Needs only NumPy and zstandard.

    uv_maps.py FILE.uvmap OUT.npz      the map's uv, depth, cosine and valid as arrays
"""
from __future__ import annotations

import pathlib
import struct
import sys
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt


def take_planes(content: npt.NDArray[np.uint8], height: int, width: int, bits: int) -> npt.NDArray[np.int64]:
    """The steps, height x width, whose differences lie at the beginning of `content` as planes of bytes."""
    pixels = height * width
    number = np.zeros(pixels, np.int64)
    for plane in range((bits + 7) // 8):
        number |= content[plane * pixels : (plane + 1) * pixels].astype(np.int64) << 8 * plane
    difference = (number >> 1) ^ -(number & 1)
    steps: npt.NDArray[np.int64] = difference.reshape(height, width).cumsum(axis=0).cumsum(axis=1) & (2**bits - 1)
    return steps


def read_uv_map(path: str | pathlib.Path) -> dict[str, npt.NDArray[Any]]:
    """A dict of uv (float32 H x W x 2), depth (meters) and cosine (float32 H x W) and valid (bool H x W)."""
    import zstandard  # Blender's Python lacks it, and needs no uv maps.

    file = pathlib.Path(path).read_bytes()
    magic, form, width, height, uv_bits, depth_bits, per_meter, checksum = struct.unpack_from("<8s5IfI", file)
    if magic != b"FRESCOUV" or form != 3 or zlib.crc32(file[:32]) != checksum:
        raise ValueError(f"{path}: no packed uv map of form 3, or a damaged one")
    content = np.frombuffer(zstandard.ZstdDecompressor().decompress(file[36:]), np.uint8)
    pixels = width * height
    at = (pixels + 7) // 8
    valid = np.unpackbits(content[:at], count=pixels, bitorder="little").reshape(height, width).astype(bool)

    def steps(bits: int) -> npt.NDArray[np.float32]:
        nonlocal at
        taken = take_planes(content[at:], height, width, bits)
        at += pixels * ((bits + 7) // 8)
        return np.where(valid, taken, 0).astype(np.float32)

    u, v, cosine, depth = steps(uv_bits), steps(uv_bits), steps(8), steps(depth_bits)
    last = np.float32(2**uv_bits - 1)
    return {"uv": np.stack([u / last, v / last], -1), "depth": depth / np.float32(per_meter), "cosine": cosine / np.float32(255), "valid": valid}


if __name__ == "__main__":
    arrays: dict[str, Any] = read_uv_map(sys.argv[1])
    np.savez(sys.argv[2], **arrays)
