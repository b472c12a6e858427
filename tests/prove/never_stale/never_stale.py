#!/usr/bin/env python3
"""Random edits of everything that a result may depend on, each followed by a run in the same store. Every run must export what the model
of the pipeline says, and the stages that ran must be those whose inputs were never seen together before. One edit in eight is made while
a run is at work. Now and then a run in an empty store holds the model itself to the truth.

2 000 edits with --long; otherwise 20 s."""
import collections
import pathlib
import random
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from room import Room
from workplace import Budget, Workplace, arguments, finish

# Of a run during which something was edited: it may say so and end.
MAY_END_WITH = (0, 1, 3, 4)


def run(room, **places):
    words, where = room.where(**places)
    return room.place.call(*words, **where)


def run_beside_edit(room):
    """An edit while a run is at work; the stages that the run has made, and the edit."""
    room.replace = []
    words, where = room.where()
    process = room.place.start(*words, **where)
    time.sleep(random.random() * 0.15)
    name = room.edit(["bytes", "folder", "link", "option"])
    ended = room.place.end(process)
    if ended.code not in MAY_END_WITH or "bug" in ended.err:
        sys.exit(f"an edit during a run ({name}) ended it with {ended}")
    return ended.in_state("ran"), name + ", during a run"


def problems_of(room, ended, seen, may_be_seen):
    """What is wrong with a run, if anything: (stale, needless)."""
    if ended.code != 0:
        return f"the run ended with {ended}", ""
    made = room.model()
    wanted = {stage for stage, (identity, _) in made.items() if identity not in seen}
    ran = ended.in_state("ran")
    stale = room.wrong_files()
    if missing := wanted - ran - may_be_seen:
        stale.append(f"{sorted(missing)} did not run")
    return "; ".join(stale), f"{sorted(ran - wanted)} ran without need" if ran - wanted else ""


def main():
    given = arguments(__doc__)
    random.seed(given.seed)
    installed = given.fresco.parent.parent / "lib/fresco"
    plugins = [given.plugins / "good/test_stages.so", given.plugins / "sided/sided.so", installed / "command.so"]
    kinds, stale, needless, ran, clean = collections.Counter(), [], [], 0, 0
    with Workplace(given.fresco, plugins) as place:
        room, seen = Room(place, given.plugins), set()
        time.sleep(2.1)  # Now the stamps of all files are old enough to be relied on.
        budget = Budget(given.long, 2000, 17, 20)
        for number in budget:
            may_be_seen, kind = run_beside_edit(room) if random.random() < 0.125 else (set(), room.edit())
            kinds[kind] += 1
            ended = run(room)
            late, more = problems_of(room, ended, seen, may_be_seen)
            stale += [f"edit {number} ({kind}): {late}"] if late else []
            needless += [f"edit {number} ({kind}): {more}"] if more else []
            seen |= {identity for identity, _ in room.model().values()}
            ran += len(ended.in_state("ran"))
            if number % 100 == 99:
                clean += 1
                shutil.rmtree(place.work / "clean", ignore_errors=True)
                run(room, store="clean/store", out="clean/out")
                assert not (wrong := room.wrong_files("clean/out")), f"the model is wrong: {wrong}"
            if random.random() < 0.01:
                time.sleep(2.1)
            if len(stale) + len(needless) > 5:
                break
    edits = f"{budget.done} edits, {ran} stages ran, {clean} runs in an empty store"
    finish(stale + needless, f"seed {given.seed}: {edits}: {len(stale)} stale, {len(needless)} needless", kinds)


main()
