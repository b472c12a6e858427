#!/usr/bin/env python3
"""memory.py FRESCO: on a small and on a large room, painting takes the memory that `plan` says, within a factor of two."""
import json
import pathlib
import subprocess
import sys
import tempfile

FRESCO = sys.argv[1]
PIPELINE = pathlib.Path(__file__).resolve().parent / "rooms.yaml"


def fresco(command, folder, length_m, width_m, *more):
    return subprocess.run([FRESCO, command, PIPELINE, "--store", folder / "store", "--set", f"length_m={length_m}", "--set",
                           f"width_m={width_m}", *more], check=True, stdout=subprocess.PIPE).stdout


problems = []
for size in ((3.5, 3), (10, 8)):
    with tempfile.TemporaryDirectory(prefix="fresco-estimates-") as name:
        folder = pathlib.Path(name)
        planned = {stage["stage"]: stage["cost"]["memory_mb"] for stage in json.loads(fresco("plan", folder, *size, "--json"))["stages"]}
        fresco("run", folder, *size, "--cores", "2", "--out", folder / "out", "--quiet")
        taken = {stage["name"]: stage["memory_mb"] for stage in json.loads((folder / "out" / "run.json").read_text())["stages"]}
        text = f"{size[0]} x {size[1]} m: {planned['texture']:.0f} MB planned, {taken['texture']:.0f} MB taken"
        print(text)
        if not 0.5 <= planned["texture"] / taken["texture"] <= 2:
            problems.append(text)
sys.exit("not within a factor of two: " + "; ".join(problems) if problems else 0)
