#!/usr/bin/env bash
# run.sh CMAKE BUILD SOURCE torch|plain: install to a fresh prefix, build every example against it, run a pipeline with them.
source "$(dirname "$0")/../program_test.sh"
cmake=$1 build=$2 source=$3 torch=$4

"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
examples=(mirror_stage point_cloud save_picture)
[ "$torch" = plain ] || examples+=(loss_smooth)
for example in "${examples[@]}"; do
    cp -r "$source/sdk/examples/$example" "$work/$example"
    "$cmake" -S "$work/$example" -B "$work/$example/build" -G Ninja -DCMAKE_CXX_FLAGS_RELEASE=-O0 -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    "$cmake" --build "$work/$example/build" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    [ ! -e "$work/$example/build/CTestTestfile.cmake" ] || ctest --test-dir "$work/$example/build" --no-tests=error --output-on-failure >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
    FRESCO_PLUGIN_PATH=${FRESCO_PLUGIN_PATH:-}:$work/$example/build
done
export FRESCO_PLUGIN_PATH=${FRESCO_PLUGIN_PATH#:}
fresco=$work/prefix/bin/fresco
"$fresco" stages --all
"$fresco" describe example.mirror | grep -q axis

cat >"$work/quad.obj" <<'OBJ'
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 3
f 1 2 3
f 1 3 4
OBJ
cat >"$work/points.yaml" <<'YAML'
version: 1
stages:
  mirror: {type: example.mirror, input: {file: quad.obj}, axis: z}
  points: {type: example.sample_points, input: mirror}
  bounds: {type: example.point_bounds, input: points}
YAML
"$fresco" run "$work/points.yaml" --store "$work/store" --out "$work/out"
# Centers of the two faces of the mirrored quad, by hand: z = -(1+1+1)/3 and -(1+1+3)/3.
python3 - "$work/out/bounds.json" <<'PY'
import json, sys
box = json.load(open(sys.argv[1]))
expected = {"min": [1 / 3, 1 / 3, -5 / 3], "max": [2 / 3, 2 / 3, -1]}
for key, point in expected.items():
    assert all(abs(a - b) < 1e-6 for a, b in zip(box[key], point)), box
PY

if [ "$torch" = torch ]; then
    # The loss in the paper's preset: depth levels and gradient scaling reach it, though it knows nothing of them.
    cat >"$work/stylemesh.yaml" <<YAML
version: 1
base: $source/pipelines/presets/stylemesh-scannet.yaml
stages:
  scan: {type: scan.synthetic_room, frames_count: 4, color_width_px: 160, color_height_px: 120, edge_m: 0.15}
  frames: {min_sharpness: 0, window_count: 1}
  mesh: {max_faces: 20000}
  atlas: {size_px: 128}
  uvmaps: {heights_px: [32, 64]}
  texture:
    input: {style: {file: $source/tests/picture.npy}}
    epochs: 1
    init: frames
    max_steps: 20
    theta_d_m: 1
    losses: {style: {type: example.smooth, weight: 1}, content: }
  views:
YAML
    painted() { # NAME [--set …]: the room painted so, in out/NAME/room.glb
        "$fresco" run "$work/stylemesh.yaml" --store "$work/store" --out "$work/out/$1" "${@:2}"
    }
    painted whole
    painted flat --set texture.depth_levels=false
    painted unscaled --set texture.gradient_scaling=level
    for other in flat unscaled; do
        ! cmp -s "$work/out/whole/room.glb" "$work/out/$other/room.glb" ||
            fail "depth levels and gradient scaling make no difference to a loss from outside: $other"
    done
fi
echo "examples: built against the installed SDK and run"
