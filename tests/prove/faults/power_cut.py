#!/usr/bin/env python3
"""The power may fail at any moment: what then has its final name is whole, and the next run gives the right bytes.

All changes below the store and --out are recorded while a pipeline is run, interrupted, run again with other inputs and options, tidied
up, damaged and repaired. For each moment the states that a disk may hold are made by recording.py and checked: in Python all of them;
by the program, which verifies the store and runs the pipeline again, a choice.
"""
import bisect
import itertools
import json
import os
import random
import shutil
import subprocess

import recording
import shimmed
from shimmed import Fault
from workplace import arguments, some_of

SHORT_RANDOM_CASES = 25
SHORT_STRIDE = 12
LONG_RANDOM_CASES = 700
MOST_PENDING = 30
NEVER = 1 << 60


class Phase:
    """A command, and the run that is right when the power fails during it."""

    def __init__(self, command, after, outside, code=0):
        self.command, self.after, self.outside, self.code = command, after, outside, code


def phases(place):
    first = place.run_command(files=70)
    other = place.run_command(files=70, plus=2, before="number")
    again = place.run_command(files=70, plus=2, before="again")
    return [
        Phase(place.run_command(files=70, fail_at=3), first, "5\n", code=1),
        Phase(first, first, "3\n"),
        Phase(other, other, "3\n"),
        Phase(place.store_command("gc", "--keep-days", "0"), other, "3\n"),
        Phase(again, again, "3\n"),  # Reads a damaged result.
    ]


def prepare(place):
    """Records, and finds out what is right."""
    place.phases = phases(place)
    log = place.root / "recording"
    log.touch()
    begin = recording.Disk(place.state)
    shim = {"RECORD_ROOT": str(place.state), "RECORD_FILE": str(log)}
    place.begins, place.damaged = [], {}
    for phase in place.phases:
        place.outside.write_text(phase.outside)
        place.begins.append(len(recording.read_events(log)))
        if phase is place.phases[-1]:
            damage(place, shim)
        ended = place.shimmed(phase.command, shim)
        if ended.code != phase.code:
            raise Fault(f"{' '.join(map(str, phase.command))} ended with {ended.code} with the shim:\n{ended.text}")
    place.events = recording.read_events(log)
    learn(place, begin)
    place.cases = program_cases(place)
    for phase in place.phases:
        shutil.rmtree(place.state)
        place.outside.write_text(phase.outside)
        place.must(phase.after)
        phase.expected = place.files()


def damage(place, shim):
    """By a process that is recorded, too."""
    for manifest in place.store.glob("objects/*/manifest.json"):
        if json.loads(manifest.read_text())["stage"] == "sum":
            place.damaged["store/objects/" + manifest.parent.name] = place.begins[-1]
            subprocess.run(["sh", "-c", 'printf x 1<>"$1"', "sh", str(manifest.parent / "sum/table.json")], check=True,
                           env=dict(os.environ, LD_PRELOAD=str(place.shim), **shim))


def below(tree, folder):
    return {name: held for name, held in tree.items() if name.startswith(folder + "/") and held is not None}


def learn(place, disk):
    """What every file has held under its final name, and every result when it came into the store. Checks the recording."""
    place.root_inode = next(iter(disk.nodes))
    place.versions, place.results = {}, {}
    for event in place.events:
        disk.take(event)
        if event.change not in ("link", "rename"):
            continue
        path = event.other if event.change == "rename" else event.path
        node, name = disk.find(path), os.path.relpath(path, place.state)
        if isinstance(node, recording.File):
            place.versions.setdefault(name, set()).add(node.current)
        elif name.startswith("store/objects/"):
            place.results.setdefault(name, []).append(below(disk.everything(), name))
    model, there = disk.everything(), recording.read_tree(place.state)
    if model != there:
        wrong = sorted(name for name in model.keys() | there.keys() if model.get(name, 0) != there.get(name, 0))
        raise Fault(f"the recording is not complete: {wrong}")


def has_no_final_name(name):
    """Logs, journals and the figures of unfinished stages grow line by line, and each line is checked when it is read."""
    return (name.startswith(("store/tmp/", "store/logs/", "store/locks/", "store/runs/")) or name.endswith((".curves", ".share", ".jsonl"))
            or os.path.basename(name).startswith(shimmed.TEMPORARY))


