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
from workplace import Workplace, arguments, some_of

PIPELINE = """version: 1
vars: {plus: 1, count: 4, target: text.txt}
stages:
  base:   {type: test.source, value: 1, file: extra}
  sum:    {type: test.add, input: {left: base}, plus: "${plus}"}
  text:   {type: test.sink, input: sum, path: "${target}", copies: 2}
  pieces: {type: test.pieces, count: "${count}"}
"""
MATRIX = PIPELINE + "matrix: {plus: [1, 2]}\n"
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

    def holds(self, **files):
        for name, text in files.items():
            path = name.replace("__", "/").replace("_txt", ".txt")
            assert self.text(path) == text, f"{path} holds {self.text(path)!r}, not {text!r}"


def foreign(name):
    def case(site):
        site.keep(f"out/{name}")
        site.refused(name=name)
    return case


def changed(name):
    def case(site):
        site.run()
        site.write(f"out/{name}", MINE)
        site.keep(f"out/{name}")
        site.refused("--set", "plus=2", "--set", "count=5", name=name) if name != "piece_2.txt" else site.refused("--set", "count=5", name=name)
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


def own_files(*words):
    def case(site):
        site.run(*words)
        first = site.text("out/text.txt")
        site.run("--set", "plus=2", *words)
        assert site.text("out/text.txt") != first
        site.run(*words)
        assert site.text("out/text.txt") == first
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


def changed_sweep(site):
    site.write("room.yaml", MATRIX)
    site.run()
    site.run()
    page = site.folder / "out/sweep.html"
    page.write_text(page.read_text().replace("</body>", "my notes</body>"))
    site.keep("out/sweep.html")
    site.refused("--set", "target=other.txt", name="sweep.html")


def report_is_input(site):
    site.run()
    site.write("room.yaml", PIPELINE.replace("file: extra", "file: out/run.json"))
    site.keep("out/run.json")
    for more in ([], ["--replace"]):
        site.run(*more, code=1, says="run.json: is an input of this pipeline")


def odd_paths(site):
    """The same file, whatever its path looks like."""
    site.run("--set", "target=a//text.txt")
    site.run("--set", "target=a//text.txt", "--set", "plus=2")


def the_record(site):
    site.run("--set", "target=.fresco-outputs", code=1, says="is the name of fresco's record")


def moved_project(site):
    site.run()
    moved = site.folder.with_name(site.folder.name + "-moved")
    site.folder.rename(moved)
    site.folder = moved
    site.run("--set", "plus=2")


def another_pipeline(site):
    site.run("--no-report")
    site.write("other.yaml", PIPELINE)
    site.keep("out/text.txt")
    site.refused("--set", "plus=2", file="other.yaml", name="room.yaml")


def reports_of_another_pipeline(site):
    """What tells of a run is replaced by the next run's."""
    site.run()
    site.write("other.yaml", "version: 1\nstages: {base: {type: test.source, value: 1}, text: {type: test.sink, input: base, path: o.txt}}\n")
    site.keep("out/text.txt")
    site.run(file="other.yaml")


def stale_removed(site):
    site.run()
    site.run("--set", "count=2", says="pieces: removed 2 files of the last run")
    site.holds(out__piece_1_txt="piece 1\n", out__piece_2_txt=None, out__piece_3_txt=None)


def stale_changed(site):
    site.run()
    site.write("out/piece_3.txt", MINE)
    site.keep("out/piece_3.txt")
    site.refused("--set", "count=2", name="piece_3.txt")
    site.run("--set", "count=2", "--replace")


def stale_foreign(site):
    site.run()
    site.keep("out/piece_9.txt")
    site.keep("out/notes/mine.txt")
    site.run("--set", "count=2")


def stale_until(site):
    site.run()
    site.keep("out/piece_3.txt")
    site.run("--until", "text", "--set", "count=2")


def stale_dropped(site):
    site.run()
    site.keep("out/piece_3.txt")
    site.write("room.yaml", PIPELINE[:PIPELINE.index("  pieces")].replace("count: 4, ", ""))
    site.run("--set", "plus=2")


