#!/usr/bin/env python3
"""Pipelines on a real Slurm of one node, whose results must be those of one machine: every stage starts once, waves, a failed scan,
interruption, cancellation, lack of memory, two runs of one task, random kill -9 of daemons, jobs and the submitter, Snakemake.

With --long 10 scans x 100 pictures, 20 kills, and 10 000 tasks for Snakemake to plan; otherwise less of each. FRESCO_CASES=failed_scan
tries only the cases of these names."""
import collections
import itertools
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

sys.path[:0] = (str(pathlib.Path(__file__).resolve().parents[1] / folder) for folder in ("prove", ""))
import slurm_cluster
from skipping import skip
from workplace import Workplace, arguments

# Per scan a source; per scan and picture a stage that sleeps, and a file.
MANY = """\
version: 1
vars: {{scan: , picture: }}
matrix: {{scan: {scans}, picture: {pictures}}}
stages:
  scan_of: {{type: test.source, value: "${{scan}}", wait_ms: 50, log: {log}}}
  mesh:    {{type: test.add, input: {{left: scan_of}}, plus: 1000, log: {log}}}
  paint:   {{type: test.add, input: {{left: mesh}}, plus: "${{picture}}", wait_ms: {wait_ms}, log: {log}}}
  text:    {{type: test.sink, input: paint, path: sum.txt, log: {log}}}
"""
STAGES_OF_SCAN, STAGES_OF_PICTURE = 2, 2


class Failed(Exception):
    pass


def expect(condition, text):
    if not condition:
        raise Failed(text)


class Folder:
    """A working folder with a pipeline, and its submission."""

    def __init__(self, place, slurm, name):
        self.place, self.slurm, self.work = place, slurm, place.work / name
        self.work.mkdir()
        self.log = self.work / "log"
        self.tasks = self.work / "cluster"

    def write_many(self, scans, pictures, wait_ms=100):
        self.scans, self.pictures = scans, pictures
        (self.work / "many.yaml").write_text(MANY.format(scans=list(range(1, scans + 1)), pictures=[10 * i for i in range(1, pictures + 1)],
                                                         wait_ms=wait_ms, log=json.dumps(str(self.log))))

    def call(self, *words, code=0):
        ended = self.place.call(*words, folder=self.work, environment=self.environment())
        expect(code is None or ended.code == code, f"fresco {' '.join(map(str, words))} ended with {ended}")
        return ended

    def environment(self):
        return {name: value for name, value in self.slurm.environment.items() if name in ("SLURM_CONF", "PATH")}

    def submit(self, *words, code=0):
        """Every combination a task of its own."""
        return self.call("submit", "slurm", "many.yaml", "--pack", 0, "--cores", 1, *words, code=code)

    def submit_missing(self, *words):
        return self.call("submit", "slurm", "cluster", *words)

    def status(self):
        return json.loads(self.call("status", "cluster", "--json").out)

    def states(self):
        return collections.Counter(task["state"] for task in self.status()["tasks"])

    def in_queue(self):
        """Jobs of its tasks by state."""
        return {task["job"]: task["state"] for task in self.status()["tasks"] if task["state"] in ("running", "queued")}

    def running(self):
        return [job for job, state in self.in_queue().items() if state == "running"]

    def starts(self):
        """How many stages have begun."""
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return sum(not line.startswith("add ends") for line in lines)

    def stages(self):
        return self.scans * STAGES_OF_SCAN + self.scans * self.pictures * STAGES_OF_PICTURE

    def reference(self):
        """The same on one machine; its stages have another log."""
        text = (self.work / "many.yaml").read_text()
        (self.work / "one").mkdir()
        (self.work / "one/many.yaml").write_text(text.replace(str(self.log), str(self.work / "one/log")))
        self.call("run", "one/many.yaml", "--store", "one/.fresco", "--out", "one/out", "--cores", 2, "--jobs", 2)

    def expect_as_on_one_machine(self):
        """Files, sweep.json but for times, and the store itself."""
        self.reference()
        mine, others = files_below(self.work / "out"), files_below(self.work / "one/out")
        expect(mine == others, f"files differ from those of one machine: {sorted(set(mine.items()) ^ set(others.items()))[:6]}")
        mine, others = summary_of(self.work / "out", self.work), summary_of(self.work / "one/out", self.work / "one")
        expect(mine == others, f"sweep.json differs from that of one machine: {first_difference(mine, others)}")
        self.call("store", "verify")
        objects = [entry for entry in (self.work / ".fresco/objects").iterdir()]
        expect(len(objects) == self.stages(), f"{len(objects)} objects of {self.stages()} stages")


