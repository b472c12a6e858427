#!/usr/bin/env python3
"""Damages the files of a store one at a time: a byte changed, the file cut, names exchanged with another of its kind.
Each time the next runs must end with exit code 0 and the right bytes: one as before, whose exports are made again, and one with another
option, which reads the results upstream; the first writes its report too. The store holds finished results, and the checkpoint and kept
pieces of stages that were killed.

With --long, 1 000 changed bytes spread over all kinds, one file of each cut at every length (one of more than 2 000 bytes at 40), and
every pair of names; otherwise 12 s. That a record or a checked file is refused with every byte changed is a test of its own
(test_file_stamp.cpp, test_files_io.cpp)."""
import collections
import functools
import itertools
import pathlib
import random
import re
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Budget, Workplace, arguments, finish, some_of

PIPELINE = """version: 1
vars: {plus: 1}
stages:
  base:   {type: test.source, value: 1, file: extra}
  pile:   {type: test.source, value: 2, folder: folder}
  sum:    {type: test.add, input: {left: base, right: pile}}
  more:   {type: test.add, input: {left: sum}, plus: "${plus}"}
  text:   {type: test.sink, input: more, path: text.txt, copies: 2}
  slow:   {type: test.slow, steps: 6, step_ms: STEP}
  pieces: {type: test.pieces, count: 4, wait_ms: STEP}
  count:  {type: test.sink, input: slow, path: count.txt}
"""


def wrong_files(out, plus):
    """Files of a run that do not hold what they should, with what they hold."""
    text = f"{8 + plus:.6f}\n"
    expected = {"text.txt": text, "copies/0.txt": text, "copies/1.txt": text, "count.txt": "6.000000\n"} | {
        f"piece_{i}.txt": f"piece {i}\n" for i in range(4)}
    return {name: found for name, text in expected.items() if (found := (out / name).read_text()) != text}


class Site:
    """A working folder with a store that is put back as it was before each case."""

    def __init__(self, place):
        self.place, self.work = place, place.work
        place.write("extra", "123")
        place.write("folder/a", "1")
        place.write("folder/b", "2")
        self.store, self.kept = self.work / ".fresco", place.root / "kept"
        time.sleep(2.1)  # Now the stamps are old enough to be relied on.
        place.write("room.yaml", PIPELINE.replace("STEP", "3000"))
        first = place.run("--no-report", "--until", "text")
        if first.code != 0:
            sys.exit(f"the first run ended with {first}")
        process = place.start("run", "room.yaml", "--quiet", "--no-report", "--cores", "4")
        checkpoints = self.work / ".fresco/checkpoints"
        while not (list(checkpoints.glob("*/piece_1.json")) and list(checkpoints.glob("*/step"))):
            if process.poll() is not None:
                sys.exit(f"the run ended before it could be killed: {process.stderr.read()}")
            time.sleep(0.01)
        process.kill()
        process.communicate()
        place.write("room.yaml", PIPELINE.replace("STEP", "0"))
        time.sleep(0.2)  # Until the stages' processes have noticed.
        shutil.copytree(self.store, self.kept, symlinks=True)
        self.kinds = collections.defaultdict(list)
        for file in sorted(self.kept.rglob("*")):
            if file.is_file() and not file.is_symlink() and file.stat().st_size > 0:
                self.kinds[self.kind_of(file)].append(file)

    def kind_of(self, file):
        """What it is by its path, without what differs between files of a kind."""
        path = re.sub(r"[0-9a-f]{16,}", "ID", str(file.relative_to(self.kept)))
        return re.sub(r"\d+|(?<=stages/ID/)\w+", "N", path)

    def write(self, file, data):
        """Other bytes for a kept file, in the place where the program sees it."""
        (self.store / file.relative_to(self.kept)).write_bytes(data)

    def exchange(self, one, other):
        names = [self.store / file.relative_to(self.kept) for file in (one, other)]
        aside = names[0].parent / "aside"
        for source, target in ((names[0], aside), (names[1], names[0]), (aside, names[1])):
            source.rename(target)

    def put_back(self):
        shutil.rmtree(self.store)
        shutil.copytree(self.kept, self.store, symlinks=True)

    def check(self, what):
        """Runs; what is wrong, if anything."""
        for plus in (1, 2):
            shutil.rmtree(self.work / "out", ignore_errors=True)
            ended = self.place.run("--set", f"plus={plus}", "--cores", "4", *([] if plus == 1 else ["--no-report"]))
            if ended.code != 0:
                return [f"{what}: the run with plus={plus} ended with {ended}"]
            if wrong := wrong_files(self.work / "out", plus):
                return [f"{what}: with plus={plus} these are wrong: {wrong}"]
        return []


def flips(site, kinds):
    """Endlessly: a kind after the other, a byte of a random file of it."""
    for kind in itertools.cycle(kinds):
        file = random.choice(site.kinds[kind])
        data = bytearray(file.read_bytes())
        at, change = random.randrange(len(data)), random.choice([1, 2, 4, 8, 16, 32, 64, 128, random.randrange(1, 256)])
        data[at] ^= change
        yield kind, f"{file.name}, byte {at} changed by {change}", functools.partial(site.write, file, data)


def cuts(site, kinds, many):
    """One file of each kind, cut at every length, or at one. A record's checksum is at its end."""
    for kind in kinds:
        file = random.choice(site.kinds[kind])
        data = file.read_bytes()
        lengths = list(range(len(data)))
        if len(lengths) > 2000:
            lengths = lengths[:10] + random.sample(lengths[10:-10], 20) + lengths[-10:]
        for length in lengths if many else random.sample(lengths, 1):
            yield kind, f"{file.name}, cut to {length} of {len(data)} bytes", functools.partial(site.write, file, data[:length])


def swaps(site):
    """Pairs of names in a folder: of files, and of folders."""
    folders = sorted(entry for entry in site.kept.rglob("*") if entry.is_dir())
    pairs = [(one, other) for folder in folders for one, other in itertools.combinations(sorted(folder.iterdir()), 2)
             if one.is_dir() == other.is_dir()]
    random.shuffle(pairs)
    for one, other in pairs:
        yield "names exchanged", f"{one.relative_to(site.kept)} and {other.name}", functools.partial(site.exchange, one, other)


def main():
    given = arguments(__doc__)
    random.seed(given.seed)
    plugins = [given.plugins / "good/test_stages.so"]
    with Workplace(given.fresco, plugins) as place:
        site = Site(place)
        kinds = sorted(site.kinds)
        random.shuffle(kinds)
        flipped, cut, swapped = flips(site, kinds), cuts(site, kinds, given.long), swaps(site)
        if given.long:
            cases = some_of(given, [*itertools.islice(flipped, 1000), *cut, *swapped])
        else:
            cases = itertools.chain.from_iterable(zip(flipped, cut, swapped))
        problems, counts = [], collections.Counter()
        budget = Budget(given.long, 10**9, 12, 10)
        for _, (kind, what, damage) in zip(budget, cases):
            site.put_back()
            damage()
            counts[kind] += 1
            problems += site.check(f"{kind}: {what}")
        damages = f"{sum(counts.values())} damages to {len(kinds)} kinds of files"
        finish(problems, f"seed {given.seed}: {damages}: {len(problems)} served, or a failure", counts)


if __name__ == "__main__":
    main()
