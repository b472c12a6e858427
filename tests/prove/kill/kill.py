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
import threading
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
    """One store and one output folder, run again and again; how many kills landed, and how many of them inside the optimizer."""

    def __init__(self, name):
        self.store, self.out = WORK / name / "store", WORK / name / "out"
        self.landed = self.in_optimizer = 0

    def wipe(self):
        shutil.rmtree(self.store.parent, ignore_errors=True)

    def run(self, kill_when=lambda event: False, kill_after=None, **faults):
        """Runs until the end, or until a kill: at a fault, once an event makes kill_when true, or after kill_after seconds. Gives whether it
        was killed, and the events."""
        command = [FRESCO, "run", PIPELINE, "--store", str(self.store), "--out", str(self.out), "--json-log", "--cores", "2"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT | faults)
        timer = threading.Timer(kill_after or 1e6, process.kill)
        timer.daemon = True
        timer.start()
        events = []
        for line in process.stdout:
            events.append(json.loads(line) if line.endswith("\n") else {})
            if kill_when(events[-1]):
                process.kill()
        errors, status = process.stderr.read(), process.wait()
        timer.cancel()
        if status not in (0, -signal.SIGKILL):
            sys.exit(f"run ended with {status}:\n{errors}")
        self.landed += status != 0
        return status != 0, events

    def files(self):
        """What the run made, but for the report, which shows times, the pictures that it shows meanwhile, which go by time, and the record of what was written."""
        return {str(file.relative_to(self.out)): hashlib.sha256(file.read_bytes()).hexdigest()
                for file in sorted(self.out.rglob("*")) if file.is_file() and file.relative_to(self.out).parts[0] not in ("report.html", "run.json", "progress", "progress.jsonl", ".fresco-outputs")}

    def finish(self, expected):
        """Runs to the end and compares. Call it whenever a run came through."""
        killed, _ = self.run()
        assert not killed and self.files() == expected, f"other bytes after {self.landed} kills: {self.files()} instead of {expected}"


def steps(events):
    return [event["done"] for event in events if event.get("event") == "progress" and event["stage"] == "texture" and event.get("unit") == "steps"]


def taken_up(events):
    """The step after which the optimizer went on; 0: it started over; None: it did not get that far."""
    messages = [event["text"] for event in events if event.get("event") == "message" and event.get("stage") == "texture"]
    found = [int(match[1]) for match in (re.match(r"going on after step (\d+) of", text) for text in messages) if match]
    return found[0] if found else 0 if steps(events) else None


def kill_in_optimizer(site, total_steps):
    """Each kill a few steps after the one before: the run must go on from its newest checkpoint."""
    reached = 0
    for target in range(CHECKPOINT_STEPS + 1, int(total_steps) - 1, 5 if LONG else 20):
        killed, events = site.run(lambda e: e.get("stage") == "texture" and e.get("event") == "progress" and e.get("done", 0) >= target)
        begun = taken_up(events)
        if begun is not None:
            assert begun >= reached - CHECKPOINT_STEPS, f"killed at step {reached}, went on after {begun}: more than an interval lost"
        reached = max(steps(events), default=reached)
        site.in_optimizer += killed and reached > CHECKPOINT_STEPS


def kill_while_checkpoints_change(site):
    """How far the next run comes back is known to the step."""
    left, told = 0, 0
    for point, further in CHANGING[-1:] + CHANGING * (2 if LONG else 1):
        killed, events = site.run(LD_PRELOAD=KILL_AT_RENAME, KILL_AT_RENAME=point)
        assert killed, f"the run came through: killing {point} had no effect"
        begun = taken_up(events)
        assert begun in (left, None), f"went on after step {begun} instead of {left}; then killed {point}"
        told += begun is not None
        left += further * CHECKPOINT_STEPS
        site.in_optimizer += left > 0
    assert told >= (len(CHANGING) if LONG else 1), f"only {told} runs said where they went on"


def spread_kills(site, stages, duration, expected):
    """At the beginning and the end of every stage, and at even times over the whole run. A site goes on from kill to kill, and starts over
    where a run came through."""
    at_stages = [{"kill_when": lambda e, moment=moment, stage=stage: e.get("event") == moment and e.get("stage") == stage}
                 for stage in stages for moment in ("begin", "end")]
    for kill in at_stages + [{"kill_after": duration * (number + 1) / 17} for number in range(16)]:
        if not site.run(**kill)[0]:
            assert site.files() == expected
            site.wipe()
            site.run(**kill)
    site.finish(expected)


def main():
    reference = Site("reference")
    begin = time.monotonic()
    _, events = reference.run()
    duration, expected = time.monotonic() - begin, reference.files()
    stages = [event["stage"] for event in events if event.get("event") == "begin"]
    # How many there are; progress is reported a few times a second, and not of the last one.
    total_steps = max(event["total"] for event in events if event.get("event") == "progress" and event.get("unit") == "steps")
    assert len(expected) > 1 and total_steps > 80, (expected, total_steps)
    print(f"uninterrupted: {duration:.1f} s, {total_steps:.0f} steps, {len(expected)} files, stages {' '.join(stages)}")

    site, at_points = Site("killed"), set()
    kill_in_optimizer(site, total_steps)
    site.finish(expected)
    site.wipe()
    kill_while_checkpoints_change(site)
    site.finish(expected)
    # At every publishing step, each time in another stage.
    for number, point in enumerate(PUBLISHING + OTHER_POINTS):
        site.wipe()
        if site.run(FRESCO_FAULT=point if point.startswith("export") else f"{point}@{stages[number % len(stages)]}")[0]:
            at_points.add(point)
        if number % 3 == 2:
            site.finish(expected)
    site.finish(expected)
    if LONG:
        site.wipe()
        spread_kills(site, stages, duration, expected)

    print(f"{site.landed} kills landed, {site.in_optimizer} inside the optimizer after its first checkpoint, "
          f"publishing steps: {' '.join(sorted(at_points))}")
    missing, least = set(PUBLISHING) - at_points, (50, 15) if LONG else (18, 5)
    if site.landed < least[0] or site.in_optimizer < least[1] or missing:
        sys.exit(f"too few kills landed: {least[0]}, {least[1]} and every publishing step are wanted; missing: {missing}")


try:
    main()
finally:
    shutil.rmtree(WORK, ignore_errors=True)
