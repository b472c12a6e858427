#!/usr/bin/env python3
"""Plugins that do what no plugin should, in run() (framework/tests/test_plugins/misbehave.cpp). Whatever they do:
the other stages come to the right results, an error names the culprit, nothing that was damaged is served, no process and no temporary
folder is left, and the next run, in which the plugin behaves, is right. Each way has a store of its own.

The ways that take longer than a second only with --long."""
import concurrent.futures
import json
import os
import pathlib
import stat
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Workplace, arguments, finish

PIPELINE = """version: 1
vars: {how: nothing, value: 1.5}
stages:
  before: {type: test.source, value: 5}
  bad:    {type: test.misbehave, how: "${how}", value: "${value}", input: before, file: victim}
  after:  {type: test.add, input: {left: bad, right: before}}
  last:   {type: test.sink, input: after, path: last.txt}
  good:   {type: test.slow, steps: 4, step_ms: STEP}
  text:   {type: test.sink, input: good, path: good.txt}
"""
GOOD = {"good.txt": "4.000000\n"}
ALL = GOOD | {"last.txt": "6.500000\n"}

HARMLESS = ("fork", "spoil_by_child", "spoil_others", "write_beside", "block_signals", "umask", "move_away", "locale", "environment",
            "leave_session", "print_binary", "garbage")
LIMITED_TIME, LIMITED_MEMORY = ([limit, value] for limit, value in (("--stage-time", "1s"), ("--stage-memory", "300M")))
# What the error of a way says, and more words for the command line.
HARMFUL = {
    "delete_inputs": ("victim: changed while the stage ran", []),
    "crash_and_leave": ("its process crashed: Segmentation fault", []),
    "segfault": ("crashed: Segmentation fault (signal 11)", []),
    "overflow": ("crashed: Segmentation fault (signal 11)", []),
    "exit_canceled": ("ended with exit code 75 before the stage was done", []),
    "throw_int": ("something other than an exception was thrown", []),
    "loop": ("it exceeded the time limit of 1", LIMITED_TIME),
    "print": ("raise --stage-time, or find out where it hangs", LIMITED_TIME),
    "allocate_elsewhere": ("the limit is 300 MB: raise --stage-memory", LIMITED_MEMORY),
    "claim": ("its process ended with exit code 0 before the stage was done", []),
    "deaf": ("it exceeded the time limit of 1", LIMITED_TIME),
    "close_all": ("ended with exit code 75 before the stage was done", []),
    "few_files": ("Too many open files", []),
    "no_room": ("File too large", []),
    "end_by_exit": ("its process crashed: Aborted", []),
    "allocate": ("raise --stage-memory where it is set", LIMITED_MEMORY),
}


class Case:
    """One way in a folder of its own."""

    def __init__(self, place, name):
        self.place, self.name, self.problems = place, name, []
        self.folder = place.root / "cases" / name
        self.folder.mkdir(parents=True)
        (self.folder / "room.yaml").write_text(PIPELINE.replace("STEP", "20" if name == "write_beside" else "1"))
        (self.folder / "victim").write_text("12")

    def expect(self, condition, text):
        if not condition:
            self.problems.append(f"{self.name}: {text}")

    def misbehave(self, *words):
        return self.run("--set", f"how={self.name}", "--cores", "2", *words)

    def run(self, *words):
        for file in ALL:
            (self.folder / "out" / file).unlink(missing_ok=True)
        ended = self.place.run(*words, folder=self.folder)
        for line in ended.out.splitlines():
            try:
                json.loads(line)
            except ValueError:
                self.expect(False, f"a line of the log is not JSON: {line[:200]!r}")
        return ended

    def expect_files(self, files, ended):
        for name, text in files.items():
            file = self.folder / "out" / name
            found = file.read_text() if file.exists() else "nothing"
            self.expect(found == text, f"{name} holds {found!r} instead of {text!r}: {ended}")

    def expect_order(self, damaged=False):
        """Afterward: the plugin behaves, and all is right; `damaged`: its own result of before may be, and is found to be."""
        self.expect(not list(self.folder.glob(".fresco/tmp/*")), "a temporary folder is left")
        (self.folder / "victim").write_text("12")
        ended = self.run()
        self.expect(ended.code == 0, f"the next run ended with {ended}")
        self.expect_files(ALL, ended)
        verified = self.place.call("store", "verify", folder=self.folder)
        self.expect(verified.code == 0 or (damaged and "damaged:" in verified.out + verified.err), f"verify ended with {verified}")
        for file in (self.folder / ".fresco").rglob("*"):
            self.expect(file.is_symlink() or file.stat().st_mode & stat.S_IRUSR, f"{file} cannot be read by its owner")
        return self.problems


