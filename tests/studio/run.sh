#!/usr/bin/env bash
# run.sh FRESCO SOURCE
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2

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
YAML
"$fresco" run "$work/room.yaml" --store "$work/store" --out "$work/out" --quiet
mkdir "$work/scans"
timeout 1500 node "$source/tests/studio/studio.mjs" "$chromium" "$fresco" "$work/scans" "$work/out/room.glb" "$source/pipelines/pictures/sea_waves.jpg" "${3:-}"
