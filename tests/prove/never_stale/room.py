"""The pipeline of never_stale.py: what it is made of, the files it reads, and what it must come to."""
import os
import random
import shutil
import struct
import time

# Every file that the pipeline reads keeps this time, whatever is done to it.
TIME_NS = 1_600_000_000 * 10**9

SCRIPT = """# by hand: {0}
table=$(cat "$1"); n=${{table##*\\[}}; n=${{n%%]*}}; n=${{n%%.*}}
read data <"$2"
echo "{{\\"columns\\": [\\"value\\"], \\"rows\\": [[$((n + {0} * data))]]}}" >"$3"
"""

# What can be edited, by kind: its values, of which the first is there at the beginning. A folder's first file may be renamed.
CHOICES = {
    "option": {"base": [1, 2, 3], "pile": [1, 2], "read": [0, 1, 2], "version": ["", "2"], "sum": [0, 1, 2, 3], "factor": [2, 1, 3],
               "left": ["base", "pile"], "name": ["sum", "both"], "wait": [0, 1], "near": ["one", "two"]},
    "bytes": {"set_1/a.number": [b"1", b"2", b"3"], "set_1/b.number": [b"2", b"1", b"3"], "set_2/a.number": [b"3", b"1", b"2"],
              "set_2/b.number": [b"1", b"2", b"3"], "size.bin": [b"aaaa", b"bbbb", b"ccccc"], "add.sh": [1, 2], "data.txt": [b"5\n", b"6\n"],
              "one/list": [b"aaaa", b"bbbb"], "one/near": [b"1", b"2", b"3"], "two/list": [b"aaaa", b"bbbb"], "two/near": [b"2", b"1", b"3"]},
    "link": {"set": ["set_1", "set_2"], "num.number": ["set/a.number", "set/b.number"]},
    "folder": {"first": [("p", b"A"), ("p", b"B"), ("r", b"A"), None], "second": [("q", b"A"), ("q", b"B")]},
    "plugin or library": {"test_stages": [0, 1], "sided": [0, 1], "command": [0, 1], "sdk": [0, 1]},
    "library beside a plugin": {"plugins": [7, 9], "lib": [None, 11, 12]},
    "surroundings": {"language": ["C.UTF-8", "C", "de_DE.UTF-8"], "zone": ["UTC", "Asia/Tokyo"], "search": [False, True], "below": [False, True],
                     "cores": [2, 1, 4], "again": [False, True]},
}
WEIGHTS = {"option": 6, "bytes": 8, "time only": 2, "link": 3, "folder": 4, "plugin or library": 2, "library beside a plugin": 3,
           "surroundings": 3, "exported file": 1, "nothing": 1}


def variant(library, number):
    """Other bytes of the same size, which change nothing that the library does."""
    return library + b"\0\0\0" + bytes([number])


def side_library(library, value):
    """libside.so, whose only function gives this number."""
    seven = struct.pack("<d", 7)
    assert library.count(seven) == 1, "libside.so no longer holds its number once"
    return variant(library.replace(seven, struct.pack("<d", value)), 0)


