#!/usr/bin/env python3
"""layers.py SOURCE_FOLDER: the host's folders include each other only downward, as framework/CMakeLists.txt stacks them, the SDK includes
nothing of the host or the plugins, and no plugin includes another or the host. Prints every include that does not."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
include = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)
problems = []


def includes_of(folder):
    files = sorted(path for path in folder.rglob("*") if path.suffix in (".cpp", ".h", ".inl"))
    if not files:
        sys.exit(f"{folder} holds no sources: this test looks in the wrong place")
    for path in files:
        for name in include.findall(path.read_text(encoding="utf-8")):
            yield path, name


def host_layers():
    """Each layer with all that it may include: itself, what it is ON, and what those are ON."""
    text = (root / "framework/CMakeLists.txt").read_text(encoding="utf-8")
    below = {}
    for name, arguments in re.findall(r"^fresco_add_layer\((\w+)([^)]*)\)", text, re.MULTILINE):
        words = arguments.split()
        on = words[words.index("ON") + 1:] if "ON" in words else []
        on = on[:next((i for i, word in enumerate(on) if word.isupper()), len(on))]
        below[name] = {name}.union(*(below[layer] for layer in on))
    below["main"] = set(below) | {"main"}
    return below


def check_host():
    below = host_layers()
    folders = {path.name for path in (root / "framework/src").iterdir() if path.is_dir()}
    for name in sorted(folders ^ set(below)):
        problems.append(f"framework/src/{name}: a folder without a layer in framework/CMakeLists.txt, or a layer without a folder")
    for layer in sorted(folders & set(below)):
        sources = list(includes_of(root / "framework/src" / layer))
        if (root / "framework/tests" / layer).exists():
            sources += includes_of(root / "framework/tests" / layer)
        for path, name in sources:
            other = name.split("/")[0]
            if other in folders and other not in below[layer]:
                problems.append(f"{path.relative_to(root)} includes {name}, but '{layer}' is not on '{other}'")
            elif (path.parent / name).exists() and "/" not in name:
                problems.append(f"{path.relative_to(root)} includes {name} without its layer: write {layer}/{name}")


def check_plugins():
    """The SDK includes only itself, plugins/shared also the SDK; no plugin includes another."""
    shared = {path.name for path in (root / "plugins/shared").iterdir() if path.is_dir()}
    for path, name in includes_of(root / "sdk"):
        if re.match(rf"fresco/({'|'.join(shared)})/", name) and "templates" not in path.parts:
            problems.append(f"{path.relative_to(root)} includes {name}, which is in plugins/shared")
    for path, name in list(includes_of(root / "sdk")) + list(includes_of(root / "plugins")):
        target = (path.parent / name).resolve()
        if not target.exists() or root.resolve() not in target.parents:
            continue
        here = path.resolve().relative_to(root.resolve()).parts
        there = target.relative_to(root.resolve()).parts
        if here[0] != there[0] or here[0] == "plugins" and here[1] != there[1]:
            problems.append(f"{path.relative_to(root)} includes {name}, which is in {'/'.join(there[:2])}")


check_host()
check_plugins()
print("\n".join(problems) if problems else "every include points down")
sys.exit(bool(problems))