def stale_failed(site):
    site.run()
    site.keep("out/piece_3.txt")
    site.write("room.yaml", PIPELINE[:PIPELINE.index("  pieces")].replace("count: 4, ", "") + "  pieces: {type: test.fail, input: sum}\n")
    site.run("--set", "plus=2", code=1, says="two found")


def stale_renamed(site):
    """Another path is another result: the old one is kept, and may be edited."""
    site.run()
    site.write("out/text.txt", MINE)
    site.keep("out/text.txt")
    site.run("--set", "target=other.txt")
    site.holds(out__other_txt="5.000000\n")


def other_combination(site):
    site.write("room.yaml", MATRIX)
    site.run()
    site.keep("out/plus=1/text.txt")
    site.keep("out/plus=1/copies/1.txt")
    site.write("room.yaml", MATRIX.replace("copies: 2", "copies: 1"))
    site.run("--set", "plus=2")
    assert site.text("out/plus=2/copies/1.txt") is None


def foreign_in_combination(site):
    site.write("room.yaml", MATRIX)
    site.keep("out/plus=2/text.txt")
    site.refused(name="plus=2/text.txt")


def foreign_progress(site):
    site.keep("out/progress/sum/texture.png")
    site.refused(name="out/progress/sum")


def foreign_sweep(site):
    site.write("room.yaml", MATRIX)
    site.keep("out/sweep.json")
    site.refused(name="sweep.json")


def onto(name, *words, setup=None, text=None):
    """An output that is an input or a pipeline file, however it is reached; --replace changes nothing."""
    def case(site):
        if setup:
            setup(site)
        site.keep(name)
        site.run("--set", f"target={text or name}", *words, code=1, says="--out")
        site.run("--set", f"target={text or name}", *words, "--replace", code=1, says="is an input of this pipeline")
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


def loop(site):
    """The pipeline reads what it would write."""
    site.run()
    site.write("room.yaml", PIPELINE.replace("file: extra", "file: out/text.txt"))
    site.keep("out/text.txt")
    for more in ([], ["--replace"]):
        site.run(*more, code=1, says="is an input of this pipeline")


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
CASES |= {f"a changed {name}": changed(name) for name in OUTPUTS}
CASES |= {f"a {kind} link at {name}": linked(name, kind) for name in OUTPUTS for kind in ("soft", "hard")}
CASES |= {f"--replace of {name}": replaced(name) for name in OUTPUTS}
CASES |= {f"own files {' '.join(words)}": own_files(*words) for words in ([], ["--no-report"], ["--quiet"], ["--out", "./x/../out"])}
CASES |= {f"killed at {point}": after_kill(point) for point in ("export.written", "export.copied")}
CASES |= {
    "an unreadable entry": unreadable, "a changed sweep.html": changed_sweep, "a report as input": report_is_input, "odd paths": odd_paths,
    "the record's name": the_record,
    "the same contents": same_contents, "after a failed run": after_failed_run, "a moved project": moved_project,
    "another pipeline's": another_pipeline, "reports of another pipeline": reports_of_another_pipeline,
    "stale, removed": stale_removed, "stale, changed": stale_changed, "stale, foreign": stale_foreign, "stale, --until": stale_until,
    "stale, dropped stage": stale_dropped, "stale, failed stage": stale_failed, "stale, renamed": stale_renamed,
    "another combination's": other_combination, "foreign in a combination": foreign_in_combination, "foreign sweep.json": foreign_sweep,
    "foreign pictures of progress": foreign_progress,
    "onto an input": onto("extra", "--out", "."), "onto an input by ..": onto("extra", "--out", "x/.."),
    "onto an input by a link": onto("extra", "--out", "elsewhere", setup=link_to_project),
    "onto the pipeline file": onto("room.yaml", "--out", "."), "onto its base": onto("base.yaml", "--out", ".", setup=base_file),
    "onto a folder's file": onto("data/a", "--out", ".", setup=folder_input), "onto a folder's file inside": onto("data/a", "--out", "data", setup=folder_input, text="a"),
    "onto an input's second name": onto("extra", "--out", "out", setup=hard_linked_input, text="text.txt"),
    "onto its own input": loop, "an input that is a link": input_link,
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
    print("\n".join(problems))
    print(f"{len(names)} ways to lose a file of the user's: {len(problems)} lost or not named")
    sys.exit(bool(problems))


main()
