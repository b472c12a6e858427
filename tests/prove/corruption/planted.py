#!/usr/bin/env python3
"""Plants something else in place of every path that fresco uses in a store and the output folder:
links to a file and to a folder elsewhere, a link to nothing, a link to itself, a hard link, a folder, a FIFO, a socket. The paths are
those of a traced run, so a new one is covered. Then it runs. Nothing outside may change; the run ends within 20 s, with exit code 0 or
with an error that names a path of fresco's to remove; once the planted thing is removed, the next run is right.

With --long every path with every kind; otherwise 20 s of them, chosen at random. Skipped without strace, or where the system does not
allow tracing."""
import collections
import os
import pathlib
import random
import re
import shutil
import socket
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from corruption import Site, wrong_files
from workplace import PATHS, Budget, Workplace, arguments, finish, some_of, traced

# Names that nobody can know before.
RANDOM = re.compile(r"\.fresco-[0-9a-f]{32}|/tmp/.")


def make_victim(root):
    """Files of somebody else."""
    shutil.rmtree(root, ignore_errors=True)
    (root / "sub").mkdir(parents=True)
    for name in ("thesis.txt", "sub/step", "sub/manifest.json", "sub/piece_0.json", "sub/0"):
        (root / name).write_text("mine\n")


def state_of(root):
    return {path: (path.stat().st_mode, path.read_text() if path.is_file() else sorted(os.listdir(path))) for path in [root, *root.rglob("*")]}


def remove(path):
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def plant(kind, path, victim):
    remove(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if kind == "hard link":
        os.link(victim / "thesis.txt", path)
    elif kind == "folder":
        path.mkdir()
        (path / "mine.txt").write_text("mine")
    elif kind == "FIFO":
        os.mkfifo(path)
    elif kind == "socket":
        here = os.getcwd()
        os.chdir(path.parent)  # Its name must be short.
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
        os.chdir(here)
    else:
        targets = {"link to a file": victim / "thesis.txt", "link to a folder": victim / "sub", "link to nothing": victim / "new"}
        path.symlink_to(targets.get(kind, path))


KINDS = ("link to a file", "link to a folder", "link to nothing", "link to itself", "hard link", "folder", "FIFO", "socket")


class Garden:
    def __init__(self, place):
        self.place, self.site = place, Site(place)
        self.victim, self.roots = place.root / "victim", [place.work / ".fresco", place.work / "out"]
        make_victim(self.victim)
        self.before = state_of(self.victim)

    def put_back(self):
        self.site.put_back()
        shutil.rmtree(self.roots[1], ignore_errors=True)

    def commands(self, plus):
        """Every command that writes, in turn: a run that resumes, one that tidies, a task of a cluster."""
        yield "run", "room.yaml", "--cores", "4"
        yield "run", "room.yaml", "--cores", "4", "--set", "plus=2"
        yield "store", "gc"
        yield "run", "room.yaml", "--task", "once", "--set", f"plus={plus}"

    def paths(self):
        """Those that the commands use."""
        self.put_back()
        found = set(self.roots)
        for number, words in enumerate(self.commands(3)):
            done, lines = traced("planted", "file", [self.place.root / "bin/fresco", *words], self.place.root / f"trace-{number}",
                                 cwd=self.place.work, env=self.place.environment | {"ASAN_OPTIONS": "detect_leaks=0"})  # Not while traced.
            if done.returncode != 0:
                sys.exit(f"{' '.join(words)} ended with {done.returncode}: {done.stderr}")
            for line in lines:
                for folder, name in PATHS.findall(line):
                    path = pathlib.Path(os.path.normpath(os.path.join(folder or self.place.work, name)))
                    if any(root in path.parents for root in self.roots) and not RANDOM.search("/" + str(path.relative_to(self.place.root))):
                        found.add(path)
        return sorted(found)

    def run_all(self, plus):
        """The first command that does not end with 0; nothing if all do."""
        for words in self.commands(plus):
            ended = self.place.end(self.place.start(*words), patience=30)
            if ended.code != 0:
                return words, ended
        return None

    def try_one(self, kind, path):
        """What is wrong, if anything; and whether the planted thing stopped a command."""
        what = f"{kind} at {path.relative_to(self.place.root)}"
        self.put_back()
        plant(kind, path, self.victim)
        stopped = self.run_all(3)
        problems = []
        if stopped:
            words, ended = stopped
            text = ended.text
            if ended.code not in (1, 2) or ended.seconds > 20 or "report it" in text or "terminate" in text:
                problems.append(f"{what}: '{' '.join(words)}' ended after {ended.seconds:.0f} s with {ended}")
            elif str(path.relative_to(self.place.root)) not in text or not re.search("remove it|move it away|--out", text):
                problems.append(f"{what}: the error does not say what to remove: {ended}")
            remove(path)
            if again := self.run_all(4):
                problems.append(f"{what}: removed, and '{' '.join(again[0])}' still ended with {again[1]}")
        shutil.rmtree(self.place.work / "out", ignore_errors=True)
        ended = self.place.call("run", "room.yaml", "--no-report")
        if state_of(self.victim) != self.before:
            make_victim(self.victim)
            problems.append(f"{what}: files elsewhere changed")
        if ended.code != 0 or (wrong := wrong_files(self.place.work / "out", 1)):
            problems.append(f"{what}: afterward {wrong if ended.code == 0 else 'the run'} is not right: {ended}")
        return problems, bool(stopped)


def main():
    given = arguments(__doc__)
    random.seed(given.seed)
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so"]) as place:
        garden = Garden(place)
        paths = garden.paths()
        if len(paths) < 40:
            sys.exit(f"only {len(paths)} paths were seen: this test looks in the wrong place")
        cases = [(kind, path) for path in paths for kind in KINDS if path not in garden.roots]
        random.shuffle(cases)
        problems, counts, stops = [], collections.Counter(), 0
        budget = Budget(given.long, len(cases), 20, 10)
        for _, (kind, path) in zip(budget, some_of(given, cases) if given.long else cases):
            found, stopped = garden.try_one(kind, path)
            problems += found
            stops += stopped
            counts[kind] += 1
        planted = f"{sum(counts.values())} things planted at {len(paths)} paths, {stops} named by an error"
        finish(problems, f"seed {given.seed}: {planted}: {len(problems)} problems", counts)


main()
