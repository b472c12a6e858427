#!/usr/bin/env bash
# run.sh FRESCO SOURCE: a recording of one's own, listed by the example of sdk/examples/recordings, and in plain folders.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2
cd "$work"
python=$(python_with numpy, zstandard) || { skip "one's own recording: there is no python3 with numpy and zstandard"; exit 0; }

cat >made.yaml <<'YAML'
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 12, color_width_px: 160, color_height_px: 120, depth_width_px: 160, depth_height_px: 120, edge_m: 0.15}
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
  listed: {type: scan.frames, path: mine}
  plain: {type: scan.folder, path: mine}
  surface: {type: mesh.fuse, input: {frames: listed}, voxel_m: 0.05}
YAML
"$fresco" run mine.yaml --store store --out out >log 2>&1 || { cat log; fail "the recording cannot be read"; }
"$python" - <<'PY'
import json, pathlib
import numpy as np
manifests = {json.loads(m.read_text())["type"]: m.parent for m in pathlib.Path("store/objects").glob("*/manifest.json")}
read = {type_: json.loads((manifests[type_] / "frames/frames.json").read_text())["frames"] for type_ in ("scan.frames", "scan.folder")}
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
  atlas: {type: atlas.project, input: scan.mesh, size_px: 256, gutter_px: 2}
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
  listed: {type: scan.frames, path: video}
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
echo "recordings: done"
