#!/usr/bin/env bash
# run.sh FRESCO SOURCE: every pipeline that is shipped fits the plugins: types, ports, options, ranges, results that are read; as it is, and as a preview. Files
# stand in for its inputs.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 pipelines=$2/pipelines count=0 failed=()

printf 'PK\3\4' >"$work/weights.pth"
echo 'v 0 0 0' >"$work/model.obj"
# What the presets name is one folder for all of them; the ready pipelines find out what it is.
mkdir -p "$work"/scan/{color,depth,pose,undistorted_camera_parameters} "$work/room/seq-01"
touch "$work/scan/undistorted_camera_parameters/house.conf"
room=(--set "data=$work/room") data=(--set "data=$work/scan") picture=(--set "picture=$pipelines/demo.jpg") weights=(--set "weights=$work/weights.pth")

check() { # FILE MORE…
    count=$((count + 1))
    "$fresco" check "$pipelines/$1" "${@:2}" >"$work/log" 2>&1 && grep -q "no problems$" "$work/log" || { echo "$*:"; cat "$work/log"; failed+=("$1"); }
}
ready() { check "$@"; check "$@" --preview; }

for name in demo regions sweep; do ready $name.yaml; done
for name in room large; do ready $name.yaml "${room[@]}" "${picture[@]}"; done
ready stylemesh.yaml "${room[@]}" "${picture[@]}" "${weights[@]}"
for name in photo_texture prepare; do ready $name.yaml "${room[@]}"; done
ready retexture.yaml "${room[@]}" --set "model=$work/model.obj"
ready mesh.yaml --set "model=$work/model.obj" "${picture[@]}"
# As they are, the presets and the paper's tables are checked by tests/presets/resolved.py.
for preset in "$pipelines"/presets/*.yaml; do
    name=presets/$(basename "$preset")
    [ $name = presets/preview.yaml ] || check $name --preview "${data[@]}" "${picture[@]}" "${weights[@]}"
done
check paper/frames.yaml --set "scans=$work" --set 'scene=[scan]' --set "pictures=$work"

# Without its inputs a pipeline says what to set.
! "$fresco" check "$pipelines/room.yaml" >"$work/log" 2>&1
grep -q "'data' has no value: set it with --set data=" "$work/log" || { cat "$work/log"; fail "nobody says what to set"; }
[ $count -gt 30 ] || fail "only $count checks: this test looks in the wrong place"
[ ${#failed[@]} -eq 0 ] || fail "${failed[*]}"
echo "$count checks of pipelines"
