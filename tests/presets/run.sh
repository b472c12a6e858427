#!/usr/bin/env bash
# run.sh FRESCO PIPELINES: each preset, a step at 64 px; what it reports is what its name promises.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 pipelines=$2
python=$(python_with numpy) || { skip "the presets run with random weights: no python3 with numpy is at hand"; exit 0; }

"$python" "$(dirname "$0")/random_vgg19.py" "$work/vgg19.safetensors"
# A narrow picture: its features take most of the time of a single step.
"$python" -c 'import numpy, sys; numpy.save(sys.argv[1], numpy.random.default_rng(1).integers(0, 256, (192, 64, 3), numpy.uint8))' "$work/style.npy"
for preset in "$pipelines"/presets/*.yaml; do
    name=$(basename "$preset" .yaml)
    [ "$name" != preview ] || continue
    heights=64
    grep -qE "stylemesh|fast|gpu" <<<"$name" && heights="64, 108"
    # A quarter of the heights, so four times the length that has 32 pixels.
    theta_d_m=1
    grep -q matterport3d <<<"$name" && theta_d_m=0.8
    device=""
    full="{features: {precision: full}}"
    [ "$name" != gpu ] || device="device: cpu, losses: {style: $full, content: $full}, "  # No card is at hand.
    cat >"$work/$name.yaml" <<YAML
version: 1
base: $preset
vars: {data: $work, picture: $work/style.npy, weights: $work/vgg19.safetensors}
stages:
  scan: {type: scan.synthetic_room, frames_count: 6, color_width_px: 160, color_height_px: 120, edge_m: 0.15}
  frames: {min_sharpness: 0, window_count: 1}
  mesh: {max_faces: 4000}
  atlas: {size_px: 512}
  uvmaps: {heights_px: [$heights]}
  texture: {${device}max_steps: 1, theta_d_m: $theta_d_m}
YAML
    "$fresco" run "$work/$name.yaml" --until texture --store "$work/store" --out "$work/out" --json-log >"$work/$name.log" ||
        { cat "$work/$name.log"; fail "$name"; }
done
"$python" "$(dirname "$0")/check_reports.py" "$work/store" "$work"/*.log
