#!/usr/bin/env bash
# Paints a scan in several styles, every twelfth frame held out, and judges the renders of those frames.
#   tests/bench/method/contact_sheet.sh SCAN WEIGHTS STYLE... [-- OPTION OF fresco run...]
# Needs ./bootstrap bench method once, for the programs (FRESCO: another fresco). The sheet lies in build/contact_sheet/.
set -euo pipefail
root=$(cd "$(dirname "$0")/../../.." && pwd)
[ $# -ge 3 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
scan=$1 weights=$2
shift 2
out=$root/build/contact_sheet
mkdir -p "$out"
judged=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    name=$(basename "${1%.*}")
    begin=$SECONDS
    "${FRESCO:-$root/build/bin/fresco}" run "$root/tests/bench/method/contact_sheet.yaml" --store "$out/store" --out "$out/$name" \
        --set data="$(realpath "$scan")" --set picture="$(realpath "$1")" "${@:$(($# + 1))}" >"$out/$name.log" 2>&1 ||
        { cat "$out/$name.log" >&2; exit 1; }
    echo "$name: $((SECONDS - begin)) s"
    judged+=(--style "$1" --views "$out/$name/views")
    shift
done
"$root/build/bin/contact_sheet" --scan "$scan" --weights "$weights" "${judged[@]}" --sheet "$out/sheet.png" --json "$out/sheet.json"
echo "$out/sheet.png"
