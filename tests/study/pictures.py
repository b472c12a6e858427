#!/usr/bin/env python3
"""pictures.py FOLDER: six views by each of the methods alpha and beta, as PNG: bands that differ by view and method."""
import pathlib
import struct
import sys
import zlib

WIDTH, HEIGHT = 160, 120


def png(pixel):
    rows = b"".join(b"\0" + bytes(v for x in range(WIDTH) for v in pixel(x, y)) for y in range(HEIGHT))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", WIDTH, HEIGHT, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


for number, method in enumerate(["alpha", "beta"]):
    folder = pathlib.Path(sys.argv[1]) / method
    folder.mkdir(parents=True)
    for view in range(6):
        band = 8 + 8 * number
        picture = png(lambda x, y: (255 * ((x + y) // band % 2), 40 * view, 200 - 100 * number))
        (folder / f"seq-01_frame-{view:06d}.png").write_bytes(picture)
