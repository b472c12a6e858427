#!/usr/bin/env python3
"""conformance.py FRESCO SOURCE PLUGINS: what every stage and component in the tree must keep to, asked of the program.

Every library loads; a library is named after its type; help, ports and options are complete and named by the rules; each folder has a
README that leads to the type's page of the reference; an option of the wrong kind and a misspelled one are refused with the place; the committed
pages of the reference are those that the declarations give.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

FRESCO, SOURCE, PLUGINS = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
WORK = tempfile.TemporaryDirectory(prefix="fresco-conformance-")
ENVIRONMENT = dict(os.environ, XDG_DATA_HOME=WORK.name)
ENVIRONMENT.pop("FRESCO_PLUGIN_PATH", None)
SNAKE = re.compile(r"[a-z][a-z0-9_]*$")
problems = []


def fresco(*arguments):
    done = subprocess.run([FRESCO, *arguments], capture_output=True, text=True, env=ENVIRONMENT)
    return done.returncode, done.stdout, done.stderr


def expect(condition, text):
    if not condition:
        problems.append(text)


# Kinds of options that cannot be a list; the others cannot be a word.
NO_LISTS = ("text", "input_file", "input_folder", "input_path", "output_name", "component", "components")


def check_option(name, option):
    where = f"{name}.{option['name']}"
    expect(SNAKE.match(option["name"]), f"{where}: is not snake_case")
    expect(len(option.get("help", "")) > 5 and "\n" not in option["help"], f"{where}: has no help, or more than a line")
    if "default" in option and "min" in option:
        values = option["default"] if isinstance(option["default"], list) else [option["default"]]
        expect(all(option["min"] <= value <= option.get("max", float("inf")) for value in values), f"{where}: default outside its range")
    if "choices" in option and "default" in option:
        expect(option["default"] in option["choices"], f"{where}: default is not one of its choices")


def check_type(entry):
    name = entry["type"]
    status, text, errors = fresco("describe", name, "--json")
    if status != 0:
        return problems.append(f"{name}: describe failed: {errors}")
    described = json.loads(text)
    declaration = described.get("declaration", described)
    library = pathlib.Path(described["library"])
    folder = SOURCE / "plugins" / library.stem.replace("_", "/", 1)
    # A plugin that writes files may also read how they were made, and show its artifacts.
    expect(library.stem == name.replace(".", "_") or entry["kind"] in ("origin", "viewer"), f"{name}: is in {library.name}")
    expect(SNAKE.match(folder.name), f"{name}: is not kind.name in snake_case")
    expect(f"reference/{name}.md)" in (folder / "README.md").read_text(), f"{name}: README does not link to the type's page of the reference")
    for option in declaration["options"]:
        check_option(name, option)
    for port in declaration["inputs"] + declaration["outputs"]:
        expect(SNAKE.match(port["name"]) and len(port["help"]) > 5, f"{name}: port {port['name']} is not snake_case, or has no help")
    if entry["kind"] == "stage":
        check_refusals(name, declaration)


def check_refusals(name, declaration):
    """Every option with a wrong value and a misspelled one, all in one file: each is reported at its line."""
    lines = ["version: 1", "stages:", "  tested:", f"    type: {name}", "    no_such_option: 1"]
    expected = {5: "no_such_option"}
    for option in declaration["options"]:
        lines.append(f"    {option['name']}: {'[1]' if option['kind'] in NO_LISTS else 'word'}")
        expected[len(lines)] = option["name"]
    file = pathlib.Path(WORK.name) / "wrong.yaml"
    file.write_text("\n".join(lines) + "\n")
    status, out, errors = fresco("check", str(file))
    expect(status == 2, f"{name}: check of wrong options ended with {status}")
    for line, option in expected.items():
        expect(re.search(rf"wrong\.yaml:{line}:\d+: error: .*{option}", out + errors), f"{name}: wrong value of {option} is not reported at line {line}")


def check_reference():
    made, kept = pathlib.Path(WORK.name) / "reference", SOURCE / "sdk/docs/reference"
    status, _, errors = fresco("reference", str(made))
    expect(status == 0, f"fresco reference ended with {status}: {errors}")
    for name in sorted({page.name for folder in (kept, made) for page in folder.glob("*.md")}):
        texts = [(folder / name).read_text() if (folder / name).exists() else "" for folder in (kept, made)]
        expect(texts[0] == texts[1], f"sdk/docs/reference/{name} is not what the plugins declare: run fresco reference sdk/docs/reference")


status, text, errors = fresco("stages", "--all", "--json")
if status != 0:
    sys.exit(f"fresco stages --all --json ended with {status}: {errors}")
listing = json.loads(text)
expect(not listing.get("refused"), f"libraries refused: {listing.get('refused')}")
types = listing["types"]
libraries = {library.name for library in PLUGINS.glob("*.so")}
expect(len(types) >= len(libraries) > 10, f"{len(types)} types of {len(libraries)} libraries")
for entry in types:
    check_type(entry)
check_reference()
# preview.yaml has options for stages of the others, and none of its own.
for pipeline in sorted(set((SOURCE / "pipelines").glob("**/*.yaml")) - {SOURCE / "pipelines/presets/preview.yaml"}):
    # A missing input is the user's to give (3); anything else is wrong with the file.
    status, out, errors = fresco("check", str(pipeline))
    expect(status in (0, 3), f"{pipeline.name}: check ended with {status}: {out}{errors}")
print(f"{len(types)} types, {len(problems)} problems")
sys.exit("\n".join(problems) if problems else 0)
