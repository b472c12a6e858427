#!/usr/bin/env bash
# run.sh table1|table2 OUT [OPTION…]: runs every method of a table and prints the table. OPTIONs go to `fresco run`, files to OUT/METHOD.
#   METHODS="stylemesh dip" run.sh …    only these; METHODS= : only print what is in OUT
#   FRESCO=build/bin/fresco run.sh …    the program, if it is not in PATH; PYTHON: a Python with NumPy and OpenCV, if python3 is none
set -euo pipefail
folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
table=${1:-} out=${2:-}
if [ -z "$out" ] || [[ $table != table[12] ]]; then
    sed -n '2,4s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
shift 2
for method in ${METHODS-$(cd "$folder/$table" && printf '%s\n' *.yaml | sed 's/\.yaml$//')}; do
    echo "=== $method"
    "${FRESCO:-fresco}" run "$folder/$table/$method.yaml" --out "$out/$method" "$@"
    [ "$table" = table2 ] || for run in "$out/$method"/*/run.json; do
        "${PYTHON:-python3}" "$folder/painting.py" "$(dirname "$run")" --frames none --every 20
    done
done

# OUT/METHOD/COMBINATION/*.json hold a run's figures each; a row is their mean.
"${PYTHON:-python3}" - "$table" "$out" <<'PYTHON'
import json
import pathlib
import sys

table, out = sys.argv[1], pathlib.Path(sys.argv[2])
if table == "table1":
    file, columns = "reprojection.json", ["short x100", "long x100", "short floor", "long floor", "short headline", "long headline", "strokes",
                                         "off palette"]

    def figures(path):
        run, painting = json.loads(path.read_text()), path.with_name("painting.json")
        gaps = run["short"], run["long"]
        strength = json.loads(painting.read_text())["figures"] if painting.exists() else {}
        return [gap[name]["value"] and gap[name]["value"] * factor
                for name, factor in (("value", 100), ("floor", 100), ("headline", 1)) for gap in gaps] + [
                    strength.get(name, {}).get("mean") for name in ("strokes", "off_palette")]
else:
    file, columns = "circles.json", ["Corr. 2D", "Corr. 3D", "Stretch", "circles"]

    def figures(path):
        run = json.loads(path.read_text())
        return [run["corr_2d"]["value"], run["corr_3d"]["value"], run["stretch"]["value"], run["circles"]]


def mean(values):
    known = [value for value in values if value is not None]
    whole = all(isinstance(value, int) for value in known)
    return f"{sum(known) / len(known):.{0 if whole else 3}f}" if known else "-"


print(f"\n{'method':12}{'runs':>5}" + "".join(f"{name:>16}" for name in columns))
for method in sorted(path for path in out.iterdir() if path.is_dir()):
    runs = [figures(path) for path in sorted(method.glob("*/" + file))]
    if runs:
        print(f"{method.name:12}{len(runs):5}" + "".join(f"{mean(values):>16}" for values in zip(*runs)))
PYTHON
