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

# It looks like a painting of the room. Other processors round differently: hence a margin.
python=$(python_with cv2) || { skip "the figures of the demo's painting: python3-opencv is not there"; exit 0; }
"$fresco" run "$source/tests/demo/figures.yaml" --store "$kept/store" --out "$kept/figures"
"$python" "$source/pipelines/paper/painting.py" "$kept/figures" --every 4
"$python" - "$kept/figures" <<'CHECK'
import json, sys

folder = sys.argv[1]
figures = json.load(open(f"{folder}/painting.json"))["figures"]
failed = [f"{figure} {found['mean']:.3f}" for figure, found in figures.items()
          if not found["reached"] and not (figure == "coherence" and found["mean"] >= 0.75)]
sys.exit("demo: " + ", ".join(failed) if failed else 0)
CHECK
