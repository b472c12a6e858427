"""Writes state dicts as torch.save does, with Python's own pickle and zipfile and stand-ins for PyTorch's classes.

usage: make_weights.py FOLDER

Each file holds the same tensors: conv1_1 of VGG-19 under torchvision's names and a piece of another storage.
"""

import collections
import io
import pickle
import struct
import sys
import types
import zipfile

# The storages' classes, with the letter of their numbers for struct. No state dict needs the last.
KINDS = {name: type(name, (), {"code": code}) for name, code in
         (("FloatStorage", "f"), ("HalfStorage", "e"), ("DoubleStorage", "d"), ("OtherStorage", "f"))}


class Parameter:
    """As PyTorch 0.1 pickled it: Parameter() and its state by BUILD."""

    def __init__(self, data):
        self.data = data

    def __getstate__(self):
        return (self.data, None, collections.OrderedDict(), True, False)


def named_function():
    return lambda *arguments: arguments


REBUILD, REBUILD_V2, REBUILD_PARAMETER = (named_function() for _ in range(3))
for module, contents in (
    ("torch", KINDS),
    ("torch._utils", {"_rebuild_tensor": REBUILD, "_rebuild_tensor_v2": REBUILD_V2, "_rebuild_parameter": REBUILD_PARAMETER}),
    ("torch.nn", {}),
    ("torch.nn.parameter", {"Parameter": Parameter}),
):
    sys.modules[module] = types.ModuleType(module)
    for name, value in contents.items():
        setattr(sys.modules[module], name, value)
        value.__module__ = module
        value.__qualname__ = value.__name__ = name


class Storage:
    def __init__(self, kind, key, values):
        self.kind, self.key, self.values = kind, key, values

    def data(self):
        return struct.pack("<%d%s" % (len(self.values), self.kind.code), *self.values)


class Reduced:
    """Pickled as this call."""

    def __init__(self, *reduced):
        self.reduced = reduced

    def __reduce_ex__(self, protocol):
        return self.reduced


def tensor(storage, offset, shape, rebuild=REBUILD_V2, strides=None):
    if strides is None:
        strides, step = [], 1
        for extent in reversed(shape):
            strides.insert(0, step)
            step *= extent
    more = () if rebuild is REBUILD else (False, collections.OrderedDict())
    return Reduced(rebuild, (storage, offset, tuple(shape), tuple(strides)) + more)


class Pickler(pickle._Pickler):
    """In pure Python, because the fast one has its own ideas of what a stand-in is."""

    def __init__(self, stream, protocol, legacy):
        super().__init__(stream, protocol)
        self.legacy, self.found = legacy, {}

    def persistent_id(self, thing):
        if not isinstance(thing, Storage):
            return None
        self.found[thing.key] = thing
        identity = ("storage", thing.kind, thing.key, "cpu", len(thing.values))
        return identity + (None,) if self.legacy else identity


def dump(value, protocol, legacy=False):
    stream = io.BytesIO()
    pickler = Pickler(stream, protocol, legacy)
    pickler.dump(value)
    return stream.getvalue(), pickler.found


def legacy_file(path, state, protocol=2):
    text, storages = dump(state, protocol, legacy=True)
    system = {"protocol_version": 1001, "little_endian": True, "type_sizes": {"short": 2, "int": 4, "long": 4}}
    keys = sorted(storages)
    with open(path, "wb") as stream:
        for value in (0x1950A86A20F9469CFC6C, 1001, system):
            stream.write(pickle.dumps(value, protocol))
        stream.write(text)
        stream.write(pickle.dumps(keys, protocol))
        for key in keys:
            stream.write(struct.pack("<q", len(storages[key].values)) + storages[key].data())


def zip_file(path, state, protocol=2, compression=zipfile.ZIP_STORED, more=()):
    text, storages = dump(state, protocol)
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("weights/data.pkl", text)
        archive.writestr("weights/byteorder", "little")
        for key in sorted(storages):
            archive.writestr("weights/data/" + key, storages[key].data())
        archive.writestr("weights/version", "3\n")
        for name, contents in more:
            archive.writestr(name, contents)


def number(i):
    return ((i * 37) % 251 - 125) / 64


def state(rebuild=REBUILD_V2, kind="FloatStorage"):
    weight = Storage(KINDS[kind], "94001", [number(i) for i in range(64 * 3 * 3 * 3)])
    bias = Storage(KINDS[kind], "94002", [number(i + 7) for i in range(100)])
    tensors = {"features.0.weight": tensor(weight, 0, (64, 3, 3, 3), rebuild), "features.0.bias": tensor(bias, 5, (64,), rebuild)}
    return collections.OrderedDict(tensors)


def main(folder):
    old = state(REBUILD)
    legacy_file(folder + "/legacy.pth", state())
    # An OrderedDict as Python 2 pickled it: a call with a list of pairs.
    legacy_file(folder + "/legacy_old.pth", Reduced(collections.OrderedDict, ([list(pair) for pair in old.items()],)))
    legacy_file(folder + "/legacy_parameters.pth", collections.OrderedDict((key, Parameter(value)) for key, value in old.items()))
    legacy_file(folder + "/legacy_protocol4.pth", state(), protocol=4)
    legacy_file(folder + "/legacy_double.pth", state(kind="DoubleStorage"))
    # With `_metadata`, as module.state_dict() returns it.
    versions = collections.OrderedDict([("", {"version": 1}), ("features", {"version": 1})])
    zip_file(folder + "/zip.pth", Reduced(collections.OrderedDict, (), {"_metadata": versions}, None, iter(state().items())))
    zip_file(folder + "/zip_half.pth", state(kind="HalfStorage"))
    zip_file(folder + "/zip_protocol4.pth", state(), protocol=4)
    wrapped = {key: Reduced(REBUILD_PARAMETER, (value, True, collections.OrderedDict())) for key, value in state().items()}
    zip_file(folder + "/zip_wrapped.pth", wrapped)

    zip_file(folder + "/bad_compressed.pth", state(), compression=zipfile.ZIP_DEFLATED)
    zip_file(folder + "/bad_script.pth", state(), more=[("weights/constants.pkl", "x")])
    zip_file(folder + "/bad_two.pth", state(), more=[("other/data.pkl", "x")])
    zip_file(folder + "/bad_evil.pth", {"features.0.weight": Reduced(eval, ("1/0",))})
    zip_file(folder + "/bad_nested.pth", {"epoch": 3, "state_dict": state()})
    zip_file(folder + "/bad_type.pth", state(kind="OtherStorage"))


main(sys.argv[1])
