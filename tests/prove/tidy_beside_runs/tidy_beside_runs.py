#!/usr/bin/env python3
"""Four users of one store, who run pipelines that share results, call `store gc --keep-days 0`, and are killed with SIGKILL at random
moments. Whatever the last finished run of a pipeline came to must be there until the pipeline is run with other options: the same run
again makes nothing. At the end `store verify` finds nothing.

1 000 rounds with --long; otherwise 10 s."""
import collections
import pathlib
import random
import signal
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Budget, Workplace, arguments

USERS = 4
PIPELINE = """version: 1
vars: {one: 1, other: 1}
stages:
  base:  {type: test.source, value: "${one}"}
  pile:  {type: test.source, value: "${other}", folder: folder}
  sum:   {type: test.add, input: {left: base, right: pile}}
  more:  {type: test.add, input: {left: sum}, plus: USER}
  slow:  {type: test.slow, input: more, steps: 5, step_ms: 10}
  text:  {type: test.sink, input: slow, path: USER.txt, copies: 3}
"""


class Site:
    """The store, and what its users agree on."""

    def __init__(self, place, budget):
        self.place, self.budget = place, budget
        self.rounds, self.lock = iter(budget), threading.Lock()
        self.counts, self.problems = collections.Counter(), []
        self.may_run = threading.Event()
        self.may_run.set()
        self.tidying = threading.Lock()

    def next_round(self):
        with self.lock:
            return not self.problems and next(self.rounds, None) is not None

    def count(self, what):
        with self.lock:
            self.counts[what] += 1

    def fails(self, text):
        with self.lock:
            self.problems.append(text)


class User:
    def __init__(self, site, number, seed):
        self.thread = threading.Thread(target=self.use)
        self.site, self.number, self.random = site, number, random.Random(seed)
        self.pipeline = f"user_{number}.yaml"
        site.place.write(self.pipeline, PIPELINE.replace("USER", str(number)))
        self.finished = None  # Options of the last run, if it came to its end.

    def use(self):
        while self.site.next_round():
            kind = self.random.random()
            if kind < 0.25:
                self.tidy()
            elif kind < 0.5 and self.finished:
                self.run_again()
            else:
                self.run_other()
            time.sleep(self.random.random() * 0.05)

    def start(self, options):
        self.site.may_run.wait()
        words = [word for name, value in options.items() for word in ("--set", f"{name}={value}")]
        return self.site.place.start("run", self.pipeline, "--json-log", "--no-report", "--cores", "2", "--out", f"out_{self.number}", *words)

    def killed(self, process, likely, latest):
        """Kills it, or not; whether it did."""
        if self.random.random() >= likely:
            return False
        time.sleep(self.random.random() * latest)
        process.send_signal(signal.SIGKILL)
        return True

    def check(self, ended, options):
        """Whether a run came to the right bytes."""
        text = f"{options['one'] + options['other'] + self.number + 2 + 5:.6f}\n"
        files = [f"{self.number}.txt", *(f"copies/{i}.txt" for i in range(3))]
        if ended.code != 0:
            self.site.fails(f"a run with {options} ended with {ended}")
        elif any((found := (self.site.place.work / f"out_{self.number}" / file).read_text()) != text for file in files):
            self.site.fails(f"a run with {options} came to {found!r} instead of {text!r}")
        return not self.site.problems

    def run_other(self):
        options = {"one": self.random.randrange(3), "other": self.random.randrange(3)}
        self.finished = None
        process = self.start(options)
        killed = self.killed(process, 0.4, 0.4)
        ended = self.site.place.end(process)
        if killed and ended.code == -signal.SIGKILL:
            self.site.count("runs killed")
        elif self.check(ended, options):
            self.finished = options
            self.site.count("runs finished")

    def run_again(self):
        ended = self.site.place.end(self.start(self.finished))
        if not self.check(ended, self.finished):
            return
        self.site.count("runs finished that were run again")
        if made := ended.in_state("ran"):
            self.site.fails(f"lost of {self.pipeline} with {self.finished}: {sorted(made)}")

    def tidy(self):
        """While it looks for a moment without a run, nobody starts one; from its start on all may."""
        with self.site.tidying:
            self.site.may_run.clear()
            for _ in range(100):
                process = self.site.place.start("store", "gc", "--keep-days", "0")
                time.sleep(self.random.random() * 0.01)
                ended_before = process.poll() is not None and process.returncode == 1
                if not ended_before:
                    self.site.may_run.set()
                killed = self.killed(process, 0.3, 0.03)
                ended = self.site.place.end(process)
                if killed and ended.code == -signal.SIGKILL:
                    self.site.count("clean-ups killed")
                    break
                if ended.code == 0:
                    self.site.count("clean-ups finished")
                    break
                if ended.code != 1 or "a run is using the store" not in ended.err:
                    self.site.fails(f"a clean-up ended with {ended}")
                    break
            self.site.may_run.set()


def main():
    given = arguments(__doc__)
    seeds = random.Random(given.seed)
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so"]) as place:
        place.write("folder/a", "1")
        place.write("folder/b", "2")
        site = Site(place, Budget(given.long, 1000, 9, 20))
        users = [User(site, number, seeds.random()) for number in range(USERS)]
        while not users[0].finished and not site.problems:
            users[0].run_other()  # Makes the store.
        for user in users:
            user.thread.start()
        for user in users:
            user.thread.join()
        for user in users:
            if user.finished and not site.problems:
                user.run_again()
        verified = place.call("store", "verify")
        if verified.code != 0:
            site.fails(f"verify ended with {verified}")
        tidied = place.call("store", "gc", "--keep-days", "0")
        left = [str(file) for file in (place.work / ".fresco/tmp").iterdir()]
        if tidied.code != 0 or left:
            site.fails(f"the last clean-up ended with {tidied}, and left {left}")
        print("\n".join(f"  {count:5} {what}" for what, count in sorted(site.counts.items())))
        print("\n".join(site.problems))
        print(f"seed {given.seed}: {site.budget.done} rounds: {len(site.problems)} losses")
        sys.exit(bool(site.problems))


main()