def files_below(folder):
    own = {"run.json", "report.html", "sweep.json", "sweep.html", ".fresco-outputs"}
    return {str(file.relative_to(folder)): file.read_bytes() for file in sorted(folder.rglob("*")) if file.is_file() and file.name not in own}


TIMES = {"time", "seconds", "own_seconds", "memory_mb", "made", "threads", "command", "directory", "cores", "log", "figures", "curves"}


def summary_of(out, folder):
    """sweep.json without times and places; ran and stored are what differs in a run with nothing to do."""

    def plain(value):
        if isinstance(value, dict):
            return {name: plain(entry) for name, entry in value.items() if name not in TIMES | {"ran", "stored"}}
        if isinstance(value, list):
            return [plain(entry) for entry in value]
        return {"ran": "stored"}.get(value, value) if isinstance(value, str) else value

    text = (out / "sweep.json").read_text()
    return plain(json.loads(text.replace(str(folder) + "/log", "LOG").replace(str(folder), "FOLDER")))


def first_difference(a, b, path=""):
    if isinstance(a, dict) and isinstance(b, dict):
        for name in sorted(set(a) | set(b)):
            if a.get(name) != b.get(name):
                return first_difference(a.get(name), b.get(name), f"{path}.{name}")
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for i, (one, other) in enumerate(zip(a, b)):
            if one != other:
                return first_difference(one, other, f"{path}[{i}]")
    return f"{path}: {a!r} and {b!r}"


def arrays_and_waves(place, slurm, long):
    """Every stage starts once, in waves that fit the scheduler's limits."""
    folder = Folder(place, slurm, "all, 100 %\'s")
    folder.write_many(*((10, 100) if long else (4, 10)))
    elements = folder.scans + folder.scans * folder.pictures
    dry = folder.submit("--dry-run")
    expect("would submit" in dry.out and not slurm.queue(), f"--dry-run: {dry}")
    scripts = sorted((folder.tasks / "slurm/wave-000").glob("*.s*"))
    for script in scripts:
        subprocess.run(["bash", "-n", script], check=True)
    shutil.rmtree(folder.tasks)
    most = 600 if long else 20
    submitted = folder.submit("--max-queued", most)
    begin, deepest = time.monotonic(), 0
    while True:
        queue = slurm.queue()
        deepest = max(deepest, len(queue))
        if not queue:
            break
        time.sleep(0.2)
    seconds = time.monotonic() - begin
    expect(deepest <= most, f"{deepest} jobs in the queue at a time, instead of {most}")
    states = folder.states()
    expect(states == {"done": elements}, f"tasks: {dict(states)}")
    expect(folder.starts() == folder.stages(), f"{folder.starts()} starts of {folder.stages()} stages")
    again = folder.submit_missing()
    expect("nothing to submit" in again.out and not slurm.queue(), f"what is done was queued again: {again}")
    folder.call("collect", "cluster")
    folder.expect_as_on_one_machine()
    expect(folder.starts() == folder.stages(), "collecting started stages")
    limit = 5 if long else 60
    expect(submitted.seconds <= limit, f"submitting took {submitted.seconds:.1f} s")
    return f"{elements} tasks submitted in {submitted.seconds:.1f} s, run in {seconds:.0f} s ({seconds / elements:.2f} s each), " \
           f"at most {deepest} queued"


