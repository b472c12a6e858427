"""A folder in which the program runs the pipeline faults.yaml, with a shim before the C library."""
import argparse
import concurrent.futures
import dataclasses
import os
import pathlib
import queue
import shutil
import struct
import subprocess
import sys
import tempfile

# The order of both is that of calls.c.
ROLES = ["host", "worker", "helper", "program"]
KINDS = ["open", "list", "write", "sync", "rename", "link", "unlink", "mkdir", "lock", "truncate", "close"]
TEMPORARY = ".fresco-"
EXIT_CODES = {0, 1, 2, 3, 4}
HANGS_S = 60
# They tell times and places.
REPORTS = {"run.json", "report.html"}


class Fault(Exception):
    """A broken promise."""


def arguments(about):
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("shim", type=pathlib.Path, help="library to load before the C library")
    parser.add_argument("--libraries", type=pathlib.Path, help="folder of the program's libraries")
    parser.add_argument("--plugins", type=pathlib.Path, nargs="+", help="plugins that the pipeline needs")
    parser.add_argument("--long", action="store_true", help="every case instead of a sample")
    return parser.parse_args()


@dataclasses.dataclass
class Ended:
    code: int
    text: str


class Workplace:
    """Its own program, plugins, cache, store and output folder, in memory where the machine has such a folder."""

    def __init__(self, words):
        memory = pathlib.Path("/dev/shm")
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="fresco-prove-", dir=memory if os.access(memory, os.W_OK) else None))
        self.shim, self.long = words.shim, words.long
        for name in ("bin", "plugins", "home", "pipeline", "snapshots"):
            (self.root / name).mkdir()
        self.program = shutil.copy(words.program, self.root / "bin")
        for plugin in words.plugins:
            shutil.copy(plugin, self.root / "plugins")
        self.pipeline = shutil.copy(pathlib.Path(__file__).with_name("faults.yaml"), self.root / "pipeline")
        (self.root / "pipeline/input.txt").write_text("12345\n")
        self.outside = self.root / "outside.txt"
        self.outside.write_text("3\n")
        # What a run changes, and what is put back for the next one.
        self.state = self.root / "state"
        self.store, self.out = self.state / "store", self.state / "out"
        self.state.mkdir()
        self.environment = dict(os.environ, FRESCO_PLUGIN_PATH=str(self.root / "plugins"), LD_LIBRARY_PATH=str(words.libraries),
                                HOME=str(self.root / "home"), XDG_DATA_HOME=str(self.root / "home/data"))
        self.use_cache(self.root / "cache")

    def remove(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def use_cache(self, folder):
        self.environment["XDG_CACHE_HOME"] = str(folder)

    def save(self, name):
        shutil.copytree(self.state, self.root / "snapshots" / name, symlinks=True)

    def restore(self, name):
        shutil.rmtree(self.state)
        shutil.copytree(self.root / "snapshots" / name, self.state, symlinks=True)

    def call(self, command, shim=None):
        """Runs the program. `shim`: variables of the library that is loaded before the C library; without them it is not."""
        environment = dict(self.environment, LD_PRELOAD=str(self.shim), **shim) if shim is not None else self.environment
        try:
            ended = subprocess.run([self.program, *command], env=environment, cwd=self.root,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=HANGS_S, check=False)
        except subprocess.TimeoutExpired as expired:
            raise Fault(f"hangs: {' '.join(command)}: {expired.output}") from expired
        return Ended(ended.returncode, ended.stdout.decode(errors="replace"))

    def run_command(self, **sets):
        """The words of `fresco run`. On one core the order of the calls is the same each time."""
        words = ["run", self.pipeline, "--out", str(self.out), "--store", str(self.store), "--cores", "1", "--set", f"outside={self.outside}"]
        for name, value in sets.items():
            words += ["--set", f"{name}={value}"]
        return words

    def store_command(self, *words):
        return ["store", *words, "--store", str(self.store)]

    def must(self, command, code=0):
        ended = self.call(command)
        if ended.code != code:
            raise Fault(f"{' '.join(map(str, command))} ended with {ended.code} instead of {code}:\n{ended.text}")
        return ended

    def files(self):
        """What the run made for the user: name -> bytes."""
        return {str(file.relative_to(self.out)): file.read_bytes() for file in sorted(self.out.rglob("*"))
                if file.is_file() and file.name not in REPORTS and not file.name.startswith(TEMPORARY)}

    def objects(self):
        """Results that have a manifest."""
        return {file.parent.name for file in (self.store / "objects").glob("*/manifest.json")}

    def calls(self, command):
        """How many calls of each role and kind the program makes: {(role, kind): count}."""
        ended = self.call(command, self.count_variables())
        if ended.code != 0:
            raise Fault(f"{' '.join(map(str, command))} ended with {ended.code} with the shim:\n{ended.text}")
        counts = struct.unpack(f"{len(ROLES) * len(KINDS)}Q", (self.root / "counts").read_bytes())
        return {(role, kind): counts[r * len(KINDS) + k] for r, role in enumerate(ROLES) for k, kind in enumerate(KINDS)}

    def count_variables(self):
        (self.root / "counts").write_bytes(bytes(8 * len(ROLES) * len(KINDS)))
        return {"FAULT_COUNTS": str(self.root / "counts")}


def try_all(words, prepare, cases, attempt):
    """Tries the cases in as many workplaces as there are cores, each made ready by `prepare`. Prints what goes wrong; returns how often."""
    places = queue.Queue()
    cores = min(2, len(os.sched_getaffinity(0)))
    made = []
    for _ in range(cores):
        place = Workplace(words)
        made.append(place)
        prepare(place)
        places.put(place)

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

    try:
        with concurrent.futures.ThreadPoolExecutor(cores) as pool:
            return sum(pool.map(one, cases))
    finally:
        for place in made:
            place.remove()


def finish(faults, figures):
    """Ends the proof with one line."""
    print(f"{figures}, {faults} faults")
    sys.exit(1 if faults else 0)
