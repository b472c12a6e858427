#!/usr/bin/env bash
# one_step.sh FRESCO PIPELINES: the first step of the preset of the paper, computed once more with NumPy.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 pipelines=$2
python=$(python_with numpy) || { skip "a step of the optimization computed once more: no python3 with numpy is at hand"; exit 0; }

"$python" "$(dirname "$0")/random_vgg19.py" "$work/vgg19.safetensors" raw
cat >"$work/step.yaml" <<YAML
version: 1
base: $pipelines/presets/stylemesh-scannet.yaml
vars: {data: $work, weights: $work/vgg19.safetensors}
stages:
  scan: {type: scan.synthetic_room, length_m: 8, frames_count: 5, color_width_px: 160, color_height_px: 120, edge_m: 0.15}
  frames: {min_sharpness: 0, max_frames: 1}
  mesh: {max_faces: 4000}
  atlas: {size_px: 256}
  uvmaps: {heights_px: [44, 70, 102]}
  pattern: {type: picture.pattern, size_px: 288}
  dataset: {type: dataset.write, input: {uvmaps: uvmaps, frames: frames, mesh: atlas, style: pattern}}
  texture:
    input: {style: pattern}
    theta_d_m: 1.6
    init: noise
    seed: 1
    max_steps: 1
    optimizer: {epsilon: 1}
YAML
step() { "$fresco" run "$work/step.yaml" --store "$work/store" --out "$work/out" --json-log "$@"; }
step --until dataset >"$work/dataset.log" || { cat "$work/dataset.log"; fail "the dataset"; }
for rate in 0 1000; do
    step --until texture --set texture.rate=$rate >"$work/rate_$rate.log" || { cat "$work/rate_$rate.log"; fail "rate $rate"; }
done
"$python" "$(dirname "$0")/one_step.py" "$work/store" "$work/out/dataset" "$work/vgg19.safetensors" "$work"/rate_{0,1000}.log ||
    fail "the first step is not the paper's"
