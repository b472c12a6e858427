#!/usr/bin/env python3
"""Every call that changes or opens a file may fail: the run says so, or its result is right. Nothing bad is published, and the next
run gives the bytes of a run without faults.

For each scenario the calls of each kind are counted, in the host, its workers and helpers and the programs they run; then the
scenario is run once per call and error.
"""
import errno
import json
import random
import shutil

import shimmed
from shimmed import Fault
from workplace import arguments, some_of

SHORT_CASES = 110
ERRORS = {
    "open": [errno.EIO, errno.EMFILE, errno.EINTR],
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


class Scenario:
    """`before` brings a workplace to where the command is tried; `after` is the run that must then give the right files."""

    def __init__(self, name, before, command, after=None, damaged=False, cold=False):
        self.name, self.before, self.command, self.after = name, before, command, after or command
        self.damaged, self.cold = damaged, cold


def nothing(place):
    del place


def unfinished(place):
    """Results and exports of other settings, and a checkpoint made from other contents of a file."""
    place.must(place.run_command(plus=2))
    place.outside.write_text("5\n")
    place.must(place.run_command(fail_at=3), code=1)
    place.outside.write_text("3\n")


def superseded(place):
    for plus in (2, 1):
        place.must(place.run_command(plus=plus))


def damaged(place):
    place.must(place.run_command(plus=1))
    for manifest in sorted(place.store.glob("objects/*/manifest.json")):
        if json.loads(manifest.read_text())["stage"] == "sum":
            with open(manifest.parent / "sum/table.json", "r+b") as file:
                file.write(b"x")


def lent(place):
    place.must(place.run_command())
    place.store.rename(place.lender)
    shutil.rmtree(place.out)


SCENARIOS = [
    Scenario("first run", nothing, lambda place: place.run_command(), cold=True),
    Scenario("run after others", unfinished, lambda place: place.run_command()),
    Scenario("run on a damaged result", damaged, lambda place: place.run_command(before="again"), damaged=True),
    Scenario("store gc", superseded, lambda place: place.store_command("gc", "--keep-days", "0"), lambda place: place.run_command()),
    Scenario("store verify --remove", damaged, lambda place: place.store_command("verify", "--remove"), lambda place: place.run_command(before="again"),
             damaged=True),
    Scenario("run that borrows", lent, lambda place: [*place.run_command(), "--upstream", str(place.lender)]),
    Scenario("store copy", lent, lambda place: ["store", "copy", str(place.lender), str(place.store)], lambda place: place.run_command()),
]


def prepare(place):
    """The states to begin with, and what comes of a run without faults."""
    place.expected, place.earlier, place.left, place.counts = {}, {}, {}, {}
    for scenario in SCENARIOS:
        for folder in place.state.iterdir():
            shutil.rmtree(folder)
        if not scenario.cold:
            scenario.before(place)
        place.save(scenario.name)
        place.earlier[scenario.name] = place.files()
        place.use_cache(place.state / "cache" if scenario.cold else place.root / "cache")
        place.counts[scenario.name] = place.calls(scenario.command(place))
        place.left[scenario.name] = place.objects()
        place.must(scenario.after(place))
        place.expected[scenario.name] = place.files()
        place.use_cache(place.root / "cache")


def attempt(place, case):
    scenario, role, kind, number, error = case
    scenario = next(each for each in SCENARIOS if each.name == scenario)
    place.restore(scenario.name)
    place.use_cache(place.state / "cache" if scenario.cold else place.root / "cache")
    expected, earlier = place.expected[scenario.name], place.earlier[scenario.name]
    variables = place.count_variables()
    variables["FAULT_CALL"] = f"{shimmed.ROLES.index(role)} {shimmed.KINDS.index(kind)} {number} {error}"
    ended = place.shimmed(scenario.command(place), variables)
    check_end(place, scenario, ended, role, error)
    for name, contents in place.files().items():
        if contents not in (expected.get(name), earlier.get(name)):
            raise Fault(f"{name} has other bytes:\n{ended.text}")
    if not scenario.damaged and (place.store / "format").exists():
        place.must(place.store_command("verify"))
    again = place.must(scenario.after(place))
    if place.files() != expected:
        raise Fault(f"the next run gives other files:\n{ended.text}\nthen\n{again.text}")
    for store in (place.store, place.lender):
        if store.exists():
            place.must(["store", "verify", "--store", str(store)])


def check_end(place, scenario, ended, role, error):
    if ended.code not in shimmed.EXIT_CODES:
        raise Fault(f"ends with {ended.code}:\n{ended.text}")
    for word in ("a bug", "author of the plugin"):
        if word in ended.text:
            raise Fault(f"blames the wrong one:\n{ended.text}")
    if ended.code != 0 and "error:" not in ended.text and "damaged" not in ended.text:
        raise Fault(f"ends with {ended.code} and says no error:\n{ended.text}")
    if ended.code != 0 and error in (errno.EINTR, 0) and role != "program":
        raise Fault(f"an interrupted or short call was not repeated:\n{ended.text}")
    if ended.code == 0 and scenario.command is scenario.after and place.files() != place.expected[scenario.name]:
        raise Fault(f"says nothing, and the files are not right:\n{ended.text}")
    # A stage whose result cannot be borrowed runs, and needs the results that it reads.
    left = place.left[scenario.name]
    if ended.code == 0 and not left <= place.objects() <= left | place.objects(place.lender):
        raise Fault(f"says nothing, and leaves other results in the store:\n{ended.text}")


def all_cases(counts):
    return [(scenario.name, role, kind, number, error) for scenario in SCENARIOS for (role, kind), count in counts[scenario.name].items()
            for number in range(1, count + 1) for error in ERRORS[kind]]


def sample(cases, count):
    """A fixed choice, first one of each scenario, role and kind."""
    order = list(cases)
    random.Random(1).shuffle(order)
    first, rest, seen = [], [], set()
    for case in order:
        (rest if case[:3] in seen else first).append(case)
        seen.add(case[:3])
    return (first + rest)[:count]


def main():
    given, total = arguments(__doc__, "shim"), 0

    def chosen(place):
        nonlocal total
        cases = all_cases(place.counts)
        total = len(cases)
        return some_of(given, cases) if given.long else sample(cases, SHORT_CASES)

    faults, tried = shimmed.try_all(given, prepare, chosen, attempt)
    shimmed.finish(faults, f"{tried} of {total} failing calls in {len(SCENARIOS)} scenarios")


main()