def failed_scan(place, slurm, long):
    """A failed scan blocks only itself; what is missing is queued again, and only that."""
    folder = Folder(place, slurm, "failed")
    folder.write_many(3, 4)
    # Each scan reads the number in a file of its name; that of the second is missing.
    for name in ("any", "first", "third"):
        (folder.work / name).write_text("5")
    text = (folder.work / "many.yaml").read_text().replace("[1, 2, 3]", "[first, second, third]")
    (folder.work / "many.yaml").write_text(text.replace('value: "${scan}"', 'file: any, beside: "${scan}"'))
    folder.submit()
    slurm.wait_until_empty(120)
    status = folder.status()
    found = {one["name"]: one["state"] for one in status["combinations"]}
    expect(all(state == ("failed" if "second" in name else "done") for name, state in found.items()), f"combinations: {found}")
    states = collections.Counter(task["state"] for task in status["tasks"])
    expect(states == {"done": 10, "failed": 1, "not run": 4}, f"tasks: {dict(states)}")
    failed = [task for task in status["tasks"] if task["state"] == "failed"][0]
    expect("second" in failed["error"] and "second" in pathlib.Path(failed["log"]).name, f"the failed task: {failed}")
    expect("second: " in pathlib.Path(failed["log"]).read_text(), "the log does not say why")
    expect("scan_of@" in folder.call("status", "cluster").out, "the table does not say at which stage")
    folder.call("collect", "cluster", code=1)
    cells = {one["name"]: one for one in json.loads((folder.work / "out/sweep.json").read_text())["combinations"]}
    expect(cells["second,picture=10"]["state"] == "failed" and cells["second,picture=10"]["error"], "sweep.json: no failure")
    (folder.work / "second").write_text("5")
    before = folder.starts()
    again = folder.submit_missing()
    expect("5 tasks" in again.out, f"queued again: {again.out}")
    slurm.wait_until_empty(120)
    expect(folder.states() == {"done": 15}, f"after the second submission: {folder.states()}")
    expect(folder.starts() - before == STAGES_OF_SCAN + 4 * STAGES_OF_PICTURE, "stages that were done began again")
    return "1 of 3 scans failed: 4 of 12 pictures not run, 5 tasks queued again"


SLOW = """\
version: 1
vars: {{n: }}
matrix: {{n: [1, 2]}}
stages:
  start: {{type: test.source, value: "${{n}}", log: {log}}}
  slow:  {{type: test.slow, input: start, steps: {steps}, step_ms: 50, log: {log}}}
  text:  {{type: test.sink, input: slow, path: sum.txt}}
"""


def steps_done(folder):
    """Of each task that has a checkpoint."""
    return [int(step.read_text().split()[0]) for step in (folder.work / ".fresco/checkpoints").glob("*/step")]


def interruption(place, slurm, long):
    """The signal before the time limit: the task goes on from its checkpoint, by itself. A canceled one does not come back."""
    limited, canceled = Folder(place, slurm, "limited"), Folder(place, slurm, "canceled")
    for folder in (limited, canceled):
        # Slurm looks at time limits twice a minute.
        (folder.work / "many.yaml").write_text(SLOW.format(log=json.dumps(str(folder.log)), steps=1200 if long else 400))
        folder.submit()
    slurm.wait(lambda: sum(state == "RUNNING" for state in slurm.queue().values()) == 4, 60, "four running tasks")
    slurm.wait(lambda: all(len(done := steps_done(folder)) == 2 and min(done) >= 25 for folder in (limited, canceled)), 120, "25 steps of each task")
    for job in limited.running():
        if long:
            # The limit itself: 1 minute, of which the last 60 s begin at once.
            slurm.ask("scontrol", "update", f"JobId={job}", "TimeLimit=1")
        else:
            slurm.ask("scancel", "--batch", "--signal=TERM", job)
    canceled.call("cancel", "cluster")
    slurm.wait(lambda: not canceled.in_queue(), 60, "the end of canceled jobs")
    logs = lambda: [file.read_text() for file in sorted((limited.tasks / "logs").glob("*.log"))]
    slurm.wait(lambda: all("start 2" in text for text in logs()), 180, "a second start")
    for job in limited.running():
        slurm.ask("scontrol", "update", f"JobId={job}", "TimeLimit=30")
    expect(not canceled.in_queue(), "a canceled task came back")
    expect("done" not in canceled.states(), f"after canceling: {canceled.states()}")
    canceled.submit_missing()
    slurm.wait_until_empty(180)
    expect(limited.states() == {"done": 2}, f"after the interruption: {limited.states()}: {logs()}")
    expect(canceled.states() == {"done": 2}, f"after the second submission: {canceled.states()}")
    lines = limited.log.read_text().splitlines()
    resumed = [int(line.split()[-1]) for line in lines if line.startswith("slow from") and not line.endswith(" 0")]
    # A checkpoint per step: none of the 25 is done again.
    expect(len(resumed) == 2 and min(resumed) >= 25, f"resumed at steps {resumed}: {lines}")
    for folder in (limited, canceled):
        lines = folder.log.read_text().splitlines()
        expect(lines.count("source") == 2, f"the stage before began again: {lines}")
        folder.call("collect", "cluster")
    return f"resumed at steps {resumed}"


