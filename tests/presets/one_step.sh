#!/usr/bin/env bash
# one_step.sh FRESCO PIPELINES: the first step of the presets of the paper and of the released code, computed once more with PyTorch.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 pipelines=$2
python=$(python_with numpy, zstandard, cv2, torch) ||
    { skip "a step of the optimization computed once more: no python3 with numpy, zstandard, OpenCV and PyTorch"; exit 0; }
export PYTHONPATH=$pipelines/../sdk/python PYTHONDONTWRITEBYTECODE=1

"$python" "$(dirname "$0")/random_vgg19.py" "$work/vgg19.safetensors" raw
"$python" -c "import cv2, numpy
numpy.save('$work/picture.npy', cv2.resize(cv2.imread('$pipelines/pictures/night_sky.jpg'), (288, 288), interpolation=cv2.INTER_AREA)[..., ::-1])"
step() { "$fresco" run "$work/$1.yaml" --store "$work/store" --out "$work/out/$1" --json-log "${@:2}"; }
for protocol in paper released; do
    preset=stylemesh-scannet more= rate=1000
    # The lookup at corners, which begins only with zeros, has a test of its own. A hundredth of the losses, so that the step clamps few texels.
    [ $protocol = paper ] || preset=stylemesh-released-scannet rate=30 more="texture: {lookup: centers}, lambda_r: 50,
    losses: {style: {weight: 1.0e-6}, content: {weight: 0.7}}, "
    cat >"$work/$protocol.yaml" <<YAML
version: 1
base: $pipelines/presets/$preset.yaml
vars: {data: $work, weights: $work/vgg19.safetensors}
stages:
  scan: {type: scan.synthetic_room, size_m: [8, 3.6, 2.6], frames_count: 5, color_width_px: 160, color_height_px: 120, edge_m: 0.15}
  frames: {min_sharpness: 0, max_frames: 1}
  mesh: {max_faces: 4000}
  atlas: {size_px: 256}
  uvmaps: {heights_px: [44, 70, 102]}
  dataset: {type: dataset.write, input: {uvmaps: uvmaps, frames: frames, mesh: atlas, style: {file: picture.npy}}}
  texture: {input: {style: {file: picture.npy}}, theta_d_m: 1.6, ${more}init: noise, seed: 1, max_steps: 1, optimizer: {epsilon: 1}}
YAML
    step $protocol --until dataset >"$work/dataset.log" || { cat "$work/dataset.log"; fail "the dataset"; }
    for at in 0 $rate; do
        step $protocol --until texture --set texture.rate=$at >"$work/rate_$at.log" || { cat "$work/rate_$at.log"; fail "rate $at"; }
    done
    "$python" "$(dirname "$0")/one_step.py" $protocol "$work/store" "$work/out/$protocol/dataset" "$work/vgg19.safetensors" "$work"/rate_{0,$rate}.log ||
        fail "the first step is not that of the protocol: $protocol"
done
