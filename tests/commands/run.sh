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

"$fresco" run examples/recolor.yaml --store store --out out "${small[@]}" >log 2>&1 || { cat log; fail "recolor.yaml failed"; }
grep -q 'recolor: turned 256x256 texels by 120 degrees' log || { cat log; fail "the script's words are not shown"; }
test -s out/recolored.glb
# A turn by 120 degrees around the gray axis makes red green, green blue and blue red.
python3 - <<'PY'
import fresco
import numpy as np
made = fresco.open_results("out")
before, after = (made.read(stage)["image"] for stage in ("bake", "recolor"))
assert before.std() > 10 and np.abs(before[..., 0].astype(int) - before[..., 2]).max() > 20, "a gray picture shows nothing"
assert (np.roll(before, 1, axis=2) == after).all(), "the colors were not turned by a third"
assert (made.path("recolor") / "mesh.ply").read_bytes() == (made.path("atlas") / "mesh.ply").read_bytes()
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
    python3 - <<'PY'
import pathlib
import fresco
import numpy as np
made = fresco.open_results("out")
before, after = made.read("scan", "mesh"), made.read("atlas")
for part in ("positions", "triangles"):
    assert (before[part] == after[part]).all(), part
uv = after["texcoords"].astype(float)
assert uv.min() >= 0 and uv.max() <= 1
a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2
assert 0.2 < area <= 1, f"{area} of the atlas is covered"
fresco.ply.write_mesh("again.ply", after)
assert pathlib.Path("again.ply").read_bytes() == (made.path("atlas") / "mesh.ply").read_bytes()
print(f"Blender unwrapped {len(uv)} faces over {area:.0%} of the atlas")
PY
else
    skip "a room unwrapped by Blender as a stage: there is no blender"
fi
echo "commands: done"
