#!/usr/bin/env bash
# run.sh FRESCO SOURCE [SCREENSHOTS]
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2 screenshots=${3:-}

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
[ -n "$chromium" ] || { skip "fresco studio in a browser: there is no chromium"; exit 0; }

cat >"$work/room.yaml" <<YAML
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 6, color_width_px: 160, color_height_px: 120, depth_px: [80, 60], edge_m: 0.08}
  atlas: {type: atlas.project, input: scan.mesh, size_px: 512}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [120]}
  texture: {type: texture.from_frames, input: {uvmaps: uvmaps, frames: scan.frames}}
  bake: {type: texture.bake, input: {texture: texture, mesh: atlas}}
  glb: {type: export.gltf, input: {textured_mesh: bake, frames: scan}, path: room.glb}
  dataset: {type: dataset.write, input: {uvmaps: uvmaps, frames: scan.frames, mesh: atlas}, path: room, pictures: true}
YAML
"$fresco" run "$work/room.yaml" --store "$work/store" --out "$work/out" --quiet
mkdir "$work/scans"
timeout 1500 node "$source/tests/studio/studio.mjs" "$chromium" "$fresco" "$work/scans" "$work/out/room.glb" "$source/pipelines/pictures/sea_waves.jpg" "$screenshots"

if ! "$fresco" describe texture.optimize >/dev/null 2>&1; then
    skip "StyleMesh in fresco studio: texture.optimize is not built"
elif ! python=$(python_with numpy); then
    skip "StyleMesh in fresco studio: no python3 with numpy makes random weights"
else
    "$python" "$source/tests/presets/random_vgg19.py" "$work/vgg19.safetensors"
    "$fresco" weights convert "$work/vgg19.safetensors" "$work/shallow.safetensors" --until relu3_1
    mkdir "$work/recordings"
    cp -r "$work/out/room" "$work/recordings/room"
    timeout 1500 node "$source/tests/studio/stylemesh.mjs" "$chromium" "$fresco" "$work/recordings" "$work/shallow.safetensors" "$work/vgg19.safetensors" "$screenshots"
fi

cp "$source"/tests/gltf_validator/* "$work/"
(cd "$work" && npm install --no-audit --no-fund --loglevel=error && node validate.mjs saved-*/*.glb)
