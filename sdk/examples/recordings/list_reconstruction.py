"""Lists what a feed-forward network reconstructed from a video, for layout.frames: list_reconstruction.py PREDICTIONS.npz PICTURES METERS_PER_UNIT

PREDICTIONS.npz as VGGT's demo saves it: extrinsic (N x 3 x 4, camera_from_world with OpenCV's camera axes), intrinsic (N x 3 x 3), depth
(N x H x W x 1) and depth_conf (N x H x W). PICTURES has the N pictures of the video in order, uncropped, in any size. Such networks do not know
the scale: METERS_PER_UNIT is a length in the room over the same length in the reconstruction. Writes frames.json and depth into PICTURES.

MASt3R's arrays should do as well: save get_im_poses() inverted as extrinsic, its focal lengths and principal points as intrinsic, its depth maps as depth
and its confidences as depth_conf.
"""
import json
import pathlib
import struct
import sys

import numpy as np

DEPTH_UNIT_M = 0.001


def size_of(picture):
    """Width and height of a PNG or JPEG."""
    data = picture.read_bytes()
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return struct.unpack(">II", data[16:24])
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    height, width = struct.unpack(">HH", data[at + 5 : at + 9])
    return width, height


predictions, folder, scale = np.load(sys.argv[1]), pathlib.Path(sys.argv[2]), float(sys.argv[3])
pictures = sorted(file for file in folder.iterdir() if file.suffix in {".png", ".jpg", ".jpeg"})
depths, confidences = predictions["depth"].reshape(predictions["depth_conf"].shape), predictions["depth_conf"]
if len(pictures) != len(depths):
    sys.exit(f"{folder} has {len(pictures)} pictures, {sys.argv[1]} has {len(depths)} views")
# The least certain fifth is left out.
least = np.quantile(confidences, 0.2)
frames = []
for number, picture in enumerate(pictures):
    depth = np.where(confidences[number] >= least, depths[number] * scale / DEPTH_UNIT_M, 0)
    np.save(folder / f"{picture.stem}.depth.npy", np.where((depth >= 1) & (depth < 65535), np.rint(depth), 0).astype(np.uint16))
    camera_from_world = np.vstack([predictions["extrinsic"][number], [0, 0, 0, 1]]).astype(float)
    world_from_camera = np.linalg.inv(camera_from_world)
    world_from_camera[:3, 3] *= scale
    k, cameras = predictions["intrinsic"][number].astype(float), {}
    for name, (width, height) in (("color_camera", size_of(picture)), ("depth_camera", depth.shape[::-1])):
        x, y = width / depth.shape[1], height / depth.shape[0]
        cameras[name] = {"width": width, "height": height, "fx": k[0, 0] * x, "fy": k[1, 1] * y, "cx": k[0, 2] * x, "cy": k[1, 2] * y,
                         "world_from_camera": world_from_camera[:3].ravel().tolist()}
    frames.append({"sequence": "video", "name": picture.stem, "number": number, **cameras, "color_picture": {"ref": f"own:{picture.name}"},
                   "depth_picture": {"ref": f"own:{picture.stem}.depth.npy"}, "depth_unit_m": DEPTH_UNIT_M})
(folder / "frames.json").write_text(json.dumps({"frames": frames}, indent=1) + "\n")
