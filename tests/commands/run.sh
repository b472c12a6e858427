#!/usr/bin/env bash
# run.sh FRESCO SOURCE: the examples of programs as stages, at a small size; what they made is read with NumPy.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2

cp -rL "$source/sdk/examples/commands" "$work/examples"
cd "$work"
small=(--set scan.frames_count=4 --set scan.color_width_px=160 --set scan.color_height_px=120 --set scan.edge_m=0.15
       --set atlas.size_px=256 --set 'uvmaps.heights_px=[120]')

# Of the interpreters at hand, one that has NumPy goes first.
if python=$(python_with numpy, zstandard); then
    mkdir bin
    ln -s "$python" bin/python3
    export PATH=$work/bin:$PATH PYTHONPATH=$source/sdk/python
else
    skip "programs as stages: no python3 with numpy and zstandard is at hand"
    exit 0
fi

objects() { # TYPE OUTPUT: the newest result's folder of that output
    python3 - "$1" "$2" <<'PY'
import json, pathlib, sys
found = [m for m in pathlib.Path("store/objects").glob("*/manifest.json") if json.loads(m.read_text())["type"] == sys.argv[1]]
print(max(found, key=lambda m: m.stat().st_mtime_ns).parent / sys.argv[2])
PY
}

"$fresco" run examples/recolor.yaml --store store --out out "${small[@]}" >log 2>&1 || { cat log; fail "recolor.yaml failed"; }
grep -q 'recolor: turned 256x256 texels by 120 degrees' log || { cat log; fail "the script's words are not shown"; }
test -s out/recolored.glb
# A turn by 120 degrees around the gray axis makes red green, green blue and blue red.
python3 - "$(objects texture.bake textured_mesh)" "$(objects command result)" "$(objects atlas.project atlas)" <<'PY'
import pathlib, sys
import numpy as np
from fresco.rasters import read_raster
before, after = (read_raster(pathlib.Path(folder) / "image.packed") for folder in sys.argv[1:3])
assert before.std() > 10 and np.abs(before[..., 0].astype(int) - before[..., 2]).max() > 20, "a gray picture shows nothing"
assert (np.roll(before, 1, axis=2) == after).all(), "the colors were not turned by a third"
meshes = [(pathlib.Path(folder) / "mesh.ply").read_bytes() for folder in sys.argv[2:]]
assert meshes[0] == meshes[1]
PY
again() { # EXPECTED ARGUMENTS…: what a plan says of the script's stage
    "$fresco" plan examples/recolor.yaml --store store "${small[@]}" "${@:2}" | grep "^recolor .*$1" >/dev/null || fail "the plan does not say: $1"
}
again stored
again 'option run was' --set turn=60
echo '# changed' >>examples/recolor.py
again 'among the files, recolor.py changed'

if command -v blender >/dev/null; then
    atlas=("${small[@]/atlas.size_px=256/size_px=256}")
    "$fresco" run examples/smart_uv.yaml --store store --out out "${atlas[@]}" >log 2>&1 || { cat log; fail "smart_uv.yaml failed"; }
    test -s out/room.glb
    python3 - "$(objects scan.synthetic_room mesh)" "$(objects command unwrapped)" <<'PY'
import pathlib, sys
sys.path.insert(0, "examples")
import fresco_ply
import numpy as np
before, after = (fresco_ply.read_mesh(pathlib.Path(folder) / "mesh.ply") for folder in sys.argv[1:])
for part in ("positions", "triangles"):
    assert (before[part] == after[part]).all(), part
uv = after["texcoords"].astype(float)
assert uv.min() >= 0 and uv.max() <= 1
a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2
assert 0.2 < area <= 1, f"{area} of the atlas is covered"
fresco_ply.write_mesh("again.ply", after)
assert pathlib.Path("again.ply").read_bytes() == (pathlib.Path(sys.argv[2]) / "mesh.ply").read_bytes()
print(f"Blender unwrapped {len(uv)} faces over {area:.0%} of the atlas")
PY
else
    skip "a room unwrapped by Blender as a stage: there is no blender"
fi
echo "commands: done"
