"""A workplace in which the program runs the pipeline faults.yaml with a shim before the C library."""
import concurrent.futures
import contextlib
import os
import pathlib
import queue
import shutil
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Workplace

# The order of both is that of calls.c.
ROLES = ["host", "worker", "helper", "program"]
KINDS = ["open", "list", "write", "sync", "rename", "link", "unlink", "mkdir", "lock", "truncate", "close"]
TEMPORARY = ".fresco-"
EXIT_CODES = {0, 1, 2, 3, 4}
# They tell times and places.
REPORTS = {"run.json", "report.html"}


class Fault(Exception):
    """A broken promise."""


class Shimmed(Workplace):
    """With a store and an output folder that can be put back, in memory where the machine has such a folder."""

    def __init__(self, given):
        memory = pathlib.Path("/dev/shm")
        super().__init__(given.fresco, [given.fresco.parent.parent / "lib/fresco/command.so", given.plugins / "good/test_stages.so",
                                        given.plugins / "pictures/text_pictures.so"], parent=memory if os.access(memory, os.W_OK) else None)
        self.shim, self.long = given.shim.resolve(), given.long
        self.pipeline = shutil.copy(pathlib.Path(__file__).with_name("faults.yaml"), self.work)
        self.write("input.txt", "12345\n")
        self.outside = self.root / "outside.txt"
        self.outside.write_text("3\n")
        # What a run changes, and what is put back for the next one.
        self.state = self.root / "state"
        self.store, self.out, self.lender = self.state / "store", self.state / "out", self.state / "lender"
        self.state.mkdir()

    def use_cache(self, folder):
        self.environment["XDG_CACHE_HOME"] = str(folder)

    def save(self, name):
        shutil.copytree(self.state, self.root / "snapshots" / name, symlinks=True)

    def restore(self, name):
        shutil.rmtree(self.state)
        shutil.copytree(self.root / "snapshots" / name, self.state, symlinks=True)

    def shimmed(self, command, variables):
        """Runs the program behind the shim, with variables for it."""
        return self.call(*command, environment={"LD_PRELOAD": str(self.shim), **variables})

    def run_command(self, **sets):
        """The words of `fresco run`. On one core the order of the calls is the same each time."""
        words = ["run", self.pipeline, "--out", str(self.out), "--store", str(self.store), "--cores", "1", "--set", f"outside={self.outside}"]
        for name, value in sets.items():
            words += ["--set", f"{name}={value}"]
        return words

    def store_command(self, *words):
        return ["store", *words, "--store", str(self.store)]

    def must(self, command, code=0):
        ended = self.call(*command)
        if ended.code != code:
            raise Fault(f"{' '.join(map(str, command))} ended with {ended.code} instead of {code}:\n{ended.text}")
        return ended

    def files(self):
        """What the run made for the user: name -> bytes."""
        return {str(file.relative_to(self.out)): file.read_bytes() for file in sorted(self.out.rglob("*"))
                if file.is_file() and file.name not in REPORTS and not file.name.startswith(TEMPORARY)}

    def objects(self, store=None):
        """Results that have a manifest."""
        return {file.parent.name for file in ((store or self.store) / "objects").glob("*/manifest.json")}

    def calls(self, command):
        """How many calls of each role and kind the program makes: {(role, kind): count}."""
        ended = self.shimmed(command, self.count_variables())
        if ended.code != 0:
            raise Fault(f"{' '.join(map(str, command))} ended with {ended.code} with the shim:\n{ended.text}")
        counts = struct.unpack(f"{len(ROLES) * len(KINDS)}Q", (self.root / "counts").read_bytes())
        return {(role, kind): counts[r * len(KINDS) + k] for r, role in enumerate(ROLES) for k, kind in enumerate(KINDS)}

    def count_variables(self):
        (self.root / "counts").write_bytes(bytes(8 * len(ROLES) * len(KINDS)))
        return {"FAULT_COUNTS": str(self.root / "counts")}


def try_all(given, prepare, cases_of, attempt):
    """Tries the cases, cases_of a workplace that is ready, in as many workplaces as there are cores, each made ready by `prepare`. Prints
    what goes wrong; returns how often, and how many cases there were."""
    places = queue.Queue()
    cores = min(2, len(os.sched_getaffinity(0)))

    def made_ready(place):
        prepare(place)
        return place

    def one(case):
        place = places.get()
        try:
            attempt(place, case)
            return 0
        except Fault as fault:
            print(f"{case}: {fault}\n", flush=True)
            return 1
        finally:
            places.put(place)

    with contextlib.ExitStack() as made, concurrent.futures.ThreadPoolExecutor(cores) as pool:
        ready = list(pool.map(made_ready, [made.enter_context(Shimmed(given)) for _ in range(cores)]))
        cases = cases_of(ready[0])
        for place in ready:
            places.put(place)
        return sum(pool.map(one, cases)), len(cases)


def finish(faults, figures):
    """Ends the proof with one line."""
    print(f"{figures}, {faults} faults")
    sys.exit(1 if faults else 0)