class Room:
    """The values of CHOICES now, and what comes of them."""

    def __init__(self, place, plugins):
        self.replace = []
        self.place, self.work = place, place.work
        (place.root / "built").mkdir()
        self.libraries = {name: (place.plugins / f"{name}.so").read_bytes() for name in ("test_stages", "sided", "command")}
        self.libraries["sdk"] = (place.root / "lib/libfresco_sdk.so.0").read_bytes()
        self.side = (plugins / "sided/libside.so").read_bytes()
        self.now = {kind: {name: values[0] for name, values in choices.items()} for kind, choices in CHOICES.items()}
        for kind, choices in CHOICES.items():
            for name in choices:
                self.write(kind, name, "beside")
        self.put(place.root / "elsewhere/libside.so", side_library(self.side, 13), "beside")
        (self.work / "below").mkdir()
        (place.root / "again").mkdir()
        (place.root / "again/test_stages.so").symlink_to(place.plugins / "test_stages.so")

    # What is on the disk.

    def put(self, file, data, how):
        """Other bytes under the old time; `how`: in place, beside (renamed over it), or copied."""
        file.parent.mkdir(exist_ok=True)
        beside = self.place.root / "built" / file.name
        beside.write_bytes(data)
        os.utime(beside, ns=(TIME_NS, TIME_NS))
        if how == "in place":
            with open(file, "r+b" if file.exists() else "wb") as stream:
                stream.write(data)
                stream.truncate()
        elif how == "beside":
            os.replace(beside, file)
        else:
            shutil.copy2(beside, file)
        os.utime(file, ns=(TIME_NS, TIME_NS))

    def bytes_of(self, name):
        content = self.now["bytes"][name]
        return SCRIPT.format(content).encode() if name == "add.sh" else content

    def folder(self):
        return dict(filter(None, self.now["folder"].values()))

    def write(self, kind, name, how):
        """Brings the disk to a value of `now`."""
        value = self.now[kind][name]
        if kind == "option":
            self.write_pipeline()
        elif kind == "bytes":
            self.put(self.work / name, self.bytes_of(name), how)
        elif kind == "link":
            beside = self.work / "new link"
            beside.symlink_to(value)
            os.utime(beside, ns=(TIME_NS, TIME_NS), follow_symlinks=False)
            os.replace(beside, self.work / name)
        elif kind == "folder":
            folder = self.work / "folder"
            for file in folder.glob("*") if folder.exists() else []:
                if file.name not in self.folder():
                    file.unlink()
            if value:
                self.put(folder / value[0], value[1], how)
            os.utime(folder, ns=(TIME_NS, TIME_NS))
        elif kind == "plugin or library":
            file = self.place.root / "lib/libfresco_sdk.so.0" if name == "sdk" else self.place.plugins / f"{name}.so"
            self.put(file, variant(self.libraries[name], value), how)
        elif kind == "library beside a plugin":
            file = self.place.root / name / "libside.so"
            if value is None:
                file.unlink(missing_ok=True)
            else:
                self.put(file, side_library(self.side, value), how)

    def write_pipeline(self):
        o = self.now["option"]
        beside = self.place.root / "built/room.yaml"
        beside.write_text(f"""version: 1
stages:
  base:  {{type: test.source, value: {o['base']}, file: size.bin, wait_ms: {o['wait']}}}
  pile:  {{type: test.source, value: {o['pile']}, folder: folder}}
  near:  {{type: test.source, file: {o['near']}/list, beside: near}}
  read:  {{type: test.add, input: {{left: {{file: num.number}}}}, plus: {o['read']}}}
  side:  {{type: test.sided}}
  cmd:
    type: command
    run: [sh, add.sh, "{{table}}", data.txt, "{{result}}"]
    files: [add.sh, data.txt]
    version: "{o['version']}"
    input: {{table: read}}
    inputs: {{table: table}}
    outputs: {{result: table}}
  {o['name']}:   {{type: test.add, input: {{left: {o['left']}, right: cmd}}, plus: {o['sum']}}}
  scale: {{type: test.scale, input: {o['name']}, first: {{type: test.factor, factor: {o['factor']}}}}}
  total: {{type: test.add, input: {{left: scale, right: side}}}}
  third: {{type: test.sink, input: near, path: near.txt}}
  one:   {{type: test.sink, input: total, path: total.txt}}
  other: {{type: test.sink, input: pile, path: pile.txt}}
""")
        os.replace(beside, self.work / "room.yaml")

    # What must come of it.

    def model(self):
        """Stage -> (all that determines its result, its number)."""
        o, c, links, sides = (self.now[kind] for kind in ("option", "bytes", "link", "library beside a plugin"))
        versions, folder = self.now["plugin or library"], self.folder()
        number = c[links["set"] + "/" + links["num.number"].split("/")[1]]
        sdk = versions["sdk"]
        side = sides["lib"] if sides["lib"] is not None else sides["plugins"]
        made = {}

        def add(stage, value, *identity, library=(versions["test_stages"], sdk)):
            made[stage] = (identity + library, value)

        add("base", o["base"] + len(c["size.bin"]), "source", o["base"], c["size.bin"])
        add("pile", o["pile"] + sum(map(len, folder.values())), "source", o["pile"], tuple(sorted(folder.items())))
        near = o["near"]
        add("near", 1 + len(c[near + "/list"]) + int(c[near + "/near"]), "source", near, c[near + "/list"], c[near + "/near"])
        add("third", made["near"][1], "sink", "near.txt", made["near"][0])
        add("read", int(number) + o["read"], "add", number, o["read"])
        add("side", side, "sided", library=(versions["sided"], side, sdk))
        add("cmd", made["read"][1] + c["add.sh"] * int(c["data.txt"]), "command", o["version"], c["add.sh"], c["data.txt"], made["read"][0],
            library=(versions["command"], sdk))
        add(o["name"], made[o["left"]][1] + made["cmd"][1] + o["sum"], "add", made[o["left"]][0], made["cmd"][0], o["sum"])
        add("scale", made[o["name"]][1] * o["factor"] * 2, "scale", made[o["name"]][0], o["factor"])
        add("total", made["scale"][1] + made["side"][1], "add", made["scale"][0], made["side"][0])
        add("one", made["total"][1], "sink", "total.txt", made["total"][0])
        add("other", made["pile"][1], "sink", "pile.txt", made["pile"][0])
        return made

    def wrong_files(self, out="out"):
        """Exports that do not hold what they should."""
        made = self.model()
        expected = {file: f"{made[stage][1]:.6f}\n" for file, stage in (("total.txt", "one"), ("pile.txt", "other"), ("near.txt", "third"))}
        return [f"{name} holds {text!r} instead of {right!r}" for name, right in expected.items()
                if (text := (self.work / out / name).read_text()) != right]

    def where(self, store=".fresco", out="out"):
        """How the program is called, by `surroundings`: words and the rest of Workplace.start."""
        s = self.now["surroundings"]
        environment = {"LC_ALL": s["language"], "TZ": s["zone"]}
        if s["search"]:
            environment["LD_LIBRARY_PATH"] = str(self.place.root / "elsewhere")
        if s["again"]:
            environment["FRESCO_PLUGIN_PATH"] = f"{self.place.root / 'again'}:{self.place.plugins}/"
        up = "../" if s["below"] else ""
        words = ["run", up + "room.yaml", "--json-log", "--no-report", *self.replace, "--store", up + store, "--out", up + out, "--cores", s["cores"]]
        return words, {"folder": self.work / "below" if s["below"] else self.work, "environment": environment}

    def edit(self, kinds=tuple(WEIGHTS)):
        """Changes one thing, and says what."""
        self.replace = []
        kind = random.choices(kinds, [WEIGHTS[kind] for kind in kinds])[0]
        how = random.choice(["in place", "beside", "copied"])
        if kind in CHOICES:
            name = random.choice(list(CHOICES[kind]))
            self.now[kind][name] = random.choice([value for value in CHOICES[kind][name] if value != self.now[kind][name]])
            self.write(kind, name, how)
        elif kind == "time only":
            name = random.choice(list(CHOICES["bytes"]))
            if random.random() < 0.5:
                self.put(self.work / name, self.bytes_of(name), "beside")
            moment = random.choice([TIME_NS, time.time_ns(), time.time_ns() + 10**14])
            os.utime(self.work / name, ns=(moment, moment))
        elif kind == "exported file" and (file := self.work / "out" / random.choice(["total.txt", "pile.txt"])).exists():
            status = file.stat()
            file.write_text("9" * (status.st_size - 1) + "\n")
            os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
            self.replace = ["--replace"]
        return f"{kind}, {how}" if kind in ("bytes", "folder", "plugin or library") else kind