HUNGRY = """\
version: 1
stages:
  hungry:
    type: command
    run: [python3, -c, "import sys, time; x = bytearray(700_000_000); time.sleep(10); open(sys.argv[1], 'w').write('done')", "{made}/a.txt"]
    outputs: {made: files}
"""


def lack_of_memory(place, slurm, long):
    folder = Folder(place, slurm, "memory")
    (folder.work / "many.yaml").write_text(HUNGRY)
    folder.submit()
    slurm.wait_until_empty(120)
    expect(folder.states() == {"failed": 1}, f"with too little memory: {folder.states()}: {folder.status()}")
    limits = []
    for _ in range(3):
        folder.submit_missing()
        scripts = sorted((folder.tasks / "slurm").glob("wave-*/*.sbatch"))
        limits.append(int(re.search(r"--mem=(\d+)M", scripts[-1].read_text())[1]))
        slurm.wait_until_empty(120)
        if folder.states() == {"done": 1}:
            break
    expect(folder.states() == {"done": 1} and limits[0] == 1000, f"memory limits {limits}, then {folder.states()}")
    return f"more memory: {limits} MB"


def twice_at_once(place, slurm, long):
    """One task on two nodes, as after a partition of the network."""
    folder = Folder(place, slurm, "twice")
    folder.write_many(1, 1, wait_ms=1500)
    folder.submit("--dry-run")
    for task in (0, 1):
        runs = [place.start("run", "--task", task, "cluster", folder=folder.work) for _ in range(3)]
        ended = [place.end(run) for run in runs]
        expect(all(one.code == 0 for one in ended), f"one of three runs of task {task}: {[str(one) for one in ended]}")
    expect(folder.starts() == folder.stages(), f"{folder.starts()} starts of {folder.stages()} stages")
    folder.call("collect", "cluster")
    folder.expect_as_on_one_machine()
    return "one start of each stage"


def random_kills(place, slurm, long):
    """kill -9 of the node's daemon with all its jobs, the controller, or the submitter."""
    folder = Folder(place, slurm, "kills")
    folder.write_many(*((4, 30) if long else (3, 8)), wait_ms=1500)
    kills, in_flight, counts = (20 if long else 2), 0, collections.Counter()
    environment = folder.environment()

    def words():
        return ("cluster",) if (folder.tasks / "tasks.json").exists() else ("many.yaml", "--pack", 0, "--cores", 1)

    def killed_submission():
        process = place.start("submit", "slurm", *words(), folder=folder.work, environment=environment)
        time.sleep(random.random() * 1.2)
        process.kill()
        process.communicate()

    def submitted():
        ended = folder.call("submit", "slurm", *words(), code=None)
        expect(ended.code == 0 or "another submission of this folder is running" in ended.err, f"fresco submit ended with {ended}")
        return ended.code == 0

    def submit():
        # What a killed submission has started goes on, and holds the folder until it ends.
        slurm.wait(submitted, 60, "a submission")

    killed_submission()
    counts["submitter"] += 1
    submit()
    patterns = itertools.cycle(random.sample(["slurmd", "slurmctld", "submitter"], 3))
    for _ in range(kills - 1):
        time.sleep(random.random() * 3)
        what = next(patterns)
        counts[what] += 1
        if what == "submitter":
            killed_submission()
            submit()
        else:
            if what == "slurmd":
                # Jobs are listed as running before their stages begin, and for some seconds after their node was lost.
                begun = folder.starts()
                slurm.wait(lambda: folder.starts() > begun or not slurm.queue(), 120, "a stage that begins")
                time.sleep(random.random())
                in_flight += sum(state == "RUNNING" for state in slurm.queue().values()) * STAGES_OF_PICTURE
            slurm.kill(what)
            time.sleep(random.random())
            slurm.start(what)
            slurm.wait(lambda: slurm.ask("sinfo", "--noheader", "--format=%T").strip() != "", 30, what)
    end = time.monotonic() + 300
    while folder.states() != {"done": folder.scans * (1 + folder.pictures)}:
        if time.monotonic() > end:
            raise Failed(f"not everything is done: {folder.states()}, queue {slurm.queue()}")
        if not slurm.queue():
            submit()
        time.sleep(1)
    expect(folder.starts() <= folder.stages() + in_flight, f"{folder.starts()} starts of {folder.stages()} stages, {in_flight} in flight")
    slurm.wait_until_empty(120)
    folder.call("collect", "cluster")
    folder.expect_as_on_one_machine()
    return f"kills: {dict(counts)}, {in_flight // STAGES_OF_PICTURE} running jobs; {folder.starts() - folder.stages()} of " \
           f"{folder.stages()} stages began again"


