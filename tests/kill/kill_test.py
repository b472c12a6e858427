#!/usr/bin/env python3
"""kill_test.py FRESCO PIPELINE: kills runs with SIGKILL, runs them again, and compares the final files with an uninterrupted run.

Kills are spread over the measured run (at the beginning and the end of every stage, and at even times), at least 15 fall inside the
optimiser after its first checkpoint, and each publishing step is hit once. Fails if fewer than 50 landed.
"""
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

FRESCO, PIPELINE = sys.argv[1], sys.argv[2]
CHECKPOINT_STEPS = 5
WORK = pathlib.Path(tempfile.mkdtemp(prefix="fresco-kill-"))
ENVIRONMENT = dict(os.environ, XDG_CACHE_HOME=str(WORK / "cache"), XDG_DATA_HOME=str(WORK / "data"))
for name in ("FRESCO_PLUGIN_PATH", "FRESCO_FAULT"):
    ENVIRONMENT.pop(name, None)

PUBLISHING = ["publish.written", "publish.synced", "publish.renamed", "publish.key", "publish.manifest", "publish.done"]
OTHER_POINTS = ["stage.started", "stage.done", "export.written", "export.copied"]


class Site:
    """One store and one output folder, run again and again."""

    def __init__(self, name):
        self.store, self.out = WORK / name / "store", WORK / name / "out"

    def wipe(self):
        shutil.rmtree(self.store.parent, ignore_errors=True)

    def start(self, fault=None):
        environment = dict(ENVIRONMENT)
        if fault:
            environment["FRESCO_FAULT"] = fault
        command = [FRESCO, "run", PIPELINE, "--store", str(self.store), "--out", str(self.out), "--json-log", "--cores", "2"]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)

    def run(self, kill_when=None, fault=None, kill_after=None):
        """Runs until the end, until an event makes kill_when true, or for kill_after seconds. Returns (exit status, events)."""
        process = self.start(fault)
        begin, events = time.monotonic(), []
        if kill_after is not None:
            try:
                process.wait(kill_after)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
        for line in process.stdout:
            event = json.loads(line) if line.endswith("\n") else {}
            event["time"] = time.monotonic() - begin
            events.append(event)
            if kill_when and kill_when(event):
                process.send_signal(signal.SIGKILL)
        errors = process.stderr.read()
        status = process.wait()
        if status not in (0, -signal.SIGKILL):
            sys.exit(f"run ended with {status}:\n{errors}")
        return status, events

    def files(self):
        return {str(file.relative_to(self.out)): hashlib.sha256(file.read_bytes()).hexdigest()
                for file in sorted(self.out.rglob("*")) if file.is_file()}


def steps(events):
    return [event["done"] for event in events if event.get("event") == "progress" and event["stage"] == "texture" and event.get("unit") == "steps"]


def main():
    reference = Site("reference")
    _, events = reference.run()
    duration = events[-1]["time"]
    expected = reference.files()
    stages = [event["stage"] for event in events if event.get("event") == "begin"]
    total_steps = max(steps(events))
    assert len(expected) > 1 and total_steps > 80, (expected, total_steps)
    print(f"uninterrupted: {duration:.1f} s, {total_steps:.0f} steps, {len(expected)} files, stages {' '.join(stages)}")

    site, landed, in_optimiser, at_points = Site("killed"), 0, 0, set()

    def finish():
        """Runs to the end and compares. Call it whenever a run came through."""
        status, _ = site.run()
        assert status == 0
        assert site.files() == expected, f"other bytes after {landed} kills: {site.files()} instead of {expected}"

    # Inside the optimiser, each kill a few steps after the one before: the run must go on from its newest checkpoint.
    reached = 0
    for target in range(CHECKPOINT_STEPS + 1, int(total_steps) - 1, 5):
        status, events = site.run(lambda e: e.get("stage") == "texture" and e.get("event") == "progress" and e.get("done", 0) >= target)
        seen = steps(events)
        if seen and reached > CHECKPOINT_STEPS:
            assert seen[0] > reached - 2 * CHECKPOINT_STEPS, f"killed at step {reached}, went on at {seen[0]}: more than an interval lost"
        reached = max(seen, default=reached)
        if status != 0:
            landed += 1
            in_optimiser += reached > CHECKPOINT_STEPS
    finish()

    # At every publishing step, each time in another stage.
    for number, point in enumerate(PUBLISHING + OTHER_POINTS):
        site.wipe()
        stage = "glb" if point.startswith("export") else stages[number % len(stages)]
        status, _ = site.run(fault=point if point.startswith("export") else f"{point}@{stage}")
        if status != 0:
            landed += 1
            at_points.add(point)
        if number % 3 == 2:
            finish()
    finish()

    # At the beginning and the end of every stage; a site goes on from kill to kill, and begins anew where the stage was stored already.
    site.wipe()
    for stage in stages:
        for moment in ("begin", "end"):
            for _ in range(2):
                status, _ = site.run(lambda e: e.get("event") == moment and e.get("stage") == stage)
                landed += status != 0
                if status != 0:
                    break
                assert site.files() == expected
                site.wipe()
    finish()

    # At even times over the whole run.
    site.wipe()
    for number in range(16):
        status, _ = site.run(kill_after=duration * (number + 1) / 17)
        landed += status != 0
        if status == 0:
            finish()
            site.wipe()
    finish()

    print(f"{landed} kills landed, {in_optimiser} inside the optimiser after its first checkpoint, publishing steps: {' '.join(sorted(at_points))}")
    missing = set(PUBLISHING) - at_points
    if landed < 50 or in_optimiser < 15 or missing:
        sys.exit(f"too few kills landed: 50, 15 and every publishing step are wanted; missing: {missing}")


try:
    main()
finally:
    shutil.rmtree(WORK, ignore_errors=True)