def check(place, tree, number):
    """What is wrong with a state after that many events."""
    for name, held in tree.items():
        if held is None or isinstance(held, recording.Link) or has_no_final_name(name):
            continue
        if not name.startswith("store/objects/"):
            if held not in place.versions.get(name, ()):
                raise Fault(f"{name} is not whole")
        elif name.endswith("/manifest.json") and name.count("/") == 3:
            folder = os.path.dirname(name)
            if held not in place.versions[name]:
                raise Fault(f"{name} is not whole")
            files = {each: bytes_ for each, bytes_ in below(tree, folder).items() if each != name and not has_no_final_name(each)}
            if number <= place.damaged.get(folder, NEVER) and files not in place.results[folder]:
                raise Fault(f"{folder} has a manifest and is not whole")


def chosen_state(disk, how, chance):
    """One of the states after a cut at this moment."""
    pending = disk.pending
    if how == "nothing unsynced":
        return disk.after_cut([], lambda file: "none")
    if how == "everything":
        return disk.everything()
    if how == "the newest":
        return disk.after_cut(pending[-1:], lambda file: "zeros")
    if how == "all but the newest":
        return disk.after_cut(pending[:-1], lambda file: "torn")
    kept = [changes for changes in pending if chance.random() < 0.5]
    return disk.after_cut(kept, lambda file: chance.choice(["none", "all", "torn", "zeros"]))


HOWS = ["nothing unsynced", "everything", "the newest", "all but the newest", "by chance"]


def replay(place):
    """(number of events, disk) for each moment."""
    disk = recording.Disk(place.state, place.root_inode)
    yield 0, disk
    for number, event in enumerate(place.events, 1):
        disk.take(event)
        yield number, disk


def check_all(place, stride):
    """In Python: at each moment only one unsynced change missing, only one present, and the others of HOWS. `stride`: of how many
    moments one is looked at. How many states that are, and how many of them are wrong."""
    seen, chance, faults = set(), random.Random(1), 0
    for number, disk in itertools.islice(replay(place), 0, None, stride):
        some = disk.pending[-MOST_PENDING:]
        states = itertools.chain((disk.after_cut([changes], lambda file: "none") for changes in some),
                                 (disk.after_cut([each for each in disk.pending if each is not changes], lambda file: "all") for changes in some),
                                 (chosen_state(disk, how, chance) for how in HOWS))
        for tree in states:
            identity = hash(frozenset((name, held.target if isinstance(held, recording.Link) else held) for name, held in tree.items()))
            if identity in seen:
                continue
            seen.add(identity)
            try:
                check(place, tree, number)
            except Fault as fault:
                print(f"after {number} of {len(place.events)} changes: {fault}\n", flush=True)
                faults += 1
    return len(seen), faults


def begins_to_count(event):
    """A result or a checkpoint."""
    return event.change == "rename" and ("/store/objects/" in event.other or event.other.endswith(".dependencies"))


def program_cases(place):
    """(number of events, how, seed)."""
    chance = random.Random(2)
    by_chance = [(chance.randrange(len(place.events) + 1), HOWS[-1], seed) for seed in range(LONG_RANDOM_CASES)]
    if place.long:
        return [(number, how, 0) for number in range(len(place.events) + 1) for how in HOWS[:-1]] + by_chance
    return [(number, "the newest", 0) for number, event in enumerate(place.events, 1) if begins_to_count(event)] + by_chance[:SHORT_RANDOM_CASES]


def attempt(place, share):
    """Of the place's cases that which is at this share of them: recordings differ a little."""
    number, how, seed = place.cases[int(share * len(place.cases))]
    tree = next(chosen_state(disk, how, random.Random(seed)) for at, disk in replay(place) if at == number)
    shutil.rmtree(place.state)
    place.state.mkdir()
    recording.write_tree(tree, place.state)
    current = bisect.bisect_right(place.begins, number) - 1
    phase = place.phases[random.Random(number).choice([current, min(current + 1, len(place.phases) - 1)])]
    place.outside.write_text(phase.outside)
    where = f"after {number} of {len(place.events)} changes, {how} (seed {seed})"
    undamaged = number <= place.begins[-1]
    try:
        if undamaged and (place.store / "format").exists():
            place.must(place.store_command("verify"))
        ended = place.must(phase.after)
        if place.files() != phase.expected:
            raise Fault(f"the next run gives other files:\n{ended.text}")
        if undamaged:
            place.must(place.store_command("verify"))
    except Fault as fault:
        raise Fault(f"{where}: {fault}") from fault


def main():
    given, states, wrong = arguments(__doc__, "shim"), 0, 0

    def chosen(place):
        nonlocal states, wrong
        states, wrong = check_all(place, 1 if given.long else SHORT_STRIDE)
        return some_of(given, [each / len(place.cases) for each in range(len(place.cases))])

    faults, tried = shimmed.try_all(given, prepare, chosen, attempt)
    shimmed.finish(wrong + faults, f"{states} states of the disk after a power cut checked, {tried} of them by the program")


main()
