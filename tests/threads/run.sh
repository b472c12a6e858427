#!/usr/bin/env bash
# run.sh FRESCO: runs room.yaml. A report of ThreadSanitizer in any of the processes fails the test.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_DATA_HOME=$work/data TSAN_OPTIONS="suppressions=$here/suppressions.txt log_path=$work/report"
unset FRESCO_PLUGIN_PATH
ended=0
# More threads than cores: stages share them out.
"$1" run "$here/room.yaml" --store "$work/store" --out "$work/out" --cores 16 || ended=$?
"$1" store verify --store "$work/store" || ended=$?
if compgen -G "$work/report.*" >/dev/null; then
    cat "$work"/report.*
    exit 1
fi
exit $ended
