#!/usr/bin/env bash
# run.sh WRITE_UV_MAPS SOURCE: the NumPy reader of packed uv maps against the SDK's own.
source "$(dirname "$0")/../program_test.sh"
write_uv_maps=$1 source=$2
"$write_uv_maps" "$work"
python=$(python_with numpy, zstandard) || { skip "packed uv maps read with NumPy: no python3 with numpy and zstandard is at hand"; exit; }
PYTHONPATH=$source/sdk/python PYTHONDONTWRITEBYTECODE=1 "$python" "$source/tests/packed_uv_maps/compare.py" "$work"
