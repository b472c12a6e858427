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
from workplace import PATHS, finish, traced

OPENING = ("open", "openat")
WRITING = ("creat", "mkdir", "mkdirat", "rename", "renameat", "renameat2", "unlink", "unlinkat", "rmdir", "link", "linkat", "symlink",
           "symlinkat", "mknod", "mknodat", "chmod", "fchmod", "fchmodat", "chown", "fchown", "lchown", "fchownat",
           "utime", "utimes", "utimensat", "futimesat", "truncate", "ftruncate", "setxattr", "lsetxattr", "fsetxattr")
NOT_FOLLOWED = ("socket", "bind", "connect", "chdir", "fchdir")
SMALL = {"scan.frames_count": 6, "scan.color_width_px": 128, "scan.color_height_px": 96, "scan.edge_m": 0.15, "mesh.max_faces": 3000,
         "atlas.size_px": 256, "uvmaps.heights_px": "[48]", "texture.stroke_cm": 30, "texture.rounds_count": 1}
SMALL_SCAN = {"scan.every": 25, "mesh.max_faces": 20000, "atlas.size_px": 1024, "uvmaps.heights_px": "[64]"}
SMALL_PAINTING = {"texture.stroke_cm": 10, "texture.rounds_count": 1}
# The C library asks there for the name of the user when another library wants to know it.
HARMLESS = re.compile(r'^socket\(AF_UNIX|sun_path="(/var)?/run/nscd/socket"')
CALL = re.compile(r"^(\w+)\((.*)\) += ")
DESCRIPTOR = re.compile(r"^\d+<((?:[^<>\\]|\\.)*)>")


def touched(call, words):
    """The paths that a call writes to. Nothing is kept of what goes to a pipe, a file without a name, or a device."""
    found = [os.path.normpath(os.path.join(folder, name.encode().decode("unicode_escape"))) for folder, name in PATHS.findall(words)]
    if "link" in call and "unlink" not in call:
        found = found[-1:]  # What a link names is not touched.
    if not found and (match := DESCRIPTOR.match(words)):
        found = [match[1].removesuffix(" (deleted)")]
    paths = [os.path.realpath(path) if call in OPENING else path for path in found]
    return [path for path in paths if path not in ("/dev/null", "/dev/tty") and not re.match(r"(pipe|socket|anon_inode):", path)]


def trace(given, work, pipeline, settings):
    """Runs a pipeline; the calls that write, and what is wrong."""
    folder = work / pipeline.stem
    places = {name: folder / name for name in ("out", "store", "tmp", "home", "here")}
    for name in ("tmp", "home", "here"):
        places[name].mkdir(parents=True)
    environment = {"PATH": os.environ["PATH"], "HOME": str(places["home"]), "TMPDIR": str(places["tmp"]), "LC_ALL": "C.UTF-8"}
    command = [given.fresco, "run", pipeline, "--out", places["out"], "--store", places["store"], "--cores", "2"]
    command += [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    done, lines = traced("writes", ",".join(OPENING + WRITING + NOT_FOLLOWED), command, folder / "trace", cwd=places["here"], env=environment)
    problems, written = [], 0
    allowed = tuple(f"{places[name]}/" for name in ("out", "store", "tmp"))
    for line in lines:
        # What is not there cannot be touched, and nothing is made of what there is.
        if not (match := CALL.match(line)) or "ENOENT" in line or "EEXIST" in line:
            continue
        call, words = match.groups()
        if call in NOT_FOLLOWED:
            problems += [] if HARMLESS.search(line) else [line]
        elif call not in OPENING or re.search(r"O_WRONLY|O_RDWR|O_CREAT|O_TRUNC|O_TMPFILE", words):
            written += 1
            problems += [f"{path}: {line}" for path in touched(call, words) if not f"{path}/".startswith(allowed)]
    if done.returncode != 0:
        problems.append(f"the run ended with {done.returncode}: {done.stderr}")
    if written < 50:
        problems.append(f"only {written} calls that write were seen: this test looks in the wrong place")
    problems += [f"{left} is left" for name in ("home", "here") for left in places[name].iterdir()]
    print(f"  {pipeline.name}: {len(lines)} calls, {written} that write")
    return written, problems


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
                  (ready / "model.yaml", picture | {"model": data / "mesh.ply", "mesh.max_faces": 20000, "atlas.size_px": 1024})]
    with tempfile.TemporaryDirectory(prefix="fresco-prove-") as work:
        traces = [trace(given, pathlib.Path(work).resolve(), *case) for case in cases]
    problems = [problem for _, found in traces for problem in found]
    finish(problems, f"{len(cases)} pipelines, {sum(written for written, _ in traces)} calls that write: {len(problems)} elsewhere, or sockets")


main()
