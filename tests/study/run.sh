#!/usr/bin/env bash
# run.sh FRESCO SOURCE: a page is made, people take part in it with Chromium, and their files are read.
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$chromium" ] || ! command -v node >/dev/null; then
    skip "the user study's page in a browser: chromium or node is not at hand"
    exit 0
fi

python3 "$source/pictures.py" "$work/pictures"
cat >"$work/study.yaml" <<'YAML'
version: 1
stages:
  study: {type: evaluate.study, folder: pictures, pairs_count: 8, image_format: png, hints: hints.json}
YAML
python3 -c 'import json; print(json.dumps([{"view": f"seq-01_frame-{i:06d}", "left": 0.25, "top": 0.5, "width": 0.5, "height": 0.25}
                                           for i in range(6)]))' >"$work/hints.json"
run() { "$fresco" run "$work/study.yaml" --store "$work/store" --out "$work/out" "$@"; }
run >/dev/null
timeout 600 node "$source/participate.mjs" "$chromium" "$work/out/study.html" "$work/out/study.key.json" "$work/results"
ls "$work/results"
for code in one two three; do
    cmp "$work/results/$code.text" "$work"/results/study-*-$code.json || fail "the saved file of $code is not the text shown"
done

# The same pipeline with the results, and only the key without the pictures: the same figures.
page=$(sha256sum <"$work/out/study.html")
run --set study.results="$work/results"
[ "$page" = "$(sha256sum <"$work/out/study.html")" ] || fail "the page changed with the results"
mv "$work/out/study.results.json" "$work/direct.json"
cat >"$work/by_key.yaml" <<'YAML'
version: 1
stages:
  study: {type: evaluate.study, key: out/study.key.json, results: results}
YAML
"$fresco" run "$work/by_key.yaml" --store "$work/store" --out "$work/out2" >/dev/null
cmp "$work/direct.json" "$work/out2/study.results.json" || fail "the key gives other figures"
node - "$work/direct.json" <<'JS'
const assert = require("node:assert/strict");
const figures = JSON.parse(require("node:fs").readFileSync(process.argv[2]));
assert.equal(figures.participants, 3);
assert.equal(figures.complete, 3);
assert.equal(figures.answers, 24);
const [stretch, patterns] = figures.questions.map(question => question.comparisons[0]);
// Four of each question and participant; alpha always, and never a decision.
assert.equal(stretch.first_share.count, 12);
assert.equal(stretch.first_share.value, 1);
assert.equal(stretch.preferred, "alpha");
assert.equal(patterns.neither_share.count, 12);
assert.equal(patterns.preferred, null);
JS
