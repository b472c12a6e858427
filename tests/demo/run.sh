#!/usr/bin/env bash
# run.sh FRESCO SOURCE KEPT: the results stay in KEPT/out, to be looked at.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2 kept=$3
rm -rf "$kept"
mkdir "$work/validator"
run() { "$fresco" run "$source/pipelines/demo.yaml" --store "$kept/store" --out "$kept/out" --cores 2 "$@"; }

run
test -s "$kept/out/demo.glb" || fail "no demo.glb"
views=("$kept"/out/views/*.png)
[ ${#views[@]} -gt 5 ] || fail "${#views[@]} views"

# What is stored is not run again, and a result that a user deleted comes back from the store.
sum=$(sha256sum <"$kept/out/demo.glb")
rm "$kept/out/demo.glb"
run --json-log >"$work/second.log"
! grep -q '"event":"begin"' "$work/second.log" || fail "the second run ran a stage"
[ "$sum" = "$(sha256sum <"$kept/out/demo.glb")" ] || fail "the second run wrote another demo.glb"

if command -v npm >/dev/null; then
    cp "$source"/tests/gltf_validator/* "$work/validator/"
    (cd "$work/validator" && npm install --no-audit --no-fund --loglevel=error && node validate.mjs "$kept/out/demo.glb")
else
    skip "the demo's GLB by the Khronos validator: there is no npm"
fi

# Both ways to paint without weights look like a painting of the room. Other processors round differently: hence a margin.
python=$(python_with cv2) || { skip "the figures of the demo's painting: python3-opencv is not there"; exit 0; }
painting() { "$python" "$source/pipelines/paper/painting.py" "$@"; }
"$fresco" run "$source/tests/demo/figures.yaml" --store "$kept/store" --out "$kept/figures"
painting "$kept/figures" --every 4
painting "$kept/figures" --every 4 --views optimized_views --path optimized.json
"$python" - "$kept/figures" <<'CHECK'
import json, sys

folder = sys.argv[1]
failed = []
for name, weaker in (("painting", {"coherence": 0.75}), ("optimized", {"strokes": 0.5})):
    for figure, found in json.load(open(f"{folder}/{name}.json"))["figures"].items():
        if not found["reached"] and not found["mean"] >= weaker.get(figure, float("inf")):
            failed.append(f"{name}: {figure} {found['mean']:.3f}")
sys.exit("demo: " + ", ".join(failed) if failed else 0)
CHECK
