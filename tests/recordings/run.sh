#!/usr/bin/env bash
# run.sh FRESCO SOURCE: a recording of one's own, listed by the example of sdk/examples/recordings, and in plain folders; and one of 360°
# pictures.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2
cd "$work"
python=$(python_with numpy, zstandard) || { skip "one's own recording: there is no python3 with numpy and zstandard"; exit 0; }

cat >made.yaml <<'YAML'
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 12, color_width_px: 160, color_height_px: 120, depth_px: [160, 120], edge_m: 0.15}
YAML
"$fresco" run made.yaml --store store --out out >log 2>&1 || { cat log; fail "no recording was made"; }

# The layout of somebody: pictures, a camera and poses that another program wrote. The generated cameras of color and depth are apart,
# but one of them serves here.
"$python" - store/objects/*/frames mine <<'PY'
import json, pathlib, shutil, sys
import numpy as np
made, mine = map(pathlib.Path, sys.argv[1:])
frames = json.loads((made / "frames.json").read_text())["frames"]
poses = []
for folder in ("color", "depth"):
    (mine / folder).mkdir(parents=True)
for i, frame in enumerate(frames):
    for kind, ending in (("color", "jpg"), ("depth", "png")):
        shutil.copy(made / frame[kind + "_picture"]["ref"].removeprefix("own:"), mine / kind / f"{i:03}.{ending}")
    camera = frame["depth_camera"]
    poses.append(np.vstack([np.reshape(camera["world_from_camera"], (3, 4)), [0, 0, 0, 1]]))
k = np.array([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]])
np.save(mine / "K.npy", k)
np.savetxt(mine / "K.txt", k)
np.save(mine / "poses.npy", poses)
np.savetxt(mine / "poses.txt", np.reshape(poses, (-1, 16)))
PY
"$python" "$source/sdk/examples/recordings/list_frames.py" mine

cat >mine.yaml <<'YAML'
version: 1
stages:
  listed: {type: scan.recording, path: mine}
  plain: {type: scan.recording, path: mine, layout: layout.folder}
  surface: {type: mesh.fuse, input: {frames: listed}, voxel_m: 0.05}
YAML
"$fresco" run mine.yaml --store store --out out >log 2>&1 || { cat log; fail "the recording cannot be read"; }
"$python" - <<'PY'
import json, pathlib
import numpy as np
manifests = {}
for file in pathlib.Path("store/objects").glob("*/manifest.json"):
    made = json.loads(file.read_text())
    # Of a recording: the layout that it was read by.
    manifests[made["options"].get("layout", {"type": made["type"]})["type"]] = file.parent
read = {type_: json.loads((manifests[type_] / "frames/frames.json").read_text())["frames"] for type_ in ("layout.frames", "layout.folder")}
poses = np.load("mine/poses.npy")
for type_, frames in read.items():
    assert [frame["name"] for frame in frames] == [f"{i:03}" for i in range(12)], type_
    for frame, pose in zip(frames, poses):
        assert np.abs(np.reshape(frame["color_camera"]["world_from_camera"], (3, 4)) - pose[:3]).max() < 1e-9, type_
for listed, plain in zip(*read.values()):
    for entry in ("color_picture", "depth_picture", "depth_unit_m", "mask"):
        assert listed[entry] == plain[entry], entry