def run_way(place, name):
    told, words = HARMFUL.get(name, (None, []))
    case = Case(place, name)
    ended = case.misbehave(*words)
    case.expect(ended.code == (1 if told else 0), f"ended with {ended}")
    if told:
        error = ended.stages["bad"]["error"]
        case.expect("error: stage bad (test.misbehave)" in error and told in error, f"its error does not say {told!r}: {error}")
        case.expect(ended.stages["after"]["state"] == "not run", "a stage ran that needs it")
    case.expect_files(GOOD if told else ALL, ended)
    return case.expect_order()


def run_kill_others(place):
    case = Case(place, "kill_others")
    ended = case.misbehave("--set", "good.step_ms=5000")
    case.expect(ended.code == 1, f"ended with {ended}")
    case.expect("killed from outside" in ended.stages["good"]["error"], f"the error of good: {ended.stages['good']['error']}")
    case.expect(ended.stages["last"]["state"] == "ran", "the others did not go on")
    return case.expect_order()


def run_spoil_by_thread(place):
    """Threads cannot be ended: the result may come out damaged, which its readers find, and the error names the stage."""
    case = Case(place, "spoil_by_thread")
    ended = case.misbehave()
    case.expect_files(GOOD, ended)
    case.expect(ended.code in (0, 1), f"ended with {ended}")
    errors = [stage["error"] for stage in ended.stages.values() if stage["error"]]
    case.expect(all("bad" in error for error in errors), f"an error does not name it: {errors}")
    return case.expect_order(damaged=True)


def run_print_much(place, megabytes):
    case = Case(place, "print_much")
    ended = case.misbehave("--set", f"value={megabytes}")
    case.expect(ended.code == 0, f"ended with {ended.code}: {ended.err}")
    case.expect_files(GOOD, ended)
    logs = [file.stat().st_size for file in (case.folder / ".fresco/logs").iterdir()]
    case.expect(max(logs) <= 1 << 20, f"a log has {max(logs)} bytes")
    return case.expect_order()


def left_processes(place):
    program = str(place.root / "bin/fresco")
    left = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if str((process / "exe").readlink()) == program:
                left.append(process.name)
        except OSError:
            continue
    return left


def main():
    given = arguments(__doc__)
    plugins = [given.plugins / "good/test_stages.so", given.plugins / "misbehaving/misbehave.so"]
    with Workplace(given.fresco, plugins) as place, concurrent.futures.ThreadPoolExecutor(2) as pool:
        begin = time.monotonic()
        cases = [pool.submit(run_way, place, name) for name in (*HARMLESS, *HARMFUL)]
        cases += [pool.submit(run_kill_others, place), pool.submit(run_spoil_by_thread, place),
                  pool.submit(run_print_much, place, 1024 if given.long else 64)]
        problems = [problem for case in cases for problem in case.result()]
        end = time.monotonic() + 10  # One that was killed may take a moment to end.
        while (left := left_processes(place)) and time.monotonic() < end:
            time.sleep(0.1)
        problems += [f"processes are left: {left}"] if left else []
        for process in left:
            os.kill(int(process), 9)
        finish(problems, f"{len(cases)} ways to misbehave in {time.monotonic() - begin:.0f} s: {len(problems)} problems")


main()
