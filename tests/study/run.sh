#!/usr/bin/env bash
# run.sh SOURCE: a page is made, people take part in it with Chromium, and their files are counted.
source "$(dirname "$0")/../program_test.sh"
study=$1/pipelines/paper/study.py
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$chromium" ] || ! command -v node >/dev/null || ! python=$(python_with cv2); then
    skip "the user study: chromium, node or python3-opencv is not at hand"
    exit 0
fi
cd "$work"
mkdir -p pictures/{alpha,beta}
"$python" -c "import cv2, numpy
[cv2.imwrite(f'pictures/{method}/view{view}.png', numpy.full((120, 160, 3), 9 * view + len(method), numpy.uint8)) for method in ('alpha', 'beta') for view in range(6)]"
"$python" "$study" page pictures out --pairs 8 --ours alpha
timeout 600 node "$(dirname "$0")/participate.mjs" "$chromium" out/study.html out/study.key.json results
"$python" "$study" results out/study.key.json results
"$python" - <<'PY'
import json
figures = json.load(open("out/study.results.json"))
assert [figures[name] for name in ("participants", "complete", "answers")] == [3, 2, 19], figures
stretch, patterns = (question["comparisons"][0] for question in figures["questions"])
assert 8 <= stretch["first_share"]["count"] == stretch["answers"] <= 11 and stretch["preferred"] == "alpha", stretch
assert patterns["neither_share"]["count"] == patterns["answers"] == 19 - stretch["answers"] and patterns["preferred"] is None, patterns
assert abs(patterns["first_share"]["high"] - 1.96 ** 2 / (patterns["answers"] + 1.96 ** 2)) < 1e-4, patterns  # Wilson's interval of none
PY
cp results/two.json results/again.json
! "$python" "$study" results out/study.key.json results 2>said && grep -q "two files of the participant two" said
