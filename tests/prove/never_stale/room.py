"""The pipeline of never_stale.py: what it is made of, the files it reads, and what it must come to."""
import io
import os
import random
import shutil
import struct
import tarfile
import time


# Every file that the pipeline reads keeps this time, whatever is done to it.
TIME_NS = 1_600_000_000 * 10**9

SCRIPT = """# by hand: {}
table=$(cat "$1"); n=${{table##*\\[}}; n=${{n%%]*}}; n=${{n%%.*}}
read data <"$2"
echo "{{\\"columns\\": [\\"value\\"], \\"rows\\": [[$((n + {} * data + $(tar -xOf "$3" n)))]]}}" >"$4"
"""


def variant(library, number):
    """Other bytes of the same size, which change nothing that the library does."""
    return library + b"\0\0\0" + bytes([number])


def side_library(library, value):
    """libside.so, whose only function gives this number."""
    seven = struct.pack("<d", 7)
    assert library.count(seven) == 1, "libside.so no longer holds its number once"
    return variant(library.replace(seven, struct.pack("<d", value)), 0)


class Room:
    """What can be edited, and what comes of it."""

    def __init__(self, place, plugins):
        self.replace = []
        self.place, self.work = place, place.work
        built = place.root / "built"
        built.mkdir()
        self.libraries = {name: (place.plugins / f"{name}.so").read_bytes() for name in ("test_stages", "sided", "command")}
        self.libraries["sdk"] = (place.root / "lib/libfresco_sdk.so.0").read_bytes()
        self.side = (plugins / "sided/libside.so").read_bytes()
        self.options = {"base": 1, "pile": 1, "read": 0, "version": "", "sum": 0, "factor": 2, "left": "base", "name": "sum", "wait": 0,
                        "near": "one"}
        self.contents = {"set_1/a.number": b"1", "set_1/b.number": b"2", "set_2/a.number": b"3", "set_2/b.number": b"1",
                         "size.bin": b"aaaa", "add.sh": 1, "data.txt": b"5\n", "n.tar": b"7",
                         "one/list": b"aaaa", "one/near": b"1", "two/list": b"aaaa", "two/near": b"2"}
        self.links = {"set": "set_1", "num.number": "set/a.number"}
        self.folder = {"p": b"A", "q": b"A"}
        self.versions = {"test_stages": 0, "sided": 0, "command": 0, "sdk": 0}
        self.sides = {"plugins": 7, "lib": None, "elsewhere": 13}
        self.surroundings = {"language": "C.UTF-8", "zone": "UTC", "search": False, "below": False, "cores": 2,
                             "again": False}
        for name in self.contents:
            self.put(self.work / name, self.bytes_of(name), "in place")
        for name in self.folder:
            self.put(self.work / "folder" / name, self.folder[name], "in place")
        for name, target in self.links.items():
            (self.work / name).symlink_to(target)
        for name in self.versions:
            self.put_library(name)
        for where in self.sides:
            self.put_side(where)
        (self.work / "below").mkdir()
        (place.root / "again").mkdir()
        (place.root / "again/test_stages.so").symlink_to(place.plugins / "test_stages.so")
        self.write_pipeline()

    # What is on the disk.

    def put(self, file, data, how):
        """Other bytes under the old time; `how`: in place, beside (renamed over it), copied, or unpacked from a tar."""
        file.parent.mkdir(exist_ok=True)
        if how == "in place":
            handle = os.open(file, os.O_WRONLY | os.O_CREAT, 0o644)
            os.pwrite(handle, data, 0)
            os.ftruncate(handle, len(data))
            os.close(handle)
        elif how == "unpacked":
            packed = tarfile.TarInfo(file.name)
            packed.size, packed.mtime, packed.mode = len(data), TIME_NS // 10**9, 0o644
            archive = io.BytesIO()
            with tarfile.open(fileobj=archive, mode="w") as tar:
                tar.addfile(packed, io.BytesIO(data))
            archive.seek(0)
            with tarfile.open(fileobj=archive) as tar:
                tar.extractall(file.parent)
        else:
            beside = self.place.root / "built" / file.name
            beside.write_bytes(data)
            os.utime(beside, ns=(TIME_NS, TIME_NS))
            if how == "beside":
                os.replace(beside, file)
            else:
                shutil.copy2(beside, file)
        os.utime(file, ns=(TIME_NS, TIME_NS))

    def bytes_of(self, name):
        content = self.contents[name]
        if name == "add.sh":
            return SCRIPT.format(content, content).encode()
        if name != "n.tar":
            return content
        packed = tarfile.TarInfo("n")
        packed.size, packed.mtime = len(content), TIME_NS // 10**9
        archive = io.BytesIO()
        with tarfile.open(fileobj=archive, mode="w") as tar:
            tar.addfile(packed, io.BytesIO(content))
        return archive.getvalue()

    def put_library(self, name, how="beside"):
        file = self.place.root / "lib/libfresco_sdk.so.0" if name == "sdk" else self.place.plugins / f"{name}.so"
        self.put(file, variant(self.libraries[name], self.versions[name]), how)

    def put_side(self, where, how="beside"):
        file = self.place.root / where / "libside.so"
        if self.sides[where] is None:
            file.unlink(missing_ok=True)
        else:
            self.put(file, side_library(self.side, self.sides[where]), how)

    def write_pipeline(self):
        o = self.options
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
    run: [sh, add.sh, "{{table}}", data.txt, n.tar, "{{result}}"]
    files: [add.sh, data.txt, n.tar]
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
        o, c = self.options, self.contents
        number = c[self.links["set"] + "/" + self.links["num.number"].split("/")[1]]
        sdk = self.versions["sdk"]
        stages_library = (self.versions["test_stages"], sdk)
        side = self.sides["lib"] if self.sides["lib"] is not None else self.sides["plugins"]
        made = {}

        def add(stage, value, *identity, library=stages_library):
            made[stage] = (identity + library, value)

        add("base", o["base"] + len(c["size.bin"]), "source", o["base"], c["size.bin"])
        add("pile", o["pile"] + sum(map(len, self.folder.values())), "source", o["pile"], tuple(sorted(self.folder.items())))
        near = o["near"]
        add("near", 1 + len(c[near + "/list"]) + int(c[near + "/near"]), "source", near, c[near + "/list"], c[near + "/near"])
        add("third", made["near"][1], "sink", "near.txt", made["near"][0])
        add("read", int(number) + o["read"], "add", number, o["read"])
        add("side", side, "sided", library=(self.versions["sided"], side, sdk))
        add("cmd", made["read"][1] + c["add.sh"] * int(c["data.txt"]) + int(c["n.tar"]), "command", o["version"], c["add.sh"],
            c["data.txt"], c["n.tar"], made["read"][0], library=(self.versions["command"], sdk))
        add(o["name"], made[o["left"]][1] + made["cmd"][1] + o["sum"], "add", made[o["left"]][0], made["cmd"][0], o["sum"])
        add("scale", made[o["name"]][1] * o["factor"] * 2, "scale", made[o["name"]][0], o["factor"])
        add("total", made["scale"][1] + made["side"][1], "add", made["scale"][0], made["side"][0])
        add("one", made["total"][1], "sink", "total.txt", made["total"][0])
        add("other", made["pile"][1], "sink", "pile.txt", made["pile"][0])
        return made

    def expected(self):
        made = self.model()
        return {"total.txt": f"{made['one'][1]:.6f}\n", "pile.txt": f"{made['other'][1]:.6f}\n",
                "near.txt": f"{made['third'][1]:.6f}\n"}

    def where(self, store=".fresco", out="out"):
        """How the program is called, by `surroundings`: words and the rest of Workplace.start."""
        s = self.surroundings
        environment = {"LC_ALL": s["language"], "TZ": s["zone"]}
        if s["search"]:
            environment["LD_LIBRARY_PATH"] = str(self.place.root / "elsewhere")
        if s["again"]:
            environment["FRESCO_PLUGIN_PATH"] = f"{self.place.root / 'again'}:{self.place.plugins}/"
        up = "../" if s["below"] else ""
        words = ["run", up + "room.yaml", "--json-log", "--no-report", *self.replace, "--store", up + store, "--out", up + out, "--cores", s["cores"]]
        return words, {"folder": self.work / "below" if s["below"] else self.work, "environment": environment}

    # Edits. Each changes one thing, and says what.

    def edit_option(self):
        choices = {"base": [1, 2, 3], "pile": [1, 2], "read": [0, 1, 2], "version": ["", "2"], "sum": [0, 1, 2, 3], "factor": [1, 2, 3],
                   "left": ["base", "pile"], "name": ["sum", "both"], "wait": [0, 1], "near": ["one", "two"]}
        name = random.choice(list(choices))
        self.options[name] = other(choices[name], self.options[name])
        self.write_pipeline()
        return f"option {name}"

    def edit_bytes(self):
        choices = {"size.bin": [b"aaaa", b"bbbb", b"ccccc"], "one/list": [b"aaaa", b"bbbb"], "two/list": [b"aaaa", b"bbbb"], "add.sh": [1, 2], "data.txt": [b"5\n", b"6\n"], "n.tar": [b"7", b"8"]}
        name = random.choice(list(self.contents))
        self.contents[name] = other(choices.get(name, [b"1", b"2", b"3"]), self.contents[name])
        how = random.choice(["in place", "beside", "copied", "unpacked"])
        self.put(self.work / name, self.bytes_of(name), how)
        return f"bytes, {how}"

    def edit_touch(self):
        name = random.choice(list(self.contents))
        if random.random() < 0.5:
            self.put(self.work / name, self.bytes_of(name), "beside")
        now = random.choice([TIME_NS, time.time_ns(), time.time_ns() + 10**14])
        os.utime(self.work / name, ns=(now, now))
        return "time only"

    def edit_link(self):
        name = random.choice(list(self.links))
        choices = {"set": ["set_1", "set_2"], "num.number": ["set/a.number", "set/b.number"]}
        self.links[name] = other(choices[name], self.links[name])
        beside = self.work / "new link"
        beside.symlink_to(self.links[name])
        os.utime(beside, ns=(TIME_NS, TIME_NS), follow_symlinks=False)
        os.replace(beside, self.work / name)
        return "link"

    def edit_folder(self):
        first = other([None, ("p", b"A"), ("p", b"B"), ("r", b"A")], next((entry for entry in self.folder.items() if entry[0] != "q"), None))
        if random.random() < 0.3:
            self.folder["q"] = other([b"A", b"B"], self.folder["q"])
            self.put(self.work / "folder/q", self.folder["q"], random.choice(["in place", "beside"]))
            return "bytes in a folder"
        now = {"q": self.folder["q"]} | (dict([first]) if first else {})
        for name in set(self.folder) - set(now):
            (self.work / "folder" / name).unlink()
        if first:
            self.put(self.work / "folder" / first[0], first[1], "beside")
        self.folder = now
        os.utime(self.work / "folder", ns=(TIME_NS, TIME_NS))
        return "names in a folder"

    def edit_library(self):
        name = random.choice(["test_stages", "sided", "command", "sdk"])
        self.versions[name] = 1 - self.versions[name]
        how = random.choice(["in place", "beside", "copied"])
        self.put_library(name, how)
        return f"plugin or library, {how}"

    def edit_side(self):
        where = random.choice(["plugins", "lib"])
        self.sides[where] = other([7, 9] if where == "plugins" else [None, 11, 12], self.sides[where])
        self.put_side(where, random.choice(["in place", "beside"]))
        return "library beside a plugin"

    def edit_surroundings(self):
        choices = {"language": ["C.UTF-8", "C", "de_DE.UTF-8"], "zone": ["UTC", "Asia/Tokyo"],
                   "search": [False, True], "below": [False, True], "cores": [1, 2, 4], "again": [False, True]}
        name = random.choice(list(choices))
        self.surroundings[name] = other(choices[name], self.surroundings[name])
        return f"surroundings: {name}"

    def edit_export(self):
        file = self.work / "out" / random.choice(["total.txt", "pile.txt"])
        if not file.exists():
            return "nothing"
        status = file.stat()
        file.write_text("9" * (status.st_size - 1) + "\n")
        os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
        self.replace = ["--replace"]
        return "exported file"

    def edit_nothing(self):
        return "nothing"

    def edit(self):
        self.replace = []
        edits = {self.edit_option: 6, self.edit_bytes: 8, self.edit_touch: 2, self.edit_link: 3, self.edit_folder: 4, self.edit_library: 2,
                 self.edit_side: 3, self.edit_surroundings: 3, self.edit_export: 1, self.edit_nothing: 1}
        return random.choices(list(edits), list(edits.values()))[0]()


def other(choices, now):
    return random.choice([choice for choice in choices if choice != now])
