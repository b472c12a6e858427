#!/usr/bin/env python3
"""kill.py FRESCO PIPELINE KILL_AT_RENAME [--long]: kills runs with SIGKILL, runs them again, and compares the final files with an
uninterrupted run. FRESCO is fresco_with_faults, KILL_AT_RENAME the library made of kill_at_rename.c.

Each publishing step is hit once, and each step of changing checkpoints. With --long, kills are also spread over the measured run (at the
beginning and the end of every stage, and at even times), at least 15 fall inside the optimizer after its first checkpoint, and 50 must land.
"""
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

FRESCO, PIPELINE, KILL_AT_RENAME = sys.argv[1:4]
LONG = "--long" in sys.argv[4:]
CHECKPOINT_STEPS = 5
WORK = pathlib.Path(tempfile.mkdtemp(prefix="fresco-kill-"))
ENVIRONMENT = dict(os.environ, XDG_DATA_HOME=str(WORK / "data"))
ENVIRONMENT.pop("FRESCO_PLUGIN_PATH", None)

PUBLISHING = ["publish.written", "publish.synced", "publish.renamed", "publish.key", "publish.manifest", "publish.done"]
# When the optimizer changes its checkpoints, the last becomes the earlier one before the next takes its name. Killed just then, the
# next run goes on from as many checkpoints further than this run did. One that goes on from the earlier checkpoint writes it again.
CHANGING = [("before earlier.safetensors", 0), ("after earlier.safetensors", 0), ("before checkpoint.safetensors", 0),
            ("after checkpoint.safetensors", 0), ("after checkpoint.safetensors", 1)]
OTHER_POINTS = ["stage.started", "stage.done", "export.written", "export.copied"]


class Site:
    """One store and one output folder, run again and again."""

    def __init__(self, name):
        self.store, self.out = WORK / name / "store", WORK / name / "out"

    def wipe(self):
        shutil.rmtree(self.store.parent, ignore_errors=True)

    def start(self, fault=None, rename=None):
        environment = dict(ENVIRONMENT)
        if rename:
            environment.update(LD_PRELOAD=KILL_AT_RENAME, KILL_AT_RENAME=rename)
        if fault:
            environment["FRESCO_FAULT"] = fault
        command = [FRESCO, "run", PIPELINE, "--store", str(self.store), "--out", str(self.out), "--json-log", "--cores", "2"]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)

    def run(self, kill_when=None, fault=None, kill_after=None, rename=None):
        """Runs until the end, a fault point or a renaming, until an event makes kill_when true, or for kill_after seconds.
        Returns (exit status, events)."""
        process = self.start(fault, rename)
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
        """What the run made, but for the report, which shows times, and the record of what was written."""
        return {str(file.relative_to(self.out)): hashlib.sha256(file.read_bytes()).hexdigest()
                for file in sorted(self.out.rglob("*")) if file.is_file() and file.name not in ("report.html", "run.json", ".fresco-outputs")}


def steps(events):
    return [event["done"] for event in events if event.get("event") == "progress" and event["stage"] == "texture" and event.get("unit") == "steps"]


def taken_up(events):
    """The step after which the optimizer went on; 0: it started over; None: it did not get that far."""
    messages = [event["text"] for event in events if event.get("event") == "message" and event.get("stage") == "texture"]
    found = [int(match[1]) for match in (re.match(r"going on after step (\d+) of", text) for text in messages) if match]
    return found[0] if found else 0 if steps(events) else None


def main():
    reference = Site("reference")
    _, events = reference.run()
    duration = events[-1]["time"]
    expected = reference.files()
    stages = [event["stage"] for event in events if event.get("event") == "begin"]
    # How many there are; progress is reported a few times a second, and not of the last one.
    total_steps = max(event["total"] for event in events if event.get("event") == "progress" and event.get("unit") == "steps")
    assert len(expected) > 1 and total_steps > 80, (expected, total_steps)
    print(f"uninterrupted: {duration:.1f} s, {total_steps:.0f} steps, {len(expected)} files, stages {' '.join(stages)}")

    site, landed, in_optimizer, at_points = Site("killed"), 0, 0, set()

    def finish():
        """Runs to the end and compares. Call it whenever a run came through."""
        status, _ = site.run()
        assert status == 0
        assert site.files() == expected, f"other bytes after {landed} kills: {site.files()} instead of {expected}"

    # Inside the optimizer, each kill a few steps after the one before: the run must go on from its newest checkpoint.
    reached = 0
    for target in range(CHECKPOINT_STEPS + 1, int(total_steps) - 1, 5 if LONG else 20):
        status, events = site.run(lambda e: e.get("stage") == "texture" and e.get("event") == "progress" and e.get("done", 0) >= target)
        begun = taken_up(events)
        if begun is not None:
            assert begun >= reached - CHECKPOINT_STEPS, f"killed at step {reached}, went on after {begun}: more than an interval lost"
        reached = max(steps(events), default=reached)
        if status != 0:
            landed += 1
            in_optimizer += reached > CHECKPOINT_STEPS
    finish()

    # While checkpoints change: how far the next run comes back is known to the step.
    site.wipe()
    left, told = 0, 0
    for point, further in CHANGING[-1:] + CHANGING * (2 if LONG else 1):
        status, events = site.run(rename=point)
        assert status != 0, f"the run came through: killing {point} had no effect"
        begun = taken_up(events)
        assert begun in (left, None), f"went on after step {begun} instead of {left}; then killed {point}"
        told += begun is not None
        left += further * CHECKPOINT_STEPS
        landed += 1
        in_optimizer += left > 0
    assert told >= (len(CHANGING) if LONG else 1), f"only {told} runs said where they went on"
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

    if LONG:
        landed += spread_kills(site, stages, duration, expected, finish)
    print(f"{landed} kills landed, {in_optimizer} inside the optimizer after its first checkpoint, publishing steps: {' '.join(sorted(at_points))}")
    missing = set(PUBLISHING) - at_points
    least = (50, 15) if LONG else (18, 5)
    if landed < least[0] or in_optimizer < least[1] or missing:
        sys.exit(f"too few kills landed: {least[0]}, {least[1]} and every publishing step are wanted; missing: {missing}")


def spread_kills(site, stages, duration, expected, finish):
    """How many landed at the beginning and the end of every stage, and at even times over the whole run."""
    landed = 0
    # At the beginning and the end of every stage; a site goes on from kill to kill, and starts over where the stage was stored already.
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
    return landed


try:
    main()
finally:
    shutil.rmtree(WORK, ignore_errors=True)
