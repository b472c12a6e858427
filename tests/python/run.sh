#!/usr/bin/env bash
# run.sh FRESCO SOURCE: the Python package, its types, and the example, as their user runs them.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2
python=$(python_with numpy, zstandard) || { skip "the Python package: there is no python3 with numpy and zstandard"; exit; }
export PYTHONPATH=$source/sdk/python PYTHONDONTWRITEBYTECODE=1
cd "$work"
"$python" "$source/tests/python/test_python.py" "$fresco"
PATH="$(dirname "$fresco"):$PATH" "$python" "$source/sdk/examples/python/paint_room.py" --preview
[ -s out/preview/room.glb ]
if command -v mypy >/dev/null; then
    mypy --strict --cache-dir=cache --python-executable="$python" "$source/sdk/python/fresco" "$source/sdk/examples/python/paint_room.py"
else
    skip "types of the Python package: mypy is not installed"
fi
