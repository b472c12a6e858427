"""What calls.c recorded, and what a disk may hold after a power cut in the middle of it.

The model is weaker than any file system in use. A file's data are on the disk once the file was synced; before that any part of what
was written may be missing, or the file may have its size and zeros. A name that was given or taken in a folder, by a link, a renaming
or a removal, is there once the folder was synced; before that each such change is there or not, whatever came before or after it. A
renaming is there as a whole, in both folders.
"""
import dataclasses
import os
import pathlib
import struct

CHANGES = ["create", "unnamed", "truncate", "write", "link", "symlink", "rename", "unlink", "rmdir", "mkdir", "sync", "sync_all"]
HEADER = struct.Struct("<4I Q q")


@dataclasses.dataclass
class Event:
    change: str
    inode: int
    offset: int
    path: str
    other: str
    data: bytes


def read_events(file):
    raw, at, events = pathlib.Path(file).read_bytes(), 0, []
    while at < len(raw):
        change, path, other, data, inode, offset = HEADER.unpack_from(raw, at)
        at += HEADER.size
        parts = []
        for size in (path, other, data):
            parts.append(raw[at:at + size])
            at += size
        path, other = (os.path.normpath(part.decode()) if part else "" for part in parts[:2])
        events.append(Event(CHANGES[change], inode, offset, path, other, parts[2]))
    return events


class File:
    def __init__(self):
        self.durable, self.current, self.pending = b"", b"", []

    def change(self, offset, data):
        """Writes data; data None: sets the size."""
        self.pending.append((offset, data))
        self.current = changed(self.current, offset, data)

    def sync(self):
        self.durable, self.pending = self.current, []

    def contents(self, how):
        """After a cut: 'none' or 'all' of what was not synced, 'torn': half of it, 'zeros': the size without the bytes."""
        if not self.pending or how == "none":
            return self.durable
        if how == "all":
            return self.current
        if how == "zeros":
            return self.durable[:len(self.current)].ljust(len(self.current), b"\0")
        half, result = (len(self.pending) + 1) // 2, self.durable
        for number, (offset, data) in enumerate(self.pending[:half]):
            last = number == half - 1 and data is not None
            result = changed(result, offset, data[:len(data) // 2] if last else data)
        return result


def changed(contents, offset, data):
    if data is None:
        return contents[:offset].ljust(offset, b"\0")
    return contents[:offset].ljust(offset, b"\0") + data + contents[offset + len(data):]


class Folder:
    def __init__(self):
        self.durable, self.current = {}, {}


@dataclasses.dataclass
class Link:
    target: str


class Disk:
    """Takes events one by one."""

    def __init__(self, root, inode=None):
        self.root_path, self.root = str(root), Folder()
        self.nodes = {inode or os.stat(root).st_ino: self.root}
        self.pending = []  # Lists of changes (folder, name, node or None) that belong together.

    def find(self, path):
        node = self.root
        for name in pathlib.PurePath(path).relative_to(self.root_path).parts:
            node = node.current[name]
        return node

    def place(self, path):
        whole = pathlib.PurePath(path)
        return self.find(whole.parent), whole.name

    def name(self, *changes):
        for folder, name, node in changes:
            folder.current.pop(name, None)
            if node is not None:
                folder.current[name] = node
        self.pending.append(list(changes))

    def take(self, event):
        getattr(self, "take_" + event.change)(event)

    def take_create(self, event):
        self.nodes[event.inode] = File()
        self.name((*self.place(event.path), self.nodes[event.inode]))

    def take_unnamed(self, event):
        self.nodes[event.inode] = File()

    def take_mkdir(self, event):
        self.nodes[event.inode] = Folder()
        self.name((*self.place(event.path), self.nodes[event.inode]))

    def take_truncate(self, event):
        self.nodes[event.inode].change(event.offset, None)

    def take_write(self, event):
        self.nodes[event.inode].change(event.offset, event.data)

    def take_link(self, event):
        self.name((*self.place(event.path), self.nodes[event.inode]))

    def take_symlink(self, event):
        self.name((*self.place(event.path), Link(event.other)))

    def take_rename(self, event):
        self.name((*self.place(event.path), None), (*self.place(event.other), self.find(event.path)))

    def take_unlink(self, event):
        self.name((*self.place(event.path), None))

    take_rmdir = take_unlink

    def take_sync(self, event):
        node = self.nodes[event.inode]
        if isinstance(node, File):
            node.sync()
        else:
            self.make_durable(lambda changes: any(folder is node for folder, _, _ in changes))

    def take_sync_all(self, event):
        del event
        self.make_durable(lambda changes: True)
        for node in self.nodes.values():
            if isinstance(node, File):
                node.sync()

    def make_durable(self, which):
        left = []
        for changes in self.pending:
            if not which(changes):
                left.append(changes)
                continue
            for folder, name, node in changes:
                folder.durable.pop(name, None)
                if node is not None:
                    folder.durable[name] = node
                # What came before it under this name is over.
                left = [[each for each in earlier if each[0] is not folder or each[1] != name] for earlier in left]
        self.pending = [changes for changes in left if changes]

    def after_cut(self, kept, data):
        """{path below the root: bytes, None for a folder, Link}. `kept`: those of the pending changes that are there; `data`: of a file,
        how much of it is."""
        entries = {}
        for changes in kept:
            for folder, name, node in changes:
                names = entries.setdefault(id(folder), dict(folder.durable))
                names.pop(name, None)
                if node is not None:
                    names[name] = node
        tree = {}

        def walk(folder, path):
            for name, node in entries.get(id(folder), folder.durable).items():
                below = f"{path}{name}"
                if isinstance(node, Folder):
                    tree[below] = None
                    walk(node, below + "/")
                else:
                    tree[below] = node.contents(data(node)) if isinstance(node, File) else node

        walk(self.root, "")
        return tree

    def everything(self):
        return self.after_cut(self.pending, lambda file: "all")


def read_tree(root):
    """A folder in the form of Disk.after_cut."""
    tree = {}
    for path in sorted(pathlib.Path(root).rglob("*")):
        name = str(path.relative_to(root))
        tree[name] = Link(os.readlink(path)) if path.is_symlink() else None if path.is_dir() else path.read_bytes()
    return tree


def write_tree(tree, root):
    for name, node in tree.items():
        path = f"{root}/{name}"
        if node is None:
            os.mkdir(path)
        elif isinstance(node, Link):
            os.symlink(node.target, path)
        else:
            with open(path, "wb") as file:
                file.write(node)
