"""Lists a recording for layout.frames: list_frames.py FOLDER, which has color/*.jpg, depth/*.png (millimeters), K.npy (3 x 3) and
poses.npy (N x 4 x 4, world_from_camera with OpenCV's camera axes, meters), all pictures of 160 x 120 pixels."""
import json
import pathlib
import sys

import numpy as np

folder = pathlib.Path(sys.argv[1])
k, poses, frames = np.load(folder / "K.npy"), np.load(folder / "poses.npy"), []
for number, color in enumerate(sorted((folder / "color").glob("*.jpg"))):
    camera = {"width": 160, "height": 120, "fx": k[0, 0], "fy": k[1, 1], "cx": k[0, 2], "cy": k[1, 2]}
    camera["world_from_camera"] = poses[number, :3].ravel().tolist()
    frames.append({"sequence": "scan", "name": color.stem, "number": number, "color_camera": camera, "depth_camera": camera,
                   "color_picture": {"ref": f"own:color/{color.name}"},
                   "depth_picture": {"ref": f"own:depth/{color.stem}.png"}, "depth_unit_m": 0.001})
(folder / "frames.json").write_text(json.dumps({"frames": frames}, indent=1) + "\n")
