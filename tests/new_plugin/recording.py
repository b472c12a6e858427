#!/usr/bin/env python3
"""recording.py FOLDER: three views of a wall 2 m away, in the layout of the template of `fresco new layout`."""
import json
import pathlib
import struct
import sys
import zlib

folder = pathlib.Path(sys.argv[1])
width, height, views = 64, 48, 3


def write_png(file, bits, color_type, row):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row(y) for y in range(height))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color_type, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


for i in range(views):
    write_png(folder / f"color/{i:06}.png", 8, 2, lambda y: bytes(c for x in range(width) for c in (3 * x + 9 * i, 5 * y, 90)))
    write_png(folder / f"depth/{i:06}.png", 16, 0, lambda y: struct.pack(f">{width}H", *[2000] * width))
poses = [[1, 0, 0, 0.3 * i, 0, 1, 0, 0, 0, 0, 1, 0] for i in range(views)]
(folder / "cameras.json").write_text(json.dumps({"width": width, "height": height, "fx": 50, "fy": 50, "cx": width / 2, "cy": height / 2,
                                                 "world_from_camera": poses}))
