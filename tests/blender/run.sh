#!/usr/bin/env bash
# run.sh FRESCO SOURCE: the Blender add-on in a headless Blender.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2
command -v blender >/dev/null || { skip "the Blender add-on: Blender is not installed"; exit; }
mkdir "$work/home" "$work/tmp"
cd "$work"
HOME=$work/home XDG_CONFIG_HOME=$work/home TMPDIR=$work/tmp PATH="$(dirname "$fresco"):$PATH" PYTHONDONTWRITEBYTECODE=1 \
    blender --background --factory-startup --python-exit-code 1 --python "$source/tests/blender/test_addon.py" -- \
    "$source/sdk/blender/fresco_addon.py" "$source/pipelines/demo.jpg" >log 2>&1 || { cat log; fail "the add-on failed"; }
grep '^painted' log
