#!/usr/bin/env python3
"""Every call that changes or opens a file may fail: the run says so, or its result is right. Nothing bad is published, and the next
run gives the bytes of a run without faults.

For each scenario the calls of each kind are counted; then the scenario is run once per call and error. Without --long, 30 s of them,
chosen at random, first one of each scenario and kind."""
import errno
import json
import os
import pathlib
import random
import shutil
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Budget, Workplace, arguments, finish, some_of

# Small stages of every kind that writes: a result, a checkpoint, an export, more files than are synced one by one.
PIPELINE = """version: 1
vars: {outside: outside.txt, plus: 1, before: value, fail_at: 0}
stages:
  source: {type: test.source, file: input.txt}
  count: {type: test.slow, input: source, steps: 4, step_ms: 0, file: "${outside}", fail_at: "${fail_at}"}
  sum: {type: test.add, input: {left: count}, plus: "${plus}"}
  write: {type: test.sink, input: sum, path: value.txt, copies: 70, before: "${before}"}
"""
ERRORS = {
    "open": [errno.EIO, errno.EMFILE, errno.EINTR],  # The order is that of calls.c.
    "list": [errno.EIO, errno.EMFILE],  # The standard library opens folders, and does not repeat it.
    "write": [errno.EIO, errno.ENOSPC, errno.EINTR, 0],  # 0: only half of the bytes
    "sync": [errno.EIO, errno.ENOSPC, errno.EINTR],
    "rename": [errno.EIO, errno.ENOSPC],
    "link": [errno.EIO, errno.ENOSPC, errno.EPERM],
    "unlink": [errno.EIO],
    "mkdir": [errno.EIO, errno.ENOSPC],
    "lock": [errno.ENOLCK, errno.EINTR],
    "truncate": [errno.EIO, errno.EINTR],
    "close": [errno.EIO, errno.EINTR],
}
KINDS = list(ERRORS)
REPORTS = {"run.json", "report.html", "progress.jsonl"}  # They tell times and places.


class Site:
    """A store and an output folder that can be put back."""

    def __init__(self, place, shim):
        self.place, self.shim = place, shim.resolve()
        place.write("room.yaml", PIPELINE)
        place.write("input.txt", "12345\n")
        self.outside = place.write("outside.txt", "3\n")
        self.state, self.counts = place.root / "state", place.root / "counts"
        self.store, self.out = self.state / "store", self.state / "out"
        self.state.mkdir()

    def run_command(self, **sets):
        """On one core the order of the calls is the same each time."""
        words = ["run", "room.yaml", "--out", self.out, "--store", self.store, "--cores", "1"]
        return words + [word for name, value in sets.items() for word in ("--set", f"{name}={value}")]

    def store_command(self, *words):
        return ["store", *words, "--store", self.store]

    def must(self, command, code=0):
        ended = self.place.call(*command)
        assert ended.code == code, f"{' '.join(map(str, command))} ended with {ended}, not with {code}"
        return ended

    def shimmed(self, command, **variables):
        self.counts.write_bytes(bytes(8 * len(KINDS)))
        return self.place.call(*command, environment={"LD_PRELOAD": str(self.shim), "FAULT_COUNTS": str(self.counts), **variables})

    def files(self):
        """What the run made for the user: name -> bytes."""
        return {str(file.relative_to(self.out)): file.read_bytes() for file in sorted(self.out.rglob("*"))
                if file.is_file() and file.name not in REPORTS and not file.name.startswith(".fresco-")}

    def objects(self):
        return {file.parent.name for file in (self.store / "objects").glob("*/manifest.json")}

    # What stands before a scenario.

    def unfinished(self):
        """Results and exports of other settings, and a checkpoint made from other contents of a file."""
        self.must(self.run_command(plus=2))
        self.outside.write_text("5\n")
        self.must(self.run_command(fail_at=3), code=1)
        self.outside.write_text("3\n")

    def superseded(self):
        for plus in (2, 1):
            self.must(self.run_command(plus=plus))

    def damaged(self):
        self.must(self.run_command())
        for manifest in self.store.glob("objects/*/manifest.json"):
            if json.loads(manifest.read_text())["stage"] == "sum":
                with open(manifest.parent / "sum/table.json", "r+b") as file:
                    file.write(b"x")


