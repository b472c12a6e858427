#!/usr/bin/env bash
# run.sh FRESCO SOURCE: pipelines/paper in small. Two methods on two generated rooms, frames made elsewhere, circles.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2 paper=$2/pipelines/paper
python=$(python_with numpy, cv2) || { skip "the paper's evaluation with random weights: no python3 with numpy and OpenCV is at hand"; exit 0; }

"$python" "$source/tests/presets/random_vgg19.py" "$work/vgg19.safetensors"
"$python" -c 'import numpy, sys; numpy.save(sys.argv[1], numpy.random.default_rng(1).integers(0, 256, (192, 64, 3), numpy.uint8))' "$work/style.npy"
places=(--store "$work/store")
# shellcheck disable=SC2016  # ${scene} is the pipelines' own
room=(--set scan.type=scan.synthetic_room --set scan.frames_count=12 --set scan.color_width_px=160 --set scan.color_height_px=120
    --set scan.edge_m=0.15 --set 'scan.seed=${scene}' --set mesh.max_faces=4000 --set "scans=$work")
small=("${room[@]}" --set frames.window_count=1 --set frames.max_frames=4 --set frames.min_sharpness=0 --set atlas.size_px=512
    --set uvmaps.heights_px=[64] --set texture.max_steps=2 --set "weights=$work/vgg19.safetensors")
gaps=(--set reprojection.gaps=[1,2] --set reprojection.min_covisible=0.05)
export FRESCO=$fresco PYTHON=$python

# Table 1: each method a row of figures, the mean of both rooms.
table1() { "$paper/run.sh" table1 "$work/table1" "$@" >"$work/log" 2>&1 || { cat "$work/log"; fail "table1"; }; }
METHODS="stylemesh dip" table1 "${small[@]}" "${gaps[@]}" "${places[@]}" --set views.height_px=120 --set "scene=[1, 2]" \
    --set "picture=[$work/style.npy]"
# What another renderer made is measured as what fresco's did.
for scene in 1 2; do
    mkdir -p "$work/frames"
    cp -r "$work/table1/dip/scene=$scene,style/views" "$work/frames/$scene"
done
"$fresco" run "$paper/frames.yaml" "${room[@]}" "${gaps[@]}" "${places[@]}" --set "scene=[1, 2]" --set "pictures=$work/frames" \
    --out "$work/table1/other" >"$work/log" 2>&1 || { cat "$work/log"; fail "frames.yaml"; }
# Stylized frames become a texture: here those that were rendered from the photographic one.
for way in rgb vst; do
    stylized=()
    [ "$way" = rgb ] || stylized=(--set "stylized=$work/table1/rgb/scene=\${scene}/views")
    "$fresco" run "$paper/vst.yaml" "${room[@]}" "${gaps[@]}" "${places[@]}" --set "scene=[1, 2]" --set frames.window_count=1 --set frames.max_frames=4 \
        --set frames.min_sharpness=0 --set atlas.size_px=512 --set uvmaps.heights_px=[64] --set views.height_px=120 "${stylized[@]}" \
        --out "$work/table1/$way" >"$work/log" 2>&1 || { cat "$work/log"; fail "vst.yaml"; }
done
METHODS="" table1
cat "$work/log"
row() { awk -v method="$1" '$1 == method { $1 = ""; print }' "$work/log"; }
for method in stylemesh dip; do
    [[ $(row $method) =~ ^\ 2(\ -?[0-9]+\.[0-9]{3}){8}$ ]] || fail "the row of $method is '$(row $method)'"
done
for method in other rgb vst; do
    [[ $(row $method) =~ ^\ 2(\ -?[0-9]+\.[0-9]{3}){6}\ -\ -$ ]] || fail "the row of $method is '$(row $method)'"
done
[ "$(row other | cut -d ' ' -f -8)" = "$(row dip | cut -d ' ' -f -8)" ] || fail "the same pictures have other figures when they come from a folder"
[ "$(row rgb)" != "$(row vst)" ] || fail "stylized frames were not used"
[ "$(row stylemesh)" != "$(row dip)" ] || fail "two methods have the same figures"

# Table 2: after two steps there are no circles to find, but everything runs.
METHODS=stylemesh "$paper/run.sh" table2 "$work/table2" "${small[@]}" "${places[@]}" --set views.height_px=784 --set views.every_count=4 \
    --set "scene=[1]" --set "picture=$work/style.npy" >"$work/log" 2>&1 || { cat "$work/log"; fail "table2"; }
tail -n 2 "$work/log"
[[ $(row stylemesh) =~ ^\ 1\ .*\ [0-9]+$ ]] || fail "the row of table2 is '$(row stylemesh)'"