def snakemake(place, slurm, long):
    if not shutil.which("snakemake") and (not long or slurm_cluster.install(["snakemake"])):
        skip("Snakemake on Slurm: Snakemake is not installed")
        return "skipped"
    folder = Folder(place, slurm, "snake {make}")
    folder.write_many(*((5, 6) if long else (2, 3)))
    folder.call("export", "snakemake", "many.yaml", "--pack", 0, "--cores", 1)
    environment = os.environ | place.environment | slurm.environment
    words = ["snakemake", "--snakefile", "cluster/Snakefile", "--quiet"]
    begin = time.monotonic()
    ended = subprocess.run([*words, "--jobs", "8", "--latency-wait", "20", "--cluster",
                            "sbatch --parsable --mem={resources.mem_mb} --time={resources.runtime} --cpus-per-task={threads} "
                            "--gres=gpu:{resources.gpu} --output=/dev/null"], cwd=folder.work, env=environment, text=True, capture_output=True)
    expect(ended.returncode == 0, f"snakemake ended with {ended.returncode}: {ended.stdout[-2000:]}{ended.stderr[-2000:]}")
    seconds = time.monotonic() - begin
    folder.expect_as_on_one_machine()
    expect(folder.starts() == folder.stages(), f"{folder.starts()} starts of {folder.stages()} stages")
    other = Folder(place, slurm, "snakemake_local")
    other.write_many(1, 2)
    other.call("export", "snakemake", "many.yaml", "--pack", 0, "--cores", 1)
    ended = subprocess.run([*words, "--cores", "2"], cwd=other.work, env=environment, text=True, capture_output=True)
    expect(ended.returncode == 0, f"snakemake --cores 2 ended with {ended.returncode}: {ended.stderr[-2000:]}")
    other.expect_as_on_one_machine()
    told = f"{folder.scans * folder.pictures} combinations through sbatch in {seconds:.0f} s"
    if long:
        large = Folder(place, slurm, "snakemake_large")
        large.write_many(10, 999)
        large.call("export", "snakemake", "many.yaml", "--pack", 0, "--cores", 1)
        before = os.times().children_user
        ended = subprocess.run([*words, "--dry-run"], cwd=large.work, env=environment, text=True, capture_output=True)
        seconds = os.times().children_user - before
        expect(ended.returncode == 0 and seconds <= 10,
               f"snakemake --dry-run of 10 000 tasks took {seconds:.1f} s of processor time: {ended.stderr[-500:]}")
        told += f"; 10 000 tasks planned in {seconds:.1f} s of processor time"
    return told


CASES = [arrays_and_waves, failed_scan, interruption, lack_of_memory, twice_at_once, random_kills, snakemake]


def main():
    given = arguments(__doc__)
    random.seed(given.seed)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # The daemons end too.
    if reason := slurm_cluster.missing():
        skip(f"the proofs on Slurm: {reason}")
        return 0
    names = os.environ.get("FRESCO_CASES", "").split()
    chosen = [case for case in CASES if not names or case.__name__ in names]
    plugins = [given.plugins / "good/test_stages.so", given.fresco.parent.parent / "lib/fresco/command.so"]
    failures, figures, begin = [], [], time.monotonic()
    with Workplace(given.fresco, plugins) as place:
        for case in chosen:
            start = time.monotonic()
            try:
                with slurm_cluster.Slurm(array_size=101) as slurm:
                    told = case(place, slurm, given.long)
                figures.append(told)
                print(f"{case.__name__}: {told} ({time.monotonic() - start:.0f} s)", flush=True)
            except (Failed, TimeoutError) as failure:
                failures.append(case.__name__)
                print(f"{case.__name__} (seed {given.seed}): {failure}", flush=True)
    if failures:
        print(f"failed: {', '.join(failures)}")
        return 1
    print(f"{len(chosen)} cases in {time.monotonic() - begin:.0f} s: {'; '.join(figures)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
