#!/usr/bin/env bash
# run.sh FRESCO SOURCE: a recording of one's own, listed by the examples of sdk/examples/recordings, and in plain folders; as the apps
# of phones write it; and lenses, as OpenCV has them.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2
cd "$work"
python=$(python_with numpy, zstandard) || { skip "one's own recording: there is no python3 with numpy and zstandard"; exit 0; }
export PYTHONPATH=$source/sdk/python PYTHONDONTWRITEBYTECODE=1
run() { "$fresco" run "$1.yaml" --store store --out "$1" >log 2>&1 || { cat log; fail "$1.yaml failed"; }; }

cat >made.yaml <<'YAML'
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 12, color_width_px: 160, color_height_px: 120, depth_px: [160, 120], edge_m: 0.15}
  atlas: {type: atlas.project, input: scan.mesh, size_px: 256}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [60]}
YAML
run made

# The layout of somebody: pictures, a camera and poses that another program wrote. The generated cameras of color and depth are apart,
# but one of them serves here. And what a network reconstructs from a video: another scale, camera_from_world, depth in smaller float32
# pictures.
"$python" - <<'PY'
import pathlib, shutil
import fresco
import numpy as np
made, mine, video, scale = fresco.open_results("made"), pathlib.Path("mine"), pathlib.Path("video"), 0.37
frames, maps = made.read("scan", "frames"), made.read("uvmaps")
for folder in (mine / "color", mine / "depth", video):
    folder.mkdir(parents=True)
for i, frame in enumerate(frames):
    color, depth = (made.path("scan", "frames") / frame[kind]["ref"].removeprefix("own:") for kind in ("color_picture", "depth_picture"))
    shutil.copy(color, mine / f"color/{i:03}.jpg")
    shutil.copy(depth, mine / f"depth/{i:03}.png")
    shutil.copy(color, video / f"{i:03}.jpg")
poses = [frame["depth_camera"]["world_from_camera"] for frame in frames]
for name, values in (("K", frames[0]["depth_camera"]["K"]), ("poses", poses)):
    np.save(mine / f"{name}.npy", values)
    np.savetxt(mine / f"{name}.txt", values if name == "K" else np.reshape(values, (-1, 16)))
views = [maps[i, 60] for i in range(len(frames))]
cameras = [frame["color_camera"] for frame in frames]
from_world = np.array([np.linalg.inv(camera["world_from_camera"])[:3] for camera in cameras])
from_world[:, :, 3] /= scale
half = np.diag([0.5, 0.5, 1])
np.savez("predictions.npz", extrinsic=from_world.astype(np.float32), intrinsic=np.array([half @ camera["K"] for camera in cameras], np.float32),
         depth=np.array([view["depth"] / scale for view in views], np.float32)[..., None],
         depth_conf=np.array([1 + view["valid"] * view["cosine"] for view in views], np.float32))
PY
"$python" "$source/sdk/examples/recordings/list_frames.py" mine
"$python" "$source/sdk/examples/recordings/list_reconstruction.py" predictions.npz video 0.37

cat >read.yaml <<'YAML'
version: 1
stages:
  listed: {type: scan.recording, path: mine}
  plain: {type: scan.recording, path: mine, layout: layout.folder}
  surface: {type: mesh.fuse, input: {frames: listed}, voxel_m: 0.05}
  video: {type: scan.recording, path: video}
  fused: {type: mesh.fuse, input: {frames: video}, voxel_m: 0.05}
YAML
run read
"$python" - <<'PY'
import fresco
import numpy as np
read, poses = fresco.open_results("read"), np.load("mine/poses.npy")
for stage in ("listed", "plain"):
    frames = read.read(stage, "frames")
    assert [frame["name"] for frame in frames] == [f"{i:03}" for i in range(12)], stage
    assert np.abs([frame["color_camera"]["world_from_camera"] for frame in frames] - poses).max() < 1e-9, stage
for listed, plain in zip(read.read("listed", "frames"), read.read("plain", "frames")):
    for entry in ("color_picture", "depth_picture", "depth_unit_m", "mask"):
        assert listed[entry] == plain[entry], entry
# Both surfaces are as large as the room; every tenth vertex of the video's, whose depth has no noise, lies on it.
room = fresco.open_results("made").read("scan", "mesh")["positions"]
for stage in ("surface", "fused"):
    found = read.read(stage)["positions"]
    assert len(found) > 1000, (stage, len(found))
    for corner in (np.min, np.max):
        assert np.abs(corner(room, 0) - corner(found, 0)).max() < 0.25, (stage, corner(room, 0), corner(found, 0))
far = [np.linalg.norm(room - point, axis=1).min() for point in found[::10]]
assert np.quantile(far, 0.9) < 0.1, np.quantile(far, [0.5, 0.9, 1])
PY
if schema_python=$(python_with jsonschema); then
    for file in mine/frames.json store/objects/*/frames/frames.json; do
        "$schema_python" -c 'import json, jsonschema, sys; jsonschema.validate(*(json.load(open(file)) for file in sys.argv[1:]))' \
            "$file" "$source/sdk/docs/frames.schema.json"
    done
else
    skip "the schema of frames.json: python3 has no jsonschema"
fi

if opencv_python=$(python_with numpy, zstandard, cv2); then
    "$opencv_python" "$source/tests/recordings/phones.py" write
    cat >phones.yaml <<'YAML'
version: 1
stages:
  record3d: {type: scan.recording, path: record3d}
  r3d: {type: scan.recording, path: room.r3d}
  stray_scanner: {type: scan.recording, path: stray_scanner}
  arkitscenes: {type: scan.recording, path: arkitscenes}
YAML
    run phones
    "$opencv_python" "$source/tests/recordings/phones.py" check
    "$opencv_python" "$source/tests/recordings/lenses.py" write
    cat >lenses.yaml <<'YAML'
version: 1
stages:
  colmap: {type: scan.recording, path: colmap, layout: {type: layout.colmap, depth: colmap/depth}}
  nerf: {type: scan.recording, path: nerf}
YAML
    run lenses
    "$opencv_python" "$source/tests/recordings/lenses.py" check
else
    skip "recordings of phones, and lenses: there is no python3 with cv2, numpy and zstandard"
fi
echo "recordings: done"
