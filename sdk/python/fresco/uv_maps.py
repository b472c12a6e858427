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


def read_uv_map(path: str | pathlib.Path) -> dict[str, npt.NDArray[Any]]:
    """A dict of uv (float32 H x W x 2), depth (meters) and cosine (float32 H x W) and valid (bool H x W)."""
    import zstandard  # Blender's Python lacks it, and needs no uv maps.

    file = pathlib.Path(path).read_bytes()
    magic, form, width, height, valid_pixels, *rest = struct.unpack_from("<8s4I4Bf14I", file)
    bits, per_meter, sizes, checksum = rest[:4], np.float32(rest[4]), iter(rest[5:18]), rest[18]
    if magic != b"FRESCOUV" or form != 2 or zlib.crc32(file[:84]) != checksum:
        raise ValueError(f"{path}: no packed uv map of form 2, or a damaged one")
    at = 88

    def part() -> npt.NDArray[np.uint8]:
        nonlocal at
        begin, at = at, at + next(sizes)
        packed = file[begin:at]
        return np.frombuffer(zstandard.ZstdDecompressor().decompress(packed) if packed else b"", np.uint8)

    valid = np.unpackbits(part(), count=width * height, bitorder="little").reshape(height, width).astype(bool)
    if valid.sum() != valid_pixels:
        raise ValueError(f"{path}: the mask has not the {valid_pixels} valid pixels that are listed")

    def steps(bits: int) -> npt.NDArray[np.float32]:
        low, extra, large = part(), part(), part()
        number = low.astype(np.int64)
        if large.size:
            number[low == 255] = large[: large.size // 2] + 256 * large[large.size // 2 :].astype(np.int64)
        if extra.size:
            number = number << (bits - 16) | extra
        difference = (number >> 1) ^ -(number & 1)
        total = difference.reshape(height, width).cumsum(axis=0).cumsum(axis=1)
        return np.where(valid, total & (2**bits - 1), 0).astype(np.float32)

    u, v, cosine, depth = [steps(count) for count in bits]
    last = np.float32(2 ** bits[0] - 1)
    return {"uv": np.stack([u / last, v / last], -1), "depth": depth / per_meter, "cosine": cosine / np.float32(255), "valid": valid}


if __name__ == "__main__":
    np.savez(sys.argv[2], **read_uv_map(sys.argv[1]))
