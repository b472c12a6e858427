#!/usr/bin/env python3
"""Puts files of the user's where fresco writes, reads or cleans up, lets it work, and compares their contents before and after: in the
output folder, as inputs and pipeline files, and where commands write (in a store: test_store_tidy.cpp). What fresco wrote itself it replaces and removes.
--cases N with --long tries a random part."""
import os
import pathlib
import re
import signal
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from workplace import Workplace, arguments, finish, some_of

PIPELINE = """version: 1
vars: {plus: 1, count: 4, target: text.txt}
stages:
  base:   {type: test.source, value: 1, file: extra}
  sum:    {type: test.add, input: {left: base}, plus: "${plus}"}
  text:   {type: test.sink, input: sum, path: "${target}", copies: 2}
  pieces: {type: test.pieces, count: "${count}"}
"""
MATRIX = PIPELINE + "matrix: {plus: [1, 2]}\n"
WITHOUT_PIECES = PIPELINE[:PIPELINE.index("  pieces")].replace("count: 4, ", "")
# Of the last two, no pipeline file says that they will be written.
OUTPUTS = ("text.txt", "run.json", "report.html", "copies/0.txt", "piece_2.txt")
MINE = "mine\n"


class Case:
    """A project folder, and the contents that must stay."""

    def __init__(self, place, folder):
        self.place, self.folder = place, folder
        self.kept = {}
        self.write("extra", "123")
        self.write("room.yaml", PIPELINE)

    def write(self, name, text):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def keep(self, name, text=MINE):
        """Writes a file of the user's, unless it is there, and notes what it holds."""
        file = self.folder / name
        if not os.path.lexists(file):
            self.write(name, text)
        self.kept[file] = (file.read_bytes(), file.stat().st_mode, os.path.islink(file))
        return file

    def check_kept(self):
        for file, before in self.kept.items():
            now = (file.read_bytes(), file.stat().st_mode, os.path.islink(file)) if os.path.lexists(file) else "deleted"
            assert now == before, f"{file.relative_to(self.folder)} was {before}, is {now}"

    def call(self, *words, code=0, says=""):
        ended = self.place.call(*words, folder=self.folder)
        assert ended.code == code, f"{' '.join(words)}: {ended}"
        assert re.search(says, ended.text), f"{' '.join(words)}: does not say '{says}': {ended}"
        self.check_kept()
        return ended

    def run(self, *words, file="room.yaml", **expected):
        return self.call("run", file, *words, **expected)

    def refused(self, *words, name="", **expected):
        """The run names the file and both ways out."""
        return self.run(*words, code=1, says=re.escape(name) + r".*--out(.|\n)*--replace", **expected)

    def text(self, name):
        file = self.folder / name
        return file.read_text() if file.is_file() else None


def foreign(name, pipeline=PIPELINE, says=None):
    """A file of the user's where fresco would write."""
    def case(site):
        site.write("room.yaml", pipeline)
        site.keep(f"out/{name}")
        site.refused(name=says or name)
    return case


def again(*words, before=PIPELINE, first=(), changed=(), kept=(), after=None, file="room.yaml", refused=None, gone=(), **expected):
    """A run of the pipeline `before`; the user changes outputs and adds files; another run, of `after`, with these words."""
    def case(site):
        site.write("room.yaml", before)
        site.run(*first)
        for name in changed:
            site.write(name, MINE)
        for name in (*changed, *kept):
            site.keep(name)
        site.write(file, after or before)
        site.refused(*words, name=refused, file=file) if refused else site.run(*words, file=file, **expected)
        assert not any(os.path.lexists(site.folder / name) for name in gone), f"one of {gone} is left"
    return case


def linked(name, kind):
    def case(site):
        target = site.keep("thesis.txt")
        link = site.folder / "out" / name
        link.parent.mkdir(parents=True, exist_ok=True)
        (os.link if kind == "hard" else os.symlink)(target, link)
        site.kept[link] = site.kept[target][:2] + (kind == "soft",)
        site.refused(name=name)
    return case


def replaced(name):
    def case(site):
        site.write(f"out/{name}", MINE)
        site.run("--replace")
        assert site.text(f"out/{name}") != MINE
        site.run("--set", "plus=2")
    return case


