#!/usr/bin/env python3
"""writes.py FRESCO SOURCE [--long]: runs ready pipelines under strace. Every file that is made, written, renamed, linked, removed or given
other attributes lies below --out, --store or $TMPDIR, and no socket is opened to anywhere: the pair between the host and
a stage's process has no address, and glibc's question for the user's name (nscd) does not leave the machine.

pipelines/demo.yaml in its smallest form; with --long every ready pipeline that needs no weights, on the recording ../shared/data where it
is. Skipped without strace, or where the system does not allow tracing."""
import argparse
import os
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import traced

WRITING = ("creat", "mkdir", "mkdirat", "rename", "renameat", "renameat2", "unlink", "unlinkat", "rmdir", "link", "linkat", "symlink",
           "symlinkat", "mknod", "mknodat", "chmod", "fchmod", "fchmodat", "chown", "fchown", "lchown", "fchownat",
           "utime", "utimes", "utimensat", "futimesat", "truncate", "ftruncate", "setxattr", "lsetxattr", "fsetxattr", "bind", "connect")
STARTING = ("clone", "clone3", "fork", "vfork")
TRACED = ("open", "openat", "openat2", "socket", "chdir", "fchdir", *WRITING, *STARTING)
SMALL = {"scan.frames_count": 6, "scan.color_width_px": 128, "scan.color_height_px": 96, "scan.edge_m": 0.15, "mesh.max_faces": 3000,
         "atlas.size_px": 256, "uvmaps.heights_px": "[48]", "texture.stroke_cm": 30, "texture.rounds_count": 1}
SMALL_SCAN = {"scan.every": 25, "mesh.max_faces": 20000, "atlas.size_px": 1024, "uvmaps.heights_px": "[64]"}
SMALL_PAINTING = {"texture.stroke_cm": 10, "texture.rounds_count": 1}
# What a link names is not touched.
ONLY_LAST = ("link", "linkat", "symlink", "symlinkat")
# The C library asks there for the name of the user when another library wants to know it.
NAME_SERVICE = re.compile(r'sun_path="(/var)?/run/nscd/socket"')
# Nothing is kept of what goes there.
NOWHERE = ("/dev/null", "/dev/tty")

CALL = re.compile(r"^(\d+) +(\w+)\((.*)\) += (-?\d+|\?)(.*)$")
UNFINISHED = re.compile(r"^(\d+) +(.*) <unfinished \.\.\.>$")
RESUMED = re.compile(r"^(\d+) +<\.\.\. \w+ resumed>(.*)$")
# What precedes a path: the folder it is relative to, as strace -y shows it, or nothing; or a descriptor in place of a path.
PATHS = re.compile(r'(?:(AT_FDCWD|\d+)<((?:[^<>\\]|\\.)*)>, )?"((?:[^"\\]|\\.)*)"')
DESCRIPTOR = re.compile(r"^\d+<((?:[^<>\\]|\\.)*)>")


def whole_lines(trace):
    """The calls of all processes, those that others interrupted put together again."""
    begun = {}
    for line in trace:
        line = line.rstrip("\n")
        if match := UNFINISHED.match(line):
            begun[match[1]] = match[2]
        elif match := RESUMED.match(line):
            yield f"{match[1]} {begun.pop(match[1], '')}{match[2]}"
        else:
            yield line


