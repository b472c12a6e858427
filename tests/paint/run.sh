#!/usr/bin/env bash
# run.sh FRESCO SOURCE: `fresco paint` from a recording, and from a model, to a painted room, as a user would call it.
source "$(dirname "$0")/../program_test.sh"
fresco=$(realpath "$1") pictures=$2/pipelines/pictures
cd "$work"

cat >made.yaml <<'YAML'
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 8, color_width_px: 160, color_height_px: 120, depth_px: [160, 120], edge_m: 0.15}
  atlas: {type: atlas.project, input: scan.mesh, size_px: 256}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [60]}
  dataset: {type: dataset.write, input: {uvmaps: uvmaps, frames: scan.frames, mesh: atlas}, path: my scan, pictures: true}
  glb: {type: export.gltf, input: {mesh: scan.mesh}, path: room.glb}
YAML
"$fresco" run made.yaml --out made --quiet

# Quick, whatever the picture: wide strokes and few texels.
coarse=(--stroke-cm 25 --set texture.levels_count=1 --set texture.rounds_count=1 --set texture.detail=0)
paint() { "$fresco" paint "$@" >log 2>&1 || { cat log; fail "fresco paint $*"; }; }
is_glb() { [ "$(head -c 4 "$1")" = glTF ] || { cat log; fail "$1 is no GLB"; }; }

paint "made/my scan" "$pictures/sea_waves.jpg" "${coarse[@]}" --size 256 --strength 0.7 --keep floor --with page
is_glb "out/my scan-sea_waves/room.glb"
[ -s "out/my scan-sea_waves/room.html" ] || fail "--with page wrote none"
[ -n "$(ls "out/my scan-sea_waves/views")" ] || fail "no views"
! ls "out/my scan-sea_waves/"*.mp4 2>/dev/null || fail "a video that nobody wanted"
# What it says runs the same again, and finds everything stored.
again=$(sed -n 's/.* written; again: //p' log)
[[ $again == *"run 'out/my scan-sea_waves/room.yaml' --out 'out/my scan-sea_waves' --set "* ]] || fail "again: $again"
eval "$again" >log 2>&1 || { cat log; fail "$again"; }
! grep -q ': done in' log || { cat log; fail "the same was painted twice"; }
# The events of the run lie beside its results, the last one last.
tail -n 1 "out/my scan-sea_waves/progress.jsonl" | grep -q '"event":"summary".*"exit_code":0' || { tail -n 2 out/*/progress.jsonl; fail "no summary in progress.jsonl"; }

# Several pictures: the scan is prepared once, and a sheet shows the room after each.
paint "made/my scan" "$pictures/sea_waves.jpg" "$pictures/ember_sky.jpg" "${coarse[@]}" --preview
for picture in sea_waves ember_sky; do is_glb "out/my scan/preview/$picture/room.glb"; done
[ "$(grep -c '"own_name":"scan"' "out/my scan/preview/sweep.json")" = 1 ] || fail "the scan was read more than once"
[ "$(head -c 3 "out/my scan/preview/sheet.jpg" | od -An -tx1 | tr -d ' ')" = ffd8ff ] || fail "no sheet"
grep -q "sheet.jpg$" log || fail "nobody says where the sheet is"
# The page shows the pictures that were painted after beside the results.
[ "$(grep -o '"port":"style","artifact":"image","file":"[^"]*"' "out/my scan/preview/sweep.html" | sort -u | wc -l)" -ge 2 ] || fail "the page does not show the style pictures"

# A model keeps its file.
paint made/room.glb "$pictures/blue_mosaic.jpg" "${coarse[@]}" --size 256 --out painted
is_glb painted/room.glb
grep -q 'base: model.yaml' painted/room.yaml || fail "the model was taken for something else"

# The program is a command of fresco's: in its help, its manual and its completion.
"$fresco" --help >help; grep -q 'Programs, as commands:.*paint' help || fail "not in fresco --help"
"$fresco" internal-manual >manual; grep -q 'stroke.*cm' manual || fail "not in the manual"
"$fresco" internal-complete 3 -- fresco paint scan --str >words; grep -qx -- --strength words || fail "no completion"
