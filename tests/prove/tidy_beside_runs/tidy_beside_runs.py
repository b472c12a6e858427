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
from workplace import Budget, Workplace, arguments, finish

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


class User:
    """Runs a pipeline of its own, and cleans up."""
    rounds, lock, tidying, may_run = iter(()), threading.Lock(), threading.Lock(), threading.Event()
    counts, problems = collections.Counter(), []

    def __init__(self, place, number, seed):
        self.thread = threading.Thread(target=self.use)
        self.place, self.number, self.random = place, number, random.Random(seed)
        self.pipeline = f"user_{number}.yaml"
        place.write(self.pipeline, PIPELINE.replace("USER", str(number)))
        self.finished = None  # Options of the last run, if it came to its end.

    def use(self):
        while not self.problems:
            with self.lock:
                if next(User.rounds, None) is None:
                    return
            kind = self.random.random()
            if kind < 0.25:
                self.tidy()
            elif kind < 0.5 and self.finished:
                self.run_again()
            else:
                self.run_other()
            time.sleep(self.random.random() * 0.05)

    def start(self, options):
        self.may_run.wait()
        words = [word for name, value in options.items() for word in ("--set", f"{name}={value}")]
        return self.place.start("run", self.pipeline, "--json-log", "--no-report", "--cores", "2", "--out", f"out_{self.number}", *words)

    def killed(self, process, likely, latest):
        """Kills it, or not; whether it did."""
        if self.random.random() >= likely:
            return False
        time.sleep(self.random.random() * latest)
        process.send_signal(signal.SIGKILL)
        return True

    def came_to_its_end(self, ended, options):
        """Whether a run came to the right bytes."""
        text = f"{options['one'] + options['other'] + self.number + 2 + 5:.6f}\n"
        files = [f"{self.number}.txt", *(f"copies/{i}.txt" for i in range(3))]
        if ended.code != 0:
            self.problems.append(f"a run with {options} ended with {ended}")
        elif any((found := (self.place.work / f"out_{self.number}" / file).read_text()) != text for file in files):
            self.problems.append(f"a run with {options} came to {found!r} instead of {text!r}")
        self.counts["runs finished"] += 1
        return not self.problems

    def run_other(self):
        options = {"one": self.random.randrange(3), "other": self.random.randrange(3)}
        self.finished = None
        process = self.start(options)
        killed = self.killed(process, 0.4, 0.4)
        ended = self.place.end(process)
        if killed and ended.code == -signal.SIGKILL:
            self.counts["runs killed"] += 1
        elif self.came_to_its_end(ended, options):
            self.finished = options

    def run_again(self):
        ended = self.place.end(self.start(self.finished))
        if self.came_to_its_end(ended, self.finished) and (made := ended.in_state("ran")):
            self.problems.append(f"lost of {self.pipeline} with {self.finished}: {sorted(made)}")

    def tidy(self):
        """While it looks for a moment without a run, nobody starts one; from its start on all may."""
        with self.tidying:
            self.may_run.clear()
            busy = True
            while busy:
                process = self.place.start("store", "gc", "--keep-days", "0")
                time.sleep(self.random.random() * 0.01)
                if process.poll() != 1:
                    self.may_run.set()
                killed = self.killed(process, 0.3, 0.03)
                ended = self.place.end(process)
                busy = ended.code == 1 and "a run is using the store" in ended.err
            self.may_run.set()
        if ended.code == 0 or (killed and ended.code == -signal.SIGKILL):
            self.counts["clean-ups killed" if ended.code else "clean-ups finished"] += 1
        else:
            self.problems.append(f"a clean-up ended with {ended}")


def main():
    given = arguments(__doc__)
    seeds = random.Random(given.seed)
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so"]) as place:
        place.write("folder/a", "1")
        place.write("folder/b", "2")
        budget = Budget(given.long, 1000, 9, 20)
        User.rounds = iter(budget)
        User.may_run.set()
        users = [User(place, number, seeds.random()) for number in range(USERS)]
        while not users[0].finished and not User.problems:
            users[0].run_other()  # Makes the store.
        for user in users:
            user.thread.start()
        for user in users:
            user.thread.join()
        for user in users:
            if user.finished and not User.problems:
                user.run_again()
        ends = [place.call("store", "verify"), place.call("store", "gc", "--keep-days", "0")]
        left = [str(file) for file in (place.work / ".fresco/tmp").iterdir()]
        if left or any(ended.code != 0 for ended in ends):
            User.problems.append(f"verify and the last clean-up ended with {ends[0]} and {ends[1]}, and left {left}")
        finish(User.problems, f"seed {given.seed}: {budget.done} rounds: {len(User.problems)} losses", User.counts)


main()
