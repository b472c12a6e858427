#!/usr/bin/env python3
"""layers.py SOURCE_FOLDER: the host's folders include each other only downward, as framework/CMakeLists.txt stacks them, the SDK includes
nothing of the host or the plugins, and no plugin includes another or the host. The host, the scripts of its pages and the headers of the
SDK that it includes name nothing of rooms: they run any pipeline. Prints every include and every word that does not fit."""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1]).resolve()
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
        tests = root / "framework/tests" / layer
        for path, name in [*includes_of(root / "framework/src" / layer), *(includes_of(tests) if tests.exists() else [])]:
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
        if not target.exists() or root not in target.parents:
            continue
        here, there = (file.relative_to(root).parts for file in (path.resolve(), target))
        if here[0] != there[0] or here[0] == "plugins" and here[1] != there[1]:
            problems.append(f"{path.relative_to(root)} includes {name}, which is in {'/'.join(there[:2])}")


ROOM_WORDS = set("""mesh meshes texture textures texel texels frames face faces voxel voxels pixel pixels camera cameras png jpeg jpg npy glb
gltf ply obj usdz vgg vgg19 safetensors relief mixture""".split())
REPORTED = {"judged_frames"}  # What any stage may report: sdk/docs/report.md.


def room_words(text):
    """Of the code with their lines; not of comments, and not of texts for people, which are more than a word."""
    def kept(match):
        found = match.group()
        if found.startswith("`"):
            return "".join(re.findall(r"\$\{[^}]*\}|\n", found))
        return found if found.startswith('"') and " " not in found else re.sub(r"[^\n]", "", found)

    text = re.sub(r"//[^\n]*|/\*.*?\*/|R\"(\w*)\(.*?\)\1\"|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\]|\\.)+'|`(?:[^`\\]|\\.)*`", kept, text, flags=re.DOTALL)
    for number, line in enumerate(text.splitlines(), 1):
        for name in re.findall(r"\w+", line):
            if name not in REPORTED and ROOM_WORDS & set(re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", name).lower().split("_")):
                yield number, name


def check_words():
    host = [path for path in (root / "framework/src").rglob("*") if path.suffix in (".cpp", ".h")]
    contract, found = set(), list(host)
    while found:
        for name in include.findall(found.pop().read_text(encoding="utf-8")):
            header = root / "sdk/include" / name
            if header not in contract and header.exists():
                contract.add(header)
                found.append(header)
    for path in sorted(host) + sorted(contract) + sorted((root / "framework/report").glob("*.js")):
        for line, name in room_words(path.read_text(encoding="utf-8")):
            problems.append(f"{path.relative_to(root)}:{line}: '{name}' is a word of rooms, which the host does not know")


# A planted word is found, in code and in a text of one word, and a comment or a message with it is not.
assert [name for _, name in room_words("f(`a mesh ${face} of\n${faceOf} texels`) // relief")] == ["face", "faceOf"]
assert [name for _, name in room_words('int mesh_count; // a face\nf("ply"); throw E("no mesh"); FaceList x;')] == ["mesh_count", "ply", "FaceList"]
check_host()
check_plugins()
check_words()
print("\n".join(problems) if problems else "every include points down, and the host knows no room")
sys.exit(bool(problems))
