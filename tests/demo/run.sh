#!/usr/bin/env bash
# run.sh FRESCO SOURCE WORK: the results stay in WORK/out, to be looked at.
set -euo pipefail
fresco=$1 source=$2 work=$3
rm -rf "$work"
mkdir -p "$work/validator"
export XDG_DATA_HOME=$work/data
unset FRESCO_PLUGIN_PATH
run() { "$fresco" run "$source/pipelines/demo.yaml" --store "$work/store" --out "$work/out" --cores 2 "$@"; }
fail() { echo "demo: $*" >&2; exit 1; }

begin=$(date +%s%N)
run
echo "first run: $((($(date +%s%N) - begin) / 1000000)) ms"
test -s "$work/out/demo.glb" || fail "no demo.glb"
views=("$work"/out/views/*.png)
[ ${#views[@]} -gt 5 ] || fail "${#views[@]} views"

# What is stored is not run again, and a result that a user deleted comes back from the store.
sum=$(sha256sum <"$work/out/demo.glb")
rm "$work/out/demo.glb"
begin=$(date +%s%N)
run --json-log >"$work/second.log"
elapsed=$((($(date +%s%N) - begin) / 1000000))
echo "second run: $elapsed ms"
! grep -q '"event":"begin"' "$work/second.log" || fail "the second run ran a stage"
[ "$sum" = "$(sha256sum <"$work/out/demo.glb")" ] || fail "the second run wrote another demo.glb"

cp "$source"/tests/gltf_validator/* "$work/validator/"
(cd "$work/validator" && npm install --no-audit --no-fund --loglevel=error && node validate.mjs "$work/out/demo.glb")

# Both ways to paint without weights look like a painting of the room. Other processors round differently: hence a margin.
python=/usr/bin/python3
"$python" -c "import cv2" 2>/dev/null || {
    echo "SKIPPED the figures of the demo's painting: python3-opencv is not there"
    [ -z "${FRESCO_SKIP_LOG:-}" ] || echo "the figures of the demo's painting: python3-opencv is not there" >>"$FRESCO_SKIP_LOG"
    exit 0
}
painting() { "$python" "$source/pipelines/paper/painting.py" "$@"; }
"$fresco" run "$source/tests/demo/figures.yaml" --store "$work/store" --out "$work/figures"
painting "$work/figures" --every 4
painting "$work/figures" --every 4 --views optimized_views --path optimized.json
"$python" - "$work/figures" <<'CHECK'
import json, sys

folder = sys.argv[1]
failed = []
for name, weaker in (("painting", {"coherence": 0.75}), ("optimized", {"strokes": 0.5})):
    for figure, found in json.load(open(f"{folder}/{name}.json"))["figures"].items():
        if not found["reached"] and not found["mean"] >= weaker.get(figure, float("inf")):
            failed.append(f"{name}: {figure} {found['mean']:.3f}")
sys.exit("demo: " + ", ".join(failed) if failed else 0)
CHECK

# A preview leaves the full run's results alone, and is a smaller room.
sum=$(sha256sum <"$work/out/demo.glb")
begin=$(date +%s%N)
(cd "$work" && "$fresco" run "$source/tests/demo/strength.yaml" --preview --store store --cores 2)
echo "three strengths of the preview: $((($(date +%s%N) - begin) / 1000000)) ms"
[ "$sum" = "$(sha256sum <"$work/out/demo.glb")" ] || fail "the preview changed demo.glb"
for folder in "$work"/out/preview/share=*; do painting "$folder"; done
"$python" - "$work/out/preview" <<'CHECK'
import json, pathlib, sys

folders = sorted(pathlib.Path(sys.argv[1]).glob("share=*"), key=lambda folder: float(folder.name[6:]))
figures = [json.loads((folder / "painting.json").read_text())["figures"] for folder in folders]
assert len(figures) == 3 and (folders[0] / "demo.glb").stat().st_size > 0
failed = []
for name in ("off_palette", "edges"):
    found = [round(figure[name]["mean"], 3) for figure in figures]
    print(f"{name} by strength: {found}")
    if found != sorted(found, reverse=True):
        failed.append(f"{name} does not fall with the strength")
sys.exit("demo: " + ", ".join(failed) if failed else 0)
CHECK
