#!/usr/bin/env bash
# run.sh FRESCO SOURCE: a generated room's run and a matrix of it, and their pages in Chromium.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2

run() { "$fresco" run "$source/room.yaml" --store "$work/store" --out "$work/out" --cores 2 "$@"; }
run >"$work/first.log" 2>&1 || { cat "$work/first.log"; exit 1; }
page=$work/out/report.html
[ -s "$page" ] || { cat "$work/first.log"; fail "there is no report"; }
[ "$(stat -c %s "$page")" -lt 4000000 ] || fail "the page of a small room is too large"
before=$(stat -c %Y.%i "$page")
run >/dev/null 2>&1
[ "$before" = "$(stat -c %Y.%i "$page")" ] || fail "a run with nothing to do wrote the report again"

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$chromium" ] || ! command -v node >/dev/null; then
    skip "the run's report in a browser: chromium or node is not at hand"
    exit 0
fi
"$fresco" run "$source/sweep.yaml" --store "$work/store" --out "$work/sweep" --cores 2 >"$work/sweep.log" 2>&1 || { cat "$work/sweep.log"; exit 1; }
timeout 600 node "$source/look.mjs" "$chromium" "$page" "$work/sweep/sweep.html"