class Reader:
    """Reads a trace; `problems` are the calls that touch something else."""

    def __init__(self, allowed, start):
        self.allowed, self.folders, self.start = allowed, {}, start
        self.calls, self.written, self.problems = 0, 0, []

    def folder_of(self, process):
        return self.folders.get(process, self.start)

    def absolute(self, process, folder, text):
        path = text.encode().decode("unicode_escape").encode("latin-1").decode(errors="replace")
        base = folder if folder else self.folder_of(process)
        return os.path.normpath(os.path.join(base, path))

    def is_allowed(self, path):
        path = path.removesuffix(" (deleted)")
        if path in NOWHERE or not path.startswith("/"):  # A pipe, or a file that has no name yet.
            return True
        return any(path == folder or path.startswith(folder + "/") for folder in self.allowed)

    def touches(self, process, call, words):
        found = [self.absolute(process, folder, text) for _, folder, text in PATHS.findall(words)]
        if call in ONLY_LAST:
            found = found[-1:]
        if not found and (match := DESCRIPTOR.match(words)):
            found = [match[1]]
        return found

    def take(self, line):
        match = CALL.match(line)
        if not match:
            return
        process, call, words, result, _ = match.groups()
        self.calls += 1
        if call in STARTING and result.isdigit():
            self.folders[result] = self.folder_of(process)
        elif call in ("chdir", "fchdir") and result == "0":
            self.folders[process] = self.touches(process, call, words)[0]
        elif call in ("socket", "bind", "connect"):
            if not (call == "socket" and words.startswith("AF_UNIX")) and not NAME_SERVICE.search(words):
                self.problems.append(line)
        elif call.startswith("open") and not re.search(r"O_WRONLY|O_RDWR|O_CREAT|O_TRUNC|O_TMPFILE", words):
            return
        elif call in WRITING or call.startswith("open"):
            # What is not there cannot be touched, and nothing is made of what there is.
            if "ENOENT" in line or "EEXIST" in line:
                return
            self.written += 1
            for path in self.touches(process, call, words):
                if not self.is_allowed(os.path.realpath(path) if call.startswith("open") else path):
                    self.problems.append(f"{path}: {line}")


def trace(given, work, pipeline, settings):
    """Runs a pipeline; the reader of its trace."""
    folder = work / pipeline.stem
    places = {name: folder / name for name in ("out", "store", "tmp", "home", "here")}
    for name in ("tmp", "home", "here"):
        places[name].mkdir(parents=True)
    environment = {"PATH": os.environ["PATH"], "HOME": str(places["home"]), "TMPDIR": str(places["tmp"]), "LC_ALL": "C.UTF-8"}
    record = folder / "trace"
    command = [given.fresco, "run", pipeline, "--out", places["out"], "--store", places["store"], "--cores", "2"]
    command += [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    done = traced("writes", ",".join(TRACED), command, record, cwd=places["here"], env=environment)
    reader = Reader([str(places[name]) for name in ("out", "store", "tmp")], str(places["here"]))
    with open(record, errors="replace") as lines:
        for line in whole_lines(lines):
            reader.take(line)
    if done.returncode != 0:
        reader.problems.append(f"the run ended with {done.returncode}: {done.stderr}")
    if reader.written < 50:
        reader.problems.append(f"only {reader.written} calls that write were seen: this test looks in the wrong place")
    for name in ("home", "here"):
        if left := list(places[name].iterdir()):
            reader.problems.append(f"{left} is left")
    print(f"  {pipeline.name}: {reader.calls} calls, {reader.written} that write")
    return reader


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fresco", type=pathlib.Path)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--long", action="store_true")
    given = parser.parse_args()
    ready = given.source / "pipelines"
    cases = [(ready / "demo.yaml", SMALL)]
    data = given.source.parent / "shared/data/kitchen"
    if given.long:
        cases.append((ready / "sweep.yaml", SMALL))
    if given.long and data.exists():
        scan = SMALL_SCAN | {"data": data}
        picture = {"picture": ready / "demo.jpg"} | SMALL_PAINTING
        cases += [(ready / "room.yaml", scan | picture), (ready / "photo_texture.yaml", scan), (ready / "prepare.yaml", scan),
                  (ready / "mesh.yaml", picture | {"model": data / "mesh.ply", "mesh.max_faces": 20000, "atlas.size_px": 1024})]
    with tempfile.TemporaryDirectory(prefix="fresco-prove-") as work:
        readers = [trace(given, pathlib.Path(work).resolve(), *case) for case in cases]
    problems = [problem for reader in readers for problem in reader.problems]
    print("\n".join(problems[:50]))
    print(f"{len(cases)} pipelines, {sum(reader.written for reader in readers)} calls that write: {len(problems)} elsewhere, or sockets")
    sys.exit(bool(problems))


main()
