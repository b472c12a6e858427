#!/usr/bin/env python3
"""The shipped Snakefile, on this machine and on a real Slurm of two nodes, one of which is killed: results must be those of one run, every
stage starts once unless its node died, a failed scan stops only its own combinations, and a second call runs nothing.

With --long more scans and pictures. FRESCO_CASES=failed_scan tries only the cases of these names."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

sys.path[:0] = (str(pathlib.Path(__file__).resolve().parents[1] / folder) for folder in ("prove", ""))
import slurm_cluster
from skipping import skip
from workplace import Workplace, arguments

SNAKEFILE = pathlib.Path(__file__).resolve().parents[2] / "pipelines/Snakefile"
STATUS = SNAKEFILE.with_name("slurm_status")
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
SBATCH = ("sbatch --parsable --mem={resources.mem_mb} --time={resources.runtime} --cpus-per-task={threads} --gres=gpu:{resources.gpu} "
          "--output=jobs.log --open-mode=append")


class Failed(Exception):
    pass


def expect(condition, text):
    if not condition:
        raise Failed(text)


class Folder:
    """A working folder with a pipeline."""

    def __init__(self, place, name, scans, pictures, wait_ms=100):
        self.place, self.work = place, place.work / name
        self.work.mkdir()
        self.log = self.work / "log"
        self.scans, self.pictures = scans, pictures
        self.write(wait_ms)

    def write(self, wait_ms=100, extra=""):
        (self.work / "many.yaml").write_text(MANY.format(
            scans=list(range(1, self.scans + 1)), pictures=[10 * i for i in range(1, self.pictures + 1)], wait_ms=wait_ms,
            log=json.dumps(str(self.log))) + extra)

    def environment(self, slurm=None):
        return os.environ | self.place.environment | (slurm.environment if slurm else {})

    def start(self, *words, slurm=None):
        return subprocess.Popen(["snakemake", "--snakefile", str(SNAKEFILE), "--quiet", *words, "--config", "pipeline=many.yaml",
                                 f"fresco={self.place.root}/bin/fresco", "threads=1"], cwd=self.work, env=self.environment(slurm), text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run(self, *words, code=0, slurm=None):
        process = self.start(*words, slurm=slurm)
        text, _ = process.communicate(timeout=600)
        expect((process.returncode == 0) == (code == 0), f"snakemake {' '.join(words)} ended with {process.returncode}: {text[-3000:]}")
        return text

    def starts(self):
        """Of stages; test.add writes a second line when it ends."""
        return sum(" ends " not in line for line in self.log.read_text().splitlines()) if self.log.exists() else 0

    def stages(self):
        return 2 * self.scans + 2 * self.scans * self.pictures

    def expect_as_on_one_machine(self):
        """`fresco run` finds every result, and writes the same files from an empty store."""
        one = self.work / "one"
        ended = self.place.call("run", "many.yaml", "--out", one, "--store", self.work / "one-store", "--quiet", folder=self.work)
        expect(ended.code == 0, f"fresco run ended with {ended}")
        mine, others = files_below(self.work / "out"), files_below(one)
        expect(mine == others, f"files differ from those of one run: {sorted(set(mine.items()) ^ set(others.items()))[:6]}")
        expect((self.work / "out/sweep.json").exists(), "there is no sweep.json")


def files_below(folder):
    own = {"run.json", "report.html", "progress.jsonl", "sweep.json", "sweep.html", ".fresco-outputs"}
    return {str(file.relative_to(folder)): file.read_bytes() for file in sorted(folder.rglob("*")) if file.is_file() and file.name not in own}


def one_machine(place, long):
    """Edits of the file after the start change nothing; a second call runs nothing."""
    folder = Folder(place, "on e", *((4, 10) if long else (2, 3)), wait_ms=300)
    process = folder.start("--cores", "2")
    slurm_cluster.Slurm.wait(lambda: folder.starts() > 0 or process.poll() is not None, 60, "the first stage")
    folder.write(extra="  broken: {type: no.such.type}\n")
    text, _ = process.communicate(timeout=600)
    expect(process.returncode == 0, f"snakemake ended with {process.returncode}: {text[-3000:]}")
    folder.write()
    expect(folder.starts() == folder.stages(), f"{folder.starts()} starts of {folder.stages()} stages")
    folder.run("--cores", "2")
    expect(folder.starts() == folder.stages(), "the second call ran stages")
    folder.expect_as_on_one_machine()
    return f"{folder.scans * folder.pictures} combinations"


def failed_scan(place, long):
    """It stops only its own combinations; the next call runs what is missing."""
    folder = Folder(place, "failed_scan", 3, 2)
    (folder.work / "many.yaml").write_text((folder.work / "many.yaml").read_text().replace(
        'value: "${scan}"', 'value: 0, file: "scan_${scan}", beside: "size_${scan}"'))
    for scan in (1, 2, 3):
        (folder.work / f"scan_{scan}").write_text("x" * scan)
        (folder.work / f"size_{scan}").write_text("0")
    (folder.work / "size_2").unlink()
    folder.run("--cores", "2", "--keep-going", "--retries", "0", code=1)
    made = sorted(path.parent.name for path in (folder.work / "out").rglob("sum.txt"))
    expect(made == [f"scan={scan},picture={picture}" for scan in (1, 3) for picture in (10, 20)], f"there is {made}")
    before = folder.starts()
    (folder.work / "size_2").write_text("0")
    folder.run("--cores", "2")
    expect(folder.starts() - before == 2 + 2 * 2, f"{folder.starts() - before} starts of 6 missing stages")
    return "1 of 3 scans failed; its 6 stages ran afterward"


def two_nodes(place, long):
    """One node dies with all that runs on it, and a job is canceled as one beyond its time or memory is: without a word to Snakemake."""
    if reason := slurm_cluster.missing():
        skip(f"the Snakefile on Slurm: {reason}")
        return "skipped"
    folder = Folder(place, "two_nodes", *((5, 10) if long else (2, 6)), wait_ms=4000)
    with slurm_cluster.Slurm() as slurm:
        process = folder.start("--jobs", "12", "--latency-wait", "30", "--cluster", SBATCH, "--cluster-status", str(STATUS), slurm=slurm)
        slurm.wait(lambda: len(slurm.jobs_on("one")) >= 2 or process.poll() is not None, 120, "jobs on the first node")
        lost = len(slurm.jobs_on("one"))
        slurm.kill("one")
        slurm.wait(lambda: slurm.jobs_on("two") or process.poll() is not None, 120, "jobs on the second node")
        canceled = slurm.jobs_on("two")[:1]
        slurm.ask("scancel", "--signal=KILL", "--full", *canceled)
        text, _ = process.communicate(timeout=600)
        jobs = folder.work / "jobs.log"
        expect(process.returncode == 0, f"snakemake ended with {process.returncode}: {text[-1500:]}\n{jobs.read_text()[-1500:]}")
        expect(lost > 0, "no job was on the node that died")
        expect(canceled, "no job could be canceled")
        more = folder.starts() - folder.stages()
        expect(0 <= more <= 2 * (lost + 1), f"{more} starts too many for {lost} lost jobs and a canceled one")
        folder.expect_as_on_one_machine()
    return f"{folder.scans * folder.pictures} combinations, {lost} jobs lost with a node, 1 canceled"


CASES = [one_machine, failed_scan, two_nodes]


def main():
    given = arguments(__doc__)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # The daemons end too.
    if not shutil.which("snakemake"):
        skip("the Snakefile: Snakemake is not installed")
        return 0
    names = os.environ.get("FRESCO_CASES", "").split()
    chosen = [case for case in CASES if not names or case.__name__ in names]
    failures, figures, begin = [], [], time.monotonic()
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so"]) as place:
        for case in chosen:
            start = time.monotonic()
            try:
                figures.append(case(place, given.long))
                print(f"{case.__name__}: {figures[-1]} ({time.monotonic() - start:.0f} s)", flush=True)
            except (Failed, TimeoutError, subprocess.TimeoutExpired) as failure:
                failures.append(case.__name__)
                print(f"{case.__name__}: {failure}", flush=True)
    if failures:
        print(f"failed: {', '.join(failures)}")
        return 1
    print(f"{'; '.join(figures)} ({time.monotonic() - begin:.0f} s)")
    return 0


sys.exit(main())
