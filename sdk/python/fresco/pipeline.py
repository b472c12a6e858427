"""Starts the command `fresco` and follows its events."""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import queue
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from typing import IO, Any, Callable, Mapping, Optional, Union

from .results import Result, open_results

PathLike = Union[str, "os.PathLike[str]"]
PipelineLike = Union[PathLike, Mapping[str, Any]]


class FrescoError(RuntimeError):
    """What fresco printed when it failed. `exit_code` says which kind it is: 1 a stage failed, 2 the pipeline is invalid, 3 an input file is
    missing, 4 a plugin cannot be loaded, 70 a bug, 75 interrupted, 127 there is no program fresco; negative: the number of the signal that
    ended it."""

    def __init__(self, text: str, exit_code: int) -> None:
        super().__init__(text)
        self.exit_code = exit_code


@dataclasses.dataclass
class Progress:
    """How far a run is."""

    seconds: float = 0.0  #: Since it began.
    ended: int = 0  #: Stages.
    running: dict[str, str] = dataclasses.field(default_factory=dict)  #: Of each running stage: "12/48 frames", or "".
    metrics: dict[str, dict[str, float]] = dataclasses.field(default_factory=dict)  #: Of running stages: the newest values.
    message: str = ""  #: The newest line of a stage: "scan: 48 frames, 211466 faces".

    def __str__(self) -> str:
        stages = ", ".join(f"{stage} {done}".rstrip() for stage, done in self.running.items())
        return f"{self.seconds:.0f} s, {self.ended} stages ended; running: {stages or 'none'}"

    def _add(self, event: Mapping[str, Any]) -> None:
        kind, stage = event.get("event"), event.get("stage", "")
        if kind == "begin":
            self.running[stage] = ""
        elif kind == "progress":
            self.running[stage] = f"{event['done']:.0f}/{event['total']:.0f} {event['unit']}".rstrip()
            self.metrics[stage] = dict(event["metrics"])
        elif kind == "end":
            self.ended += 1
            self.running.pop(stage, None)
            self.metrics.pop(stage, None)
        elif kind in ("message", "warning"):
            self.message = f"{stage}: {event['text']}"


def check(pipeline: PipelineLike, variables: Optional[Mapping[str, Any]] = None, *, preview: bool = False) -> None:
    """Raises FrescoError with all problems of a pipeline, as `fresco check` reports them. The arguments are those of run()."""
    command, text = _command("check", pipeline, variables)
    done = subprocess.run(command + ["--preview"] * preview, input=text, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode != 0:
        raise _failure(done.stderr, done.returncode)


def run(pipeline: PipelineLike, variables: Optional[Mapping[str, Any]] = None, *, out: Optional[PathLike] = None, store: PathLike = ".fresco",
        cores: Optional[int] = None, preview: bool = False, until: Optional[str] = None,
        on_progress: Optional[Callable[[Progress], object]] = None) -> Result:
    """Runs a pipeline and returns its results; of a matrix, see Result.combinations.

    `pipeline` is the path of a pipeline file, or what such a file holds, as a dict ("version" may be left out; its relative paths are those
    of the working directory). Its results go to `out`, by default "out", of a preview "out/preview". `variables` are what --set sets: {"data": "my_scan", "texture.stroke_cm": 6}. `on_progress` is called in this
    thread at every event, at least once per second.

    Raises FrescoError. A KeyboardInterrupt, or what `on_progress` raises, stops the run: fresco ends its stages, keeps their checkpoints, and
    the next run resumes; then the exception continues."""
    out = out if out is not None else "out/preview" if preview else "out"
    words = ["--json-log", "--out", os.fspath(out), "--store", os.fspath(store), *["--preview"] * preview]
    words += ["--cores", str(cores)] if cores is not None else []
    words += ["--until", until] if until is not None else []
    command, text = _command("run", pipeline, variables)
    with tempfile.TemporaryFile("w+", errors="replace") as errors, tempfile.TemporaryFile("w+") as given:
        given.write(text)
        given.seek(0)
        # In a session of its own: Ctrl-C reaches Python, which then asks fresco to stop, once.
        process = subprocess.Popen(command + words, stdin=given, stdout=subprocess.PIPE, stderr=errors, text=True, errors="replace",
                                   start_new_session=True)
        assert process.stdout is not None
        try:
            failures = _follow(process.stdout, on_progress)
        except BaseException:
            process.send_signal(signal.SIGINT)
            raise
        finally:
            code = process.wait()
        if code != 0:
            errors.seek(0)
            raise _failure("\n".join([*failures, errors.read()]).strip() or f"fresco ended with {code}", code)
    return open_results(out)


def _command(name: str, pipeline: PipelineLike, variables: Optional[Mapping[str, Any]]) -> tuple[list[str], str]:
    """The words of a command, and what it reads from standard input."""
    import fresco

    if shutil.which(fresco.program) is None:
        raise FrescoError(f"error: the command '{fresco.program}' was not found: add its folder to the PATH, or set fresco.program to its path", 127)
    sets = [f"{key}={value if isinstance(value, str) else json.dumps(value)}" for key, value in (variables or {}).items()]
    words = [word for text in sets for word in ("--set", text)]
    if isinstance(pipeline, Mapping):
        # JSON is YAML.
        return [fresco.program, name, "-", *words], json.dumps({"version": 1, **pipeline}, default=os.fspath, ensure_ascii=False, indent=1)
    return [fresco.program, name, os.fspath(pipeline), *words], ""


def _failure(text: str, exit_code: int) -> FrescoError:
    # Of a dict, no line and column.
    return FrescoError(re.sub("^-:[0-9]+:[0-9]+: ", "", text.strip(), flags=re.MULTILINE), exit_code)


def _follow(output: IO[str], on_progress: Optional[Callable[[Progress], object]]) -> list[str]:
    """The errors of stages, when the run has ended."""
    lines: queue.Queue[Optional[str]] = queue.Queue()

    def read() -> None:
        # To the end, whatever becomes of the caller: nobody waits for a full pipe.
        with output:
            for line in output:
                lines.put(line)
        lines.put(None)

    threading.Thread(target=read, daemon=True).start()
    progress, begin = Progress(), time.monotonic()
    failures: list[str] = []
    while True:
        try:
            line = lines.get(timeout=0.5)
            if line is None:
                return failures
            event = json.loads(line)
            progress._add(event)
            if event.get("event") == "end" and event["error"]:
                failures.append(f"{event['stage']}: error: {event['error']}")
        except queue.Empty:
            pass
        progress.seconds = time.monotonic() - begin
        if on_progress is not None:
            on_progress(progress)
