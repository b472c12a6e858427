#!/usr/bin/env bash
# run.sh FRESCO SOURCE: every pipeline that is shipped fits the plugins: types, ports, options, ranges, results that are read; as it is, and as a preview. Files
# stand in for its inputs.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 pipelines=$2/pipelines count=0 failed=()

printf 'PK\3\4' >"$work/weights.pth"
echo 'v 0 0 0' >"$work/model.obj"
# What the presets name is one folder for all of them; the ready pipelines find out what it is.
mkdir -p "$work"/scan/{color,depth,pose,undistorted_camera_parameters} "$work/room/seq-01"
touch "$work/scan/undistorted_camera_parameters/house.conf"
room=(--set "data=$work/room") data=(--set "data=$work/scan") picture=(--set "picture=$pipelines/demo.jpg") weights=(--set "weights=$work/weights.pth")

check() { # FILE MORE…
    count=$((count + 1))
    "$fresco" check "$pipelines/$1" "${@:2}" >"$work/log" 2>&1 && grep -q "no problems$" "$work/log" || { echo "$*:"; cat "$work/log"; failed+=("$1"); }
}
ready() { check "$@"; check "$@" --preview; }

for name in demo regions sweep; do ready $name.yaml; done
for name in room large; do ready $name.yaml "${room[@]}" "${picture[@]}"; done
ready stylemesh.yaml "${room[@]}" "${picture[@]}" "${weights[@]}"
for name in photo_texture prepare; do ready $name.yaml "${room[@]}"; done
ready retexture.yaml "${room[@]}" --set "model=$work/model.obj"
touch "$work/scene.ply"
ready splat.yaml --set "splat=$work/scene.ply" "${picture[@]}"
ready model.yaml --set "model=$work/model.obj" "${picture[@]}"
# As they are, the presets and the paper's tables are checked by tests/presets/resolved.py.
for preset in "$pipelines"/presets/*.yaml; do
    name=presets/$(basename "$preset")
    [ $name = presets/preview.yaml ] || check $name --preview "${data[@]}" "${picture[@]}" "${weights[@]}"
done
check paper/frames.yaml --set "scans=$work" --set 'scene=[scan]' --set "pictures=$work"

# Without its inputs a pipeline says what to set.
! "$fresco" check "$pipelines/room.yaml" >"$work/log" 2>&1
grep -q "'data' has no value: set it with --set data=" "$work/log" || { cat "$work/log"; fail "nobody says what to set"; }
# An independent validator accepts with the schema for editors what fresco accepts, and refuses what it refuses.
if schema_python=$(python_with jsonschema, yaml); then
    "$fresco" schema --json >"$work/schema.json"
    "$schema_python" - "$work/schema.json" "$pipelines"/{,presets/,paper/}*.yaml <<'PY' || fail "the schema of pipelines"
import json, jsonschema, sys, yaml
validator = jsonschema.Draft202012Validator(json.load(open(sys.argv[1])))
for file in sys.argv[2:]:
    for error in validator.iter_errors(yaml.safe_load(open(file))):
        sys.exit(f"{file}: {error.message}")
stages = "stages: {a: {type: mesh.decimate}}\n"
for good in ["stages: {a: {type: mesh.decimate, input: {file: a.ply}, max_faces: '${n}'}}", "preview: {a: {size: 1}}",
             stages + "vars: {a: , b: }\nmatrix: {a: [1, x], b: {c: [2]}}", stages + "components: {image_io: none}",
             "stages: {a: {type: texture.optimize, losses: {s: {type: loss.gram, weight: 2}, c: loss.content}}}",
             "stages: {a: {type: texture.regions, regions: {floor: keep, '*': {texture: dark, strength: 0.5}}}}",
             "base: b.yaml\nstages: {a: {max_faces: 5}, b: }"]:
    if not validator.is_valid(yaml.safe_load("version: 1\n" + good)):
        sys.exit("refused: " + good)
for bad in ["", "stage: {}", "stages: {a: {type: mesh.decimat}}", "stages: {a: {max_faces: 5}}", stages + "preview: {a: 1}",
            "stages: {1a: {type: mesh.decimate}}", "base: b.yaml\nstages: {a: {type: mesh.decimate, max_faces: 1}}",
            *(stages + f"matrix: {matrix}" for matrix in ["[a]", "{a: []}", "{a: {}}", "{a: 1}", "{a: [1, 1]}", "{1a: [1]}"]),
            *(stages + f"components: {chosen}" for chosen in ["[]", "{image_io: loss.gram}", "{loss: loss.gram}"]),
            *(f"stages: {{a: {{type: mesh.decimate, {option}}}}}" for option in
              ["max_face: 5", "max_faces: 3", "max_faces: 1.5", "max_faces: many", "input: {meshes: b}", "input: {mesh: {file: a, x: 1}}"]),
            *(f"stages: {{a: {{type: texture.optimize, losses: {{a: {loss}}}}}}}" for loss in
              ["{type: features.vgg19}", "{type: loss.gram, wait: 1}", "{type: loss.gram, features: loss.gram}"]),
            *(f"stages: {{a: {{type: texture.regions, regions: {rules}}}}}" for rules in
              ["{}", "keep", "{floor: {texture: dark, strength: 1.5}}", "{floor: {strength: 0.5}}"])]:
    if validator.is_valid(yaml.safe_load("version: 1\n" + bad)):
        sys.exit("accepted: " + bad)
PY
else
    skip "the schema of pipelines: python3 has no jsonschema or no yaml"
fi
[ $count -gt 30 ] || fail "only $count checks: this test looks in the wrong place"
[ ${#failed[@]} -eq 0 ] || fail "${failed[*]}"
echo "$count checks of pipelines"
