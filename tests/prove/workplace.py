"""For the proofs that run the program: a folder with a copy of it, its library and plugins of its own, and nothing of the user's."""
import argparse
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from skipping import skip


def arguments(description, *more):
    """FRESCO TEST_PLUGINS and `more` paths, [--long [--cases N]] [--seed N]; the plugins' folder is the build's tests/plugins."""
    parser = argparse.ArgumentParser(description=description)
    for name in ("fresco", "plugins", *more):
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--long", action="store_true", help="every case")
    parser.add_argument("--cases", type=int, metavar="N", help="with --long: N of them, chosen at random; not of proofs that count in rounds")
    parser.add_argument("--seed", type=int, help="of the random choices; default: 1, with --long another each time")
    given = parser.parse_args()
    if given.seed is None:
        given.seed = int(time.time()) if given.long else 1
    return given


def some_of(given, cases):
    """All of a long form's cases, or as many as --cases says."""
    return random.Random(given.seed).sample(cases, min(given.cases, len(cases))) if given.cases else cases


# A path in a call, and the folder that it is relative to, as strace -y shows it.
PATHS = re.compile(r'(?:(?:AT_FDCWD|\d+)<((?:[^<>\\]|\\.)*)>, )?"((?:[^"\\]|\\.)*)"')


def finish(problems, figures, counts={}):
    """Ends a proof."""
    for what, count in sorted(counts.items()):
        print(f"  {count:5} {what}")
    print("\n".join([*problems[:50], figures]))
    sys.exit(bool(problems))


def traced(proof, calls, words, record, **where):
    """Runs a program under strace; gives how it ended, and the lines about these calls, from a file `record`.PID for each process. Ends
    the proof, as skipped, without strace or where the system does not allow tracing."""
    if not shutil.which("strace"):
        skip(f"{proof}: strace is not installed")
        sys.exit(0)
    done = subprocess.run(["strace", "-ff", "--seccomp-bpf", "-y", "-s", "4096", "-o", str(record), "-e", f"trace={calls}", "-e", "signal=none",
                           *map(str, words)], stdin=subprocess.DEVNULL, capture_output=True, text=True, **where)
    if "PTRACE" in done.stderr or "Operation not permitted" in done.stderr:
        skip(f"{proof}: strace cannot trace here: {done.stderr.strip()}")
        sys.exit(0)
    return done, [line for file in sorted(record.parent.glob(f"{record.name}.*")) for line in file.read_text(errors="replace").splitlines()]


class Budget:
    """Rounds until `seconds` are over, at least `least`; with --long exactly `rounds`."""

    def __init__(self, long, rounds, seconds, least):
        self.long, self.rounds, self.least = long, rounds, least
        self.done, self.end = 0, time.monotonic() + seconds

    def __iter__(self):
        while self.done < self.rounds and (self.long or self.done < self.least or time.monotonic() < self.end):
            yield self.done
            self.done += 1


class Ended:
    """A run that has ended."""

    def __init__(self, code, out, err, seconds):
        self.code, self.out, self.err, self.seconds = code, out, err, seconds
        self.stages = {}
        for line in out.splitlines():
            try:
                event = json.loads(line)
            except json.JSONDecodeError:
                continue
            if isinstance(event, dict) and event.get("event") == "summary":
                self.stages = {stage["stage"]: stage for stage in event["stages"]}

    def in_state(self, state):
        return {name for name, stage in self.stages.items() if stage["state"] == state}

    @property
    def text(self):
        return self.err + self.out

    def __str__(self):
        return f"exit code {self.code}\n{self.err}{self.out[-3000:]}"


class Workplace:
    """bin/fresco, lib/ with its library, plugins/ with copies of the named ones, work/ as the working folder."""

    def __init__(self, fresco, plugins, parent=None):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="fresco-prove-", dir=parent)).resolve()
        self.work, self.plugins = self.root / "work", self.root / "plugins"
        for folder in ("bin", "lib", "plugins", "work", "home", "tmp"):
            (self.root / folder).mkdir()
        shutil.copy2(fresco, self.root / "bin/fresco")
        shutil.copy2(fresco.parent.parent / "lib/libfresco_sdk.so.0", self.root / "lib/libfresco_sdk.so.0")
        (self.root / "share").symlink_to(fresco.parent.parent / "share")  # The pictures of `init` and `new`.
        for name in plugins:
            for file in (pathlib.Path(name), pathlib.Path(name).with_suffix(".json")):
                shutil.copy2(file, self.plugins / file.name)
        self.environment = {"PATH": os.environ["PATH"], "HOME": str(self.root / "home"), "XDG_DATA_HOME": str(self.root / "home/data"),
                            "TMPDIR": str(self.root / "tmp"), "LC_ALL": "C.UTF-8",
                            "FRESCO_PLUGIN_PATH": str(self.plugins)}
        self.environment |= {name: os.environ[name] for name in ("LD_PRELOAD", "ASAN_OPTIONS") if name in os.environ}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.root, ignore_errors=True)

    def start(self, *words, folder=None, environment=None):
        return subprocess.Popen([str(self.root / "bin/fresco"), *map(str, words)], cwd=folder or self.work, text=True, errors="replace",
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                env=self.environment | (environment or {}))

    @staticmethod
    def end(process, begin=None, patience=300):
        begin = begin or time.monotonic()
        try:
            out, err = process.communicate(timeout=patience)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            out, err = process.communicate()
            err += f"\nstill running after {patience} s"
        return Ended(process.returncode, out, err, time.monotonic() - begin)

    def call(self, *words, **where):
        begin = time.monotonic()
        return self.end(self.start(*words, **where), begin)

    def run(self, *words, **where):
        """`fresco run room.yaml --json-log …`"""
        return self.call("run", "room.yaml", "--json-log", *words, **where)

    def write(self, name, text):
        file = self.work / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file
