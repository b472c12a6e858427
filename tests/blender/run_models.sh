#!/usr/bin/env bash
# run_models.sh FRESCO: models in formats that only Blender reads.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 here=$(dirname "$(realpath "$0")")
command -v blender >/dev/null || { skip "models that Blender reads: Blender is not installed"; exit; }
cd "$work"
blender --background --factory-startup --python-exit-code 1 --python "$here/write_models.py" -- "$work" >log 2>&1 \
    || { cat log; fail "Blender could not write its models"; }
cat >model.yaml <<'END'
version: 1
vars: {model: box.fbx}
stages:
  scan: {type: scan.mesh, path: "${model}"}
  ply: {type: export.mesh, input: scan, path: box.ply}
END
# read FILE PICTURES: the box has its size, z up and in meters, and its picture.
read_box() {
    "$fresco" run model.yaml --set model="$1" >log 2>&1 || { cat log; fail "$1 is not read"; }
    grep -q "$1: read by Blender" log || { cat log; fail "$1: its reader is not said"; }
    grep -q "12 faces, 2.0 x 4.0 x 6.0 m$2" log || { cat log; fail "$1 has another shape or picture"; }
}
for file in box.blend box.fbx box.dae box.usdz; do
    [ ! -e "$file" ] || read_box "$file" ", 1 picture"
done
read_box box.stl ""

# A picture beside the model counts, a model without changes is not read again.
"$fresco" run model.yaml --set model=box.blend >log 2>&1
! grep -q "read by Blender" log || fail "an unchanged model was read again"
mv red.png other.png
"$fresco" run model.yaml --set model=box.blend >log 2>&1
grep -q "warning: box.blend: it names .*red.png, which is not there" log || { cat log; fail "the missing picture is not said"; }

# What Blender cannot read is refused with its words.
head -c 100 box.fbx >cut.fbx
"$fresco" run model.yaml --set model=cut.fbx >log 2>&1 && fail "a cut file was read"
grep -q "cut.fbx: Blender .* cannot read it: it ended with exit code 1" log || { cat log; fail "a cut file is refused in other words"; }
if [ ! -e box.usdz ]; then
    cp box.stl box.usdz
    "$fresco" run model.yaml --set model=box.usdz >log 2>&1 && fail "a kind was read that Blender does not know"
    grep -q "has no importer for .usdz files; install one that has" log || { cat log; fail "a kind is refused in other words"; }
fi
PATH=/nowhere "$fresco" check model.yaml >log 2>&1 || { cat log; fail "a check needs Blender"; }