faces = (manifests["mesh.fuse"] / "mesh/mesh.ply").read_bytes().split(b"element face ")[1].split(b"\n")[0]
assert int(faces) > 1000, faces
PY
if schema_python=$(python_with jsonschema); then
    for file in mine/frames.json store/objects/*/frames/frames.json; do
        "$schema_python" -c 'import json, jsonschema, sys; jsonschema.validate(*(json.load(open(file)) for file in sys.argv[1:]))' \
            "$file" "$source/sdk/docs/frames.schema.json"
    done
else
    skip "the schema of frames.json: python3 has no jsonschema"
fi

# A mirrored pose is noticed, and named.
"$python" - <<'PY'
import json, pathlib
file = pathlib.Path("mine/frames.json")
listed = json.loads(file.read_text())
pose = listed["frames"][7]["color_camera"]["world_from_camera"]
for i in (0, 4, 8):
    pose[i] = -pose[i]
file.write_text(json.dumps(listed))
lines = pathlib.Path("mine/poses.txt").read_text().splitlines()
numbers = [float(word) for word in lines[7].split()]
lines[7] = " ".join(str(-number if i in (0, 4, 8) else number) for i, number in enumerate(numbers))
pathlib.Path("mine/poses.txt").write_text("\n".join(lines) + "\n")
PY
refused() { # STAGE TEXT
    ! "$fresco" run mine.yaml --until "$1" --store store --out out >log 2>&1 || fail "$1: a mirrored pose was read"
    tr -d '\n' <log | tr -s ' ' | grep -q "$2" || { cat log; fail "$1: the mirrored pose is not named"; }
}
refused listed 'mine/frames.json: frames\[7\].color_camera: the pose'
refused plain 'mine/poses.txt:8: '

# What a network reconstructs from a video: another scale, camera_from_world, depth in smaller float32 pictures. Its mesh is that of the room.
cat >video.yaml <<'YAML'
version: 1
base: made.yaml
stages:
  atlas: {type: atlas.project, input: scan.mesh, size_px: 256}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [60]}
YAML
"$fresco" run video.yaml --store store --out made >log 2>&1 || { cat log; fail "video.yaml failed"; }
PYTHONPATH=$source/sdk/python "$python" - video <<'PY'
import pathlib, shutil, sys
import fresco
import numpy as np
video = pathlib.Path(sys.argv[1])
video.mkdir()
made, scale = fresco.open_results("made"), 0.37
frames, maps = made.read("scan", "frames"), made.read("uvmaps")
views = [maps[i, 60] for i in range(len(frames))]
for i, frame in enumerate(frames):
    shutil.copy(made.path("scan", "frames") / frame["color_picture"]["ref"].removeprefix("own:"), video / f"{i:03}.jpg")
cameras = [frame["color_camera"] for frame in frames]
from_world = np.array([np.linalg.inv(camera["world_from_camera"])[:3] for camera in cameras])
from_world[:, :, 3] /= scale
half = np.diag([0.5, 0.5, 1])
np.savez("predictions.npz", extrinsic=from_world.astype(np.float32), intrinsic=np.array([half @ camera["K"] for camera in cameras], np.float32),
         depth=np.array([view["depth"] / scale for view in views], np.float32)[..., None],
         depth_conf=np.array([1 + view["valid"] * view["cosine"] for view in views], np.float32))
PY
"$python" "$source/sdk/examples/recordings/list_reconstruction.py" predictions.npz video 0.37
cat >fused.yaml <<'YAML'
version: 1
stages:
  listed: {type: scan.recording, path: video}
  surface: {type: mesh.fuse, input: {frames: listed}, voxel_m: 0.05}
YAML
"$fresco" run fused.yaml --store store --out fused >log 2>&1 || { cat log; fail "the reconstruction cannot be fused"; }
PYTHONPATH=$source/sdk/python "$python" - <<'PY'
import fresco
import numpy as np
room, fused = fresco.open_results("made").read("scan", "mesh")["positions"], fresco.open_results("fused").read("surface")["positions"]
assert len(fused) > 1000, len(fused)
for corner in (np.min, np.max):
    assert np.abs(corner(room, 0) - corner(fused, 0)).max() < 0.25, (corner(room, 0), corner(fused, 0))
# Every tenth vertex lies on the room.
far = [np.linalg.norm(room - point, axis=1).min() for point in fused[::10]]
assert np.quantile(far, 0.9) < 0.1, np.quantile(far, [0.5, 0.9, 1])
PY
# 360° pictures of a box of 4 x 3 x 2.5 m, with distances: the surface made of them is the box, and depth and pictures agree.
"$python" - sphere <<'PY'
import json, pathlib, struct, sys, zlib
import numpy as np
sphere, size = pathlib.Path(sys.argv[1]), np.array([4, 3, 2.5])
(sphere / "images").mkdir(parents=True)
(sphere / "depth").mkdir()
def write_png(file, picture):
    height, width = picture.shape[:2]
    rows = np.frombuffer(picture.astype(picture.dtype.newbyteorder(">")).tobytes(), np.uint8).reshape(height, -1)
    kind = (8, 2) if picture.ndim == 3 else (16, 0)
    data = zlib.compress(np.pad(rows, ((0, 0), (1, 0))).tobytes())
    file.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in ((b"IHDR", struct.pack(">IIBBBBB", width, height, *kind, 0, 0, 0)), (b"IDAT", data), (b"IEND", b""))))
height, frames = 128, []
azimuth, elevation = np.meshgrid(((np.arange(2 * height) + 0.5) / height - 1) * np.pi, (0.5 - (np.arange(height) + 0.5) / height) * np.pi)
# OpenGL's axes: the middle is at -z, up is y.
rays = np.stack([np.cos(elevation) * np.sin(azimuth), np.sin(elevation), -np.cos(elevation) * np.cos(azimuth)], -1)
for i in range(8):
    yaw, tilt, at = 0.8 * i, 0.1 * np.sin(i), np.array([2 + np.cos(i), 1.5 + 0.7 * np.sin(i), 1.3])
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    pose = turn @ np.array([[1, 0, 0], [0, np.sin(tilt), -np.cos(tilt)], [0, np.cos(tilt), np.sin(tilt)]])
    d = rays @ pose.T
    distance = (np.where(d > 0, size - at, -at) / d).min(-1)
    point = at + d * distance[..., None]
    color = 128 + 60 * np.sin(3 * point) * np.cos(2 * point[..., [1, 2, 0]]) + 40 * (np.floor(2 * point).sum(-1, keepdims=True) % 2)
    write_png(sphere / f"images/{i}.png", color.astype(np.uint8))
    write_png(sphere / f"depth/{i}.png", np.rint(1000 * distance).astype(np.uint16))
    frames.append({"file_path": f"images/{i}.png", "depth_file_path": f"depth/{i}.png",
                   "transform_matrix": np.vstack([np.c_[pose, at], [0, 0, 0, 1]]).tolist()})
(sphere / "transforms.json").write_text(json.dumps({"camera_model": "EQUIRECTANGULAR", "w": 2 * height, "h": height, "frames": frames}))
PY
cat >sphere.yaml <<'YAML'
version: 1
stages:
  scan: {type: scan.recording, path: sphere}
  surface: {type: mesh.fuse, input: {frames: scan}, voxel_m: 0.05}
  inspect: {type: scan.inspect, input: {frames: scan}, fail: true}
YAML
"$fresco" run sphere.yaml --store store --out sphere_out >log 2>&1 || { cat log; fail "the 360° recording cannot be read"; }
grep -q "the frames agree with each other" log || { cat log; fail "the views of the 360° pictures do not agree"; }
PYTHONPATH=$source/sdk/python "$python" - <<'PY'
import fresco
import numpy as np
made, size = fresco.open_results("sphere_out"), np.array([4, 3, 2.5])
assert len(made.read("scan", "frames")) == 48
surface = made.read("surface")["positions"]
distances = np.concatenate([np.abs(surface), np.abs(surface - size)], 1)
off = distances.min(1)
# Its edges are rounded by a voxel.
assert np.quantile(off, 0.9) < 0.01 and off.max() < 0.08, np.quantile(off, [0.5, 0.9, 0.99, 1])
# All six sides are there.
assert ((distances < 0.02).sum(0) > 500).all(), (distances < 0.02).sum(0)
PY
echo "recordings: done"
