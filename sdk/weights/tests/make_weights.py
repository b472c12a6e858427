"""Writes state dicts as torch.save does, with Python's own pickle and zipfile and stand-ins for PyTorch's classes.

usage: make_weights.py FOLDER

Each file holds the same tensors (see VALUES): conv1_1 of VGG-19 under torchvision's names and a piece of another storage.
"""

import collections
import io
import pickle
import struct
import sys
import types
import zipfile


def module(name, **contents):
    made = types.ModuleType(name)
    for key, value in contents.items():
        setattr(made, key, value)
        value.__module__ = name
        value.__qualname__ = value.__name__ = key
    sys.modules[name] = made


class FloatStorage:
    code, size = "f", 4


class HalfStorage:
    code, size = "e", 2


class DoubleStorage:
    code, size = "d", 8


class OtherStorage:
    """Of a type that no state dict needs."""

    code, size = "f", 4


class Parameter:
    """As PyTorch 0.1 pickled it: Parameter() and its state by BUILD."""

    def __init__(self, data=None):
        self.data = data

    def __setstate__(self, state):
        self.data = state[0]

    def __getstate__(self):
        return (self.data, None, collections.OrderedDict(), True, False)


def _rebuild_tensor(*arguments):
    return arguments


def _rebuild_tensor_v2(*arguments):
    return arguments


def _rebuild_parameter(*arguments):
    return arguments


module("torch", FloatStorage=FloatStorage, HalfStorage=HalfStorage, DoubleStorage=DoubleStorage, OtherStorage=OtherStorage)
module("torch._utils", _rebuild_tensor=_rebuild_tensor, _rebuild_tensor_v2=_rebuild_tensor_v2, _rebuild_parameter=_rebuild_parameter)
module("torch.nn", )
module("torch.nn.parameter", Parameter=Parameter)


class Storage:
    def __init__(self, kind, key, values):
        self.kind, self.key, self.values = kind, key, values

    def data(self):
        return struct.pack("<%d%s" % (len(self.values), self.kind.code), *self.values)


class Tensor:
    """Pickled as a call of `rebuild`."""

    def __init__(self, storage, offset, shape, rebuild=_rebuild_tensor_v2, strides=None):
        if strides is None:
            strides, step = [], 1
            for extent in reversed(shape):
                strides.insert(0, step)
                step *= extent
        more = () if rebuild is _rebuild_tensor else (False, collections.OrderedDict())
        self.reduced = (rebuild, (storage, offset, tuple(shape), tuple(strides)) + more)

    def __reduce_ex__(self, protocol):
        return self.reduced


class Wrapped:
    """torch._utils._rebuild_parameter(tensor, True, OrderedDict())."""

    def __init__(self, tensor):
        self.tensor = tensor

    def __reduce_ex__(self, protocol):
        return (_rebuild_parameter, (self.tensor, True, collections.OrderedDict()))


class Python2Dict:
    """An OrderedDict as Python 2 pickled it: a call with a list of pairs."""

    def __init__(self, entries):
        self.entries = entries

    def __reduce_ex__(self, protocol):
        return (collections.OrderedDict, ([[key, value] for key, value in self.entries.items()],))


class Attributed(collections.OrderedDict):
    """An OrderedDict with `_metadata`, as module.state_dict() returns."""

    def __reduce_ex__(self, protocol):
        versions = collections.OrderedDict([("", {"version": 1}), ("features", {"version": 1})])
        return (collections.OrderedDict, (), {"_metadata": versions}, None, iter(self.items()))


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


def tensors(rebuild=_rebuild_tensor_v2, kind=FloatStorage):
    weight = Storage(kind, "94001", [number(i) for i in range(64 * 3 * 3 * 3)])
    bias = Storage(kind, "94002", [number(i + 7) for i in range(100)])
    return {
        "features.0.weight": Tensor(weight, 0, (64, 3, 3, 3), rebuild),
        "features.0.bias": Tensor(bias, 5, (64,), rebuild),
    }


def state(**options):
    return collections.OrderedDict(tensors(**options))


def parameters():
    made = collections.OrderedDict()
    for key, tensor in tensors(_rebuild_tensor).items():
        made[key] = Parameter(tensor)
    return made


class Evil:
    def __reduce_ex__(self, protocol):
        return (eval, ("1/0",))


def main(folder):
    legacy_file(folder + "/legacy.pth", state())
    legacy_file(folder + "/legacy_old.pth", Python2Dict(tensors(_rebuild_tensor)))
    legacy_file(folder + "/legacy_parameters.pth", parameters())
    legacy_file(folder + "/legacy_protocol4.pth", state(), protocol=4)
    legacy_file(folder + "/legacy_double.pth", state(kind=DoubleStorage))
    zip_file(folder + "/zip.pth", Attributed(tensors()))
    zip_file(folder + "/zip_half.pth", state(kind=HalfStorage))
    zip_file(folder + "/zip_protocol4.pth", state(), protocol=4)
    zip_file(folder + "/zip_wrapped.pth", {key: Wrapped(value) for key, value in tensors().items()})

    zip_file(folder + "/bad_compressed.pth", state(), compression=zipfile.ZIP_DEFLATED)
    zip_file(folder + "/bad_script.pth", state(), more=[("weights/constants.pkl", "x")])
    zip_file(folder + "/bad_two.pth", state(), more=[("other/data.pkl", "x")])
    zip_file(folder + "/bad_evil.pth", {"features.0.weight": Evil()})
    legacy_file(folder + "/bad_evil_legacy.pth", {"features.0.weight": Evil()})
    zip_file(folder + "/bad_nested.pth", {"epoch": 3, "state_dict": state()})
    zip_file(folder + "/bad_type.pth", state(kind=OtherStorage))
    strided = Storage(FloatStorage, "0", [number(i) for i in range(12)])
    zip_file(folder + "/bad_strides.pth", {"a": Tensor(strided, 0, (3, 4), strides=(1, 3))})
    zip_file(folder + "/bad_offset.pth", {"a": Tensor(strided, 1, (3, 4))})
    zip_file(folder + "/bad_shape.pth", {"a": Tensor(strided, 0, (1 << 40, 1 << 40))})


main(sys.argv[1])
