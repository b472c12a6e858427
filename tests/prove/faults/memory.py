#!/usr/bin/env python3
"""Any allocation of the host may fail, one or all from then on: the command ends in order, with an exit code and a message that are
documented, or its result is right; the store stays valid, and the next run gives the bytes of a run without faults.
"""
import random

import shimmed
from shimmed import Fault
from workplace import arguments, some_of

SHORT_CASES = 40
FIRST_CASES, SAMPLED_CASES = 200, 500
# What is run, and whether it is the output that must be right.
COMMANDS = {
    "first run": (lambda place: place.run_command(), False),
    "run with nothing to do": (lambda place: place.run_command(), False),
    "store verify": (lambda place: place.store_command("verify"), True),
    "check": (lambda place: ["check", place.pipeline, "--set", f"outside={place.outside}"], True),
    "plan": (lambda place: ["plan", place.pipeline, "--store", str(place.store), "--set", f"outside={place.outside}"], True),
    "describe": (lambda place: ["describe", "test.source"], True),
    "store gc": (lambda place: place.store_command("gc", "--keep-days", "0"), False),
}


def prepare(place):
    place.save("first run")
    place.must(place.run_command(plus=2))
    place.must(place.run_command())
    place.expected = place.files()
    place.text, place.counts = {}, {}
    for name in COMMANDS:
        if name != "first run":
            place.save(name)
    for name, (command, _) in COMMANDS.items():
        place.restore(name)
        (place.root / "count").write_bytes(bytes(8))
        ended = place.shimmed(command(place), {"MEMORY_COUNT": str(place.root / "count")})
        if ended.code != 0:
            raise Fault(f"{name} ends with {ended.code} with the shim:\n{ended.text}")
        place.text[name] = ended.text
        place.counts[name] = int.from_bytes((place.root / "count").read_bytes(), "little")


def attempt(place, case):
    name, number, on = case
    place.restore(name)
    command, told = COMMANDS[name]
    (place.root / "count").write_bytes(bytes(8))
    ended = place.shimmed(command(place), {"MEMORY_COUNT": str(place.root / "count"), "MEMORY_FAILS": f"{number} on" if on else str(number)})
    if ended.code not in (0, 1):
        raise Fault(f"ends with {ended.code}:\n{ended.text}")
    if ended.code == 1 and "memory" not in ended.text:
        raise Fault(f"does not say that memory is short:\n{ended.text}")
    if ended.code == 0 and told and ended.text != place.text[name]:
        raise Fault(f"prints other words:\n{ended.text}")
    if ended.code == 0 and "run" in name and place.files() != place.expected:
        raise Fault(f"says nothing, and the files are not right:\n{ended.text}")
    if (place.store / "format").exists():
        place.must(place.store_command("verify"))
    again = place.must(place.run_command())
    if place.files() != place.expected:
        raise Fault(f"the next run gives other files:\n{ended.text}\nthen\n{again.text}")
    place.must(place.store_command("verify"))


def sample(counts, count):
    chance = random.Random(1)
    names = list(counts)
    return [(name, chance.randrange(1, counts[name] + 1), on) for i in range((count + 1) // 2) for name in [names[i % len(names)]]
            for on in (False, True)][:count]


def main():
    given, total = arguments(__doc__, "shim"), 0

    def chosen(place):
        nonlocal total
        total = sum(place.counts.values())
        if not given.long:
            return sample(place.counts, SHORT_CASES)
        first = [("first run", number, on) for number in range(1, FIRST_CASES + 1) for on in (False, True)]
        return some_of(given, first + sample(place.counts, 2 * SAMPLED_CASES))

    faults, tried = shimmed.try_all(given, prepare, chosen, attempt)
    shimmed.finish(faults, f"{tried} cases of memory running out, of {total} allocations in {len(COMMANDS)} commands")


main()