class Scenario:
    """`before` brings a site to where the command is tried; `after` is the run that must then give the right files."""

    def __init__(self, name, site, before, command, after=None):
        self.name, self.site, self.command, self.after = name, site, command, after or command
        self.damaged = before == site.damaged
        self.saved = site.place.root / "saved" / name
        shutil.rmtree(site.state)
        site.state.mkdir()
        before()
        shutil.copytree(site.state, self.saved, symlinks=True)
        self.earlier = site.files()
        self.begin()
        ended = site.shimmed(command)
        assert ended.code == 0, f"{name} ended with the shim with {ended}"
        self.calls = dict(zip(KINDS, struct.unpack(f"{len(KINDS)}Q", site.counts.read_bytes())))
        self.left = site.objects()
        site.must(self.after)
        self.expected = site.files()

    def begin(self):
        shutil.rmtree(self.site.state)
        shutil.copytree(self.saved, self.site.state, symlinks=True)

    def cases(self):
        return [(self, kind, number, error) for kind, count in self.calls.items() for number in range(1, count + 1) for error in ERRORS[kind]]

    def attempt(self, kind, number, error):
        site = self.site
        self.begin()
        ended = site.shimmed(self.command, FAULT_CALL=f"{KINDS.index(kind)} {number} {error}")
        self.check_end(ended, error)
        for name, contents in site.files().items():
            assert contents in (self.expected.get(name), self.earlier.get(name)), f"{name} has other bytes: {ended}"
        if not self.damaged and (site.store / "format").exists():
            site.must(site.store_command("verify"))
        again = site.must(self.after)
        assert site.files() == self.expected, f"the next run gives other files: {ended}\nthen {again}"
        site.must(site.store_command("verify"))

    def check_end(self, ended, error):
        assert ended.code in (0, 1, 2, 3, 4), f"it ends with {ended}"
        assert not any(word in ended.text for word in ("a bug", "author of the plugin")), f"it blames the wrong one: {ended}"
        if ended.code != 0:
            assert "error:" in ended.text or "damaged" in ended.text, f"it says no error: {ended}"
            assert error not in (errno.EINTR, 0), f"an interrupted or short call was not repeated: {ended}"
        else:
            assert self.command is not self.after or self.site.files() == self.expected, f"it says nothing, and the files are not right: {ended}"
            assert self.site.objects() == self.left, f"it says nothing, and leaves other results in the store: {ended}"


def scenarios(site):
    again = site.run_command(before="again")
    return [
        Scenario("first run", site, lambda: None, site.run_command()),
        Scenario("run after others", site, site.unfinished, site.run_command()),
        Scenario("run on a damaged result", site, site.damaged, again),
        Scenario("store gc", site, site.superseded, site.store_command("gc", "--keep-days", "0"), site.run_command()),
    ]


def main():
    given = arguments(__doc__, "shim")
    memory = pathlib.Path("/dev/shm")
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so", given.plugins / "pictures/text_pictures.so"],
                   parent=memory if os.access(memory, os.W_OK) else None) as place:
        cases = [case for scenario in scenarios(Site(place, given.shim)) for case in scenario.cases()]
        random.Random(given.seed).shuffle(cases)
        first = {case[:2]: case for case in cases}
        chosen = some_of(given, cases) if given.long else [*first.values(), *cases]
        budget, faults = Budget(given.long, len(chosen), 30, len(first)), []
        for _, (scenario, *call) in zip(budget, chosen):
            try:
                scenario.attempt(*call)
            except AssertionError as fault:
                faults.append(f"{scenario.name}, {call}: {fault}\n")
    finish(faults, f"seed {given.seed}: {budget.done} of {len(cases)} failing calls: {len(faults)} faults")


main()