def same_contents(site):
    """Equal to what fresco writes, but the user's: the next painting would replace it."""
    site.run("--out", "first")
    site.keep("out/text.txt", site.text("first/text.txt"))
    site.run()
    site.refused("--set", "plus=2", name="text.txt")


def own_files(*words, name="out/text.txt"):
    def case(site):
        site.run(*words)
        first = site.text(name)
        site.run("--set", "plus=2", *words)
        assert site.text(name) != first
        site.run(*words)
        assert site.text(name) == first
    return case


def after_failed_run(site):
    site.write("room.yaml", PIPELINE + "  bad: {type: test.fail, input: sum}\n")
    site.run(code=1)
    site.run("--set", "plus=2", code=1, says="test.fail|bad")
    site.write("room.yaml", PIPELINE)
    site.run("--set", "plus=3")


def after_kill(point):
    """Killed between writing and naming a file, or between two files: the next run knows its own."""
    def case(site):
        site.run()
        for plus in (2, 3):
            process = site.place.start("run", "room.yaml", "--set", f"plus={plus}", folder=site.folder, environment={"FRESCO_FAULT": point})
            assert process.wait() == -signal.SIGKILL
        site.run("--set", "plus=4")
    return case


def unreadable(site):
    """Nobody can tell whether it changed."""
    site.run("--no-report")
    record = site.folder / "out/.fresco-outputs"
    record.write_text(record.read_text().replace("text.txt", "text.tx_"))
    site.keep("out/text.txt")
    site.refused("--set", "plus=2", name="text.txt")


def moved_project(site):
    site.run()
    moved = site.folder.with_name(site.folder.name + "-moved")
    site.folder.rename(moved)
    site.folder = moved
    site.run("--set", "plus=2")


def onto(name, *words, setup=None, text=None):
    """An output that is an input or a pipeline file, however it is reached; --replace changes nothing."""
    def case(site):
        if setup:
            setup(site)
        site.keep(name)
        site.run("--set", f"target={text or name}", *words, code=1, says="--out")
        # Results of other stages may land in the folder while a stage still reads it.
        site.run("--set", f"target={text or name}", *words, "--replace", code=1, says="is an input of this pipeline|changed while the stage read")
    return case


def link_to_project(site):
    (site.folder / "elsewhere").symlink_to(site.folder)


def base_file(site):
    site.write("base.yaml", PIPELINE)
    site.write("room.yaml", "version: 1\nbase: base.yaml\n")


def folder_input(site):
    site.write("data/a", "1")
    site.write("room.yaml", PIPELINE.replace("file: extra", "folder: data"))


def hard_linked_input(site):
    (site.folder / "out").mkdir()
    os.link(site.folder / "extra", site.folder / "out/text.txt")


def input_link(site):
    """A link to data elsewhere, in a project that writes into its own folder."""
    site.write("elsewhere.bin", "1234567")
    (site.folder / "extra").unlink()
    (site.folder / "extra").symlink_to(site.folder / "elsewhere.bin")
    site.keep("extra")
    site.run("--out", ".", "--no-report")


def refuses(file, *words, code=2):
    def case(site):
        site.keep(file)
        site.call(*words, code=code, says="already exists|not empty|move it away|is not a page")
    return case


CASES = {f"a foreign {name}": foreign(name) for name in OUTPUTS}
CASES |= {f"a changed {name}": again("--set", "plus=2", "--set", "count=5", changed=[f"out/{name}"], refused=name) for name in OUTPUTS}
CASES |= {f"a {kind} link at {name}": linked(name, kind) for name in OUTPUTS for kind in ("soft", "hard")}
CASES |= {f"--replace of {name}": replaced(name) for name in OUTPUTS}
CASES |= {f"own files {' '.join(words)}": own_files(*words) for words in ([], ["--no-report"], ["--quiet"], ["--out", "./x/../out"])}
CASES |= {f"killed at {point}": after_kill(point) for point in ("export.written", "export.copied")}
# The pipeline reads what it would write, or the last run's report.
CASES |= {f"{file} as input {' '.join(words)}": again(*words, kept=[f"out/{file}"], after=PIPELINE.replace("file: extra", f"file: out/{file}"),
                                                     code=1, says="is an input of this pipeline")
          for file in ("text.txt", "run.json") for words in ([], ["--replace"])}
