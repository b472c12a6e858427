#!/usr/bin/env python3
"""same_bytes.py FRESCO PIPELINE: every stage has the same result on one thread and on five, and when each of them was stopped on the way and
run again. A stop ends the run within seconds, with 75. Random weights take the place of VGG-19's."""
import filecmp
import json
import math
import os
import pathlib
import random
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

FRESCO = sys.argv[1]
PIPELINE = pathlib.Path(__file__).resolve().parent / sys.argv[2]
WORK = tempfile.TemporaryDirectory(prefix="fresco-same-bytes-")
HERE = pathlib.Path(WORK.name)
ENVIRONMENT = dict(os.environ, XDG_DATA_HOME=str(HERE / "data"))
ENVIRONMENT.pop("FRESCO_PLUGIN_PATH", None)
LONGEST_STOP_S = 60  # On a busy machine; an idle one takes a fraction of a second.
problems = []
settings = []


def write_vgg19(file):
    """Up to conv4_2, in half precision; He's deviation, the same random numbers again and again."""
    draw = random.Random(1)
    numbers = [draw.gauss(0, 1) for _ in range(9973)]
    header, data, inputs = {}, bytearray(), 3
    for block, outputs, count in ((1, 64, 2), (2, 128, 2), (3, 256, 4), (4, 512, 2)):
        for number in range(1, count + 1):
            deviation = math.sqrt(2 / (9 * inputs))
            period = struct.pack(f"<{len(numbers)}e", *(deviation * value for value in numbers))
            for part, shape in (("weight", [outputs, inputs, 3, 3]), ("bias", [outputs])):
                size = 2 * math.prod(shape)
                header[f"conv{block}_{number}.{part}"] = {"dtype": "F16", "shape": shape, "data_offsets": [len(data), len(data) + size]}
                data += (period * (size // len(period) + 1))[:size]
            inputs = outputs
    text = json.dumps(header).encode()
    file.write_bytes(struct.pack("<Q", len(text)) + text + data)


if "weights:" in PIPELINE.read_text():
    write_vgg19(HERE / "vgg19.safetensors")
    settings = ["--set", f"weights={HERE / 'vgg19.safetensors'}"]


def command(store, cores):
    return [FRESCO, "run", str(PIPELINE), "--store", str(HERE / store), "--out", str(HERE / "out" / store), "--cores", str(cores), "--no-report",
            "--json-log", *settings]


def run(store, cores):
    """What the stages that ran made: names in the store."""
    ended = subprocess.run(command(store, cores), env=ENVIRONMENT, capture_output=True, text=True)
    if ended.returncode != 0:
        failed = [line for line in ended.stdout.splitlines() if '"error":""' not in line and '"event":"end"' in line]
        sys.exit(f"--cores {cores} ended with {ended.returncode}: " + "\n".join(failed) + ended.stderr)
    events = map(json.loads, ended.stdout.splitlines())
    return {event["stage"]: event["object"] for event in events if event["event"] == "end"}


def stop_at(stage, store):
    """Stops a run once the stage has begun; False: it has a result already."""
    process = subprocess.Popen(command(store, 2), env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
    begun = False
    for line in process.stdout:
        event = json.loads(line)
        if event["event"] == "begin" and event["stage"] == stage:
            begun = True
            time.sleep(0.03)
            process.send_signal(signal.SIGTERM)
            since = time.monotonic()
    process.wait()
    if not begun:
        return False
    if process.returncode not in (0, 75):
        problems.append(f"{stage}: stopped, the run ended with {process.returncode}; expected 75")
    if time.monotonic() - since > LONGEST_STOP_S:
        problems.append(f"{stage}: stopping took {time.monotonic() - since:.0f} s")
    return process.returncode == 75


def files_of(store, name):
    """Its manifest has times."""
    folder = HERE / store / "objects" / name
    return {path.relative_to(folder): path for path in folder.rglob("*") if path.is_file() and path != folder / "manifest.json"}


def compare(store, what):
    for stage, name in expected.items():
        here, there = files_of("one", name), files_of(store, name)
        if here.keys() != there.keys():
            problems.append(f"{stage}: {what} made other files")
        for file in sorted(here.keys() & there.keys()):
            if not filecmp.cmp(here[file], there[file], shallow=False):
                problems.append(f"{stage}: {what} made another {file}")


expected = run("one", 1)
run("five", 5)
compare("five", "five threads")
stopped = sum(stop_at(stage, "stopped") for stage in expected)
run("stopped", 2)
compare("stopped", "a stopped run")
if stopped < 3:
    problems.append(f"only {stopped} of {len(expected)} stages were stopped before their end: this test tries too little")
print(f"{len(expected)} stages, {stopped} of them stopped, {len(problems)} problems")
sys.exit("\n".join(problems) if problems else 0)