CASES |= {
    "an unreadable entry": unreadable, "the same contents": same_contents, "after a failed run": after_failed_run, "a moved project": moved_project,
    "odd paths": own_files("--set", "target=a//text.txt", name="out/a/text.txt"),
    "the record's name": again("--set", "target=.fresco-outputs", code=1, says="is the name of fresco's record"),
    "a changed sweep.html": again("--set", "target=other.txt", before=MATRIX, changed=["out/sweep.html"], refused="sweep.html"),
    "another pipeline's": again("--set", "plus=2", first=["--no-report"], kept=["out/text.txt"], file="other.yaml", refused="room.yaml"),
    # What tells of a run is replaced by the next run's.
    "reports of another pipeline": again(kept=["out/text.txt"], file="other.yaml",
                                         after=WITHOUT_PIECES.replace("${target}", "o.txt").replace("copies: 2", "")),
    "stale, removed": again("--set", "count=2", kept=["out/piece_1.txt"], gone=["out/piece_2.txt", "out/piece_3.txt"],
                            says="pieces: removed 2 files of the last run"),
    "stale, changed": again("--set", "count=2", changed=["out/piece_3.txt"], refused="piece_3.txt"),
    "stale, foreign": again("--set", "count=2", kept=["out/piece_9.txt", "out/notes/mine.txt"]),
    "stale, --until": again("--until", "text", "--set", "count=2", kept=["out/piece_3.txt"]),
    "stale, dropped stage": again("--set", "plus=2", kept=["out/piece_3.txt"], after=WITHOUT_PIECES),
    "stale, failed stage": again("--set", "plus=2", kept=["out/piece_3.txt"],
                                 after=WITHOUT_PIECES + "  pieces: {type: test.fail, input: sum}\n", code=1, says="two found"),
    # Another path is another result: the old one is kept, and may be edited.
    "stale, renamed": again("--set", "target=other.txt", changed=["out/text.txt"]),
    "another combination's": again("--set", "plus=2", before=MATRIX, kept=["out/plus=1/text.txt", "out/plus=1/copies/1.txt"],
                                   after=MATRIX.replace("copies: 2", "copies: 1"), gone=["out/plus=2/copies/1.txt"]),
    "foreign in a combination": foreign("plus=2/text.txt", MATRIX), "foreign sweep.json": foreign("sweep.json", MATRIX),
    "foreign pictures of progress": foreign("progress/sum/texture.png", says="out/progress/sum"),
    "onto an input": onto("extra", "--out", "."), "onto an input by ..": onto("extra", "--out", "x/.."),
    "onto an input by a link": onto("extra", "--out", "elsewhere", setup=link_to_project),
    "onto the pipeline file": onto("room.yaml", "--out", "."), "onto its base": onto("base.yaml", "--out", ".", setup=base_file),
    "onto a folder's file": onto("data/a", "--out", ".", setup=folder_input), "onto a folder's file inside": onto("data/a", "--out", "data", setup=folder_input, text="a"),
    "onto an input's second name": onto("extra", "--out", "out", setup=hard_linked_input, text="text.txt"), "an input that is a link": input_link,
    "init": refuses("project/room.yaml", "init", "project"), "reference": refuses("pages/test.sink.md", "reference", "pages", code=1),
    "new": refuses("my_stage/stage.cpp", "new", "stage", "my.stage"),
}


def main():
    given = arguments(__doc__)
    names = some_of(given, list(CASES))
    problems = []
    with Workplace(given.fresco, [given.plugins / "good/test_stages.so"]) as place:
        for number, name in enumerate(names):
            folder = place.work / f"case-{number}"
            folder.mkdir()
            try:
                CASES[name](Case(place, folder))
            except AssertionError as error:
                problems.append(f"{name}: {error}")
    finish(problems, f"{len(names)} ways to lose a file of the user's: {len(problems)} lost or not named")


main()
