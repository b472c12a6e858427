#!/usr/bin/env python3
"""make_seeds.py: writes the binary files of corpus/ that are not what a fuzzer found: one or two good ones per format."""
import base64
import collections
import io
import json
import pathlib
import pickle
import struct
import zipfile
import zlib

corpus = pathlib.Path(__file__).resolve().parent / "corpus"
identity = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)


def write(parser, name, contents):
    (corpus / parser).mkdir(exist_ok=True)
    (corpus / parser / name).write_bytes(contents)


def floats(*numbers):
    return struct.pack(f"<{len(numbers)}f", *numbers)


def ply(order, mark):
    header = f"""ply
format binary_{order}_endian 1.0
comment TextureFile room.png
comment texture_px 64
element vertex 4
property float x
property double y
property float z
property uchar red
property uchar green
property uchar blue
property short label
element face 2
property list uchar int vertex_indices
property list uchar float texcoord
property int chart
property uchar texnumber
element strip 1
property list int uchar ids
element other 2
property ushort a
property char b
end_header
"""
    body = b""
    for x, y, z in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0.5)):
        body += struct.pack(mark + "fdfBBBh", x, y, z, 12, 34, 56, -3)
    body += struct.pack(mark + "B3iB6fiB", 3, 0, 1, 2, 6, 0, 0, 1, 0, 1, 1, 7, 0)
    body += struct.pack(mark + "B4iB8fiB", 4, 0, 2, 3, 1, 8, 0, 0, 1, 1, 0, 1, 0.5, 0.5, 8, 0)
    body += struct.pack(mark + "i4B", 4, 1, 2, 3, 44) + struct.pack(mark + "HbHb", 1, -1, 2, -2)
    return header.encode() + body


def npy(descr, shape, data, version=1):
    header = repr({"descr": descr, "fortran_order": False, "shape": shape}).encode()
    header += b" " * (63 - (len(header) + 10) % 64) + b"\n"
    length = struct.pack("<H" if version == 1 else "<I", len(header))
    return b"\x93NUMPY" + bytes((version, 0)) + length + header + data


def glb():
    positions = floats(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
    colors = bytes((255, 0, 0, 255) * 4)
    texcoords = struct.pack("<8H", 0, 0, 65535, 0, 65535, 65535, 0, 65535)
    indices = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    picture = bytes.fromhex("89504e470d0a1a0a") + b"not looked at"
    parts, views, binary = (positions, colors, texcoords, indices, picture), [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + bytes(-len(part) % 4)

    def accessor(view, component, count, form, **more):
        return {"bufferView": view, "componentType": component, "count": count, "type": form, **more}

    use = {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2], "rotation": 0.5, "texCoord": 0}}}
    document = {
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_texture_transform"], "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"mesh": 0, "children": [1], "translation": [0, 0, 1], "rotation": [0, 0, 0, 1], "scale": [1, -1, 1]},
                  {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}, {"mesh": 1}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1, "TEXCOORD_0": 2}, "indices": 3, "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "material": 1},
                                   {"attributes": {"POSITION": 0}, "mode": 6}, {"attributes": {"POSITION": 0}, "mode": 0}]}],
        "materials": [{"name": "wall", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "baseColorTexture": use}},
                      {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 1], "diffuseTexture": use}}}],
        "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [accessor(0, 5126, 4, "VEC3", min=[0, 0, 0], max=[1, 1, 0]), accessor(1, 5121, 4, "VEC4", normalized=True),
                      accessor(2, 5123, 4, "VEC2", normalized=True), accessor(3, 5123, 6, "SCALAR")],
        "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
    return glb_of(json.dumps(document, separators=(",", ":")).encode(), b" ", struct.pack("<II", len(binary), 0x004E4942) + binary)


def glb_of(text, padding, more=b""):
    text += padding * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + more
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def gltf(binary=b"", **changes):
    """A triangle; `binary` follows its positions in the buffer."""
    data = floats(0, 0, 0, 1, 0, 0, 0, 1, 0) + binary
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    document = {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
                "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": kind} for kind in ("VEC3", "VEC2")],
                "bufferViews": [{"buffer": 0, "byteLength": len(data)}], "buffers": [{"byteLength": len(data), "uri": uri}],
                "images": [{"uri": "data:image/png;base64,iVBORw0KGgo="}]}
    return json.dumps({**document, **changes}, separators=(",", ":")).encode()


def gltf_of_integers():
    """Attributes and indices of each integer type; a triangle that is a line; a skin and a morph target."""
    def accessor(offset, component, count, form):
        return {"bufferView": 0, "byteOffset": offset, "componentType": component, "count": count, "type": form, "normalized": count == 3}

    attributes = {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}
    primitive = {"attributes": attributes, "indices": 3, "targets": [{"POSITION": 0}]}
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}, accessor(36, 5122, 3, "VEC2"),
                 accessor(48, 5120, 3, "VEC4"), accessor(60, 5125, 6, "SCALAR")]
    binary = struct.pack("<6h12b6I", *range(18), 0, 1, 2, 0, 1, 1)
    return gltf(binary, nodes=[{"mesh": 0, "skin": 0}], meshes=[{"primitives": [primitive]}], accessors=accessors)


def gltf_of_files():
    """A buffer and two pictures in one file beside it, whose name is escaped; a repeated picture."""
    materials = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": i}}} for i in range(3)]
    primitives = [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": i} for i in range(3)]
    return gltf(buffers=[{"byteLength": 24, "uri": "beside.bin"}], bufferViews=[{"buffer": 0, "byteLength": 24}],
                accessors=[{"bufferView": 0, "componentType": 5121, "count": 3, "type": kind} for kind in ("VEC3", "VEC2")],
                images=[{"uri": "beside.bin"}, {"uri": "beside%2Ebin"}], samplers=[{"wrapS": 10497}], materials=materials,
                textures=[{"source": 0, "sampler": 0}, {"source": 1}, {"source": 0}], meshes=[{"primitives": primitives}])


def safetensors():
    header = {"__metadata__": {"input": "RGB in [0,1], ImageNet mean and deviation", "padding": "reflect"}}
    data = b""
    for name, kind, size, shape in (("a", "F32", 4, [2, 3]), ("b", "F16", 2, [2]), ("c", "BF16", 2, [1]), ("d", "F64", 8, []),
                                    ("e", "BOOL", 1, [2]), ("f", "I64", 8, [0, 5])):
        count = size
        for extent in shape:
            count *= extent
        header[name] = {"dtype": kind, "shape": shape, "data_offsets": [len(data), len(data) + count]}
        data += b"\1" * count
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


def safetensors_of_vgg19():
    """conv1_1, whose weights are 7 KB: the smallest that is recognized, and too much for more than one file."""
    header = {"features.0.weight": {"dtype": "F16", "shape": [64, 3, 3, 3], "data_offsets": [0, 3456]},
              "features.0.bias": {"dtype": "F16", "shape": [64], "data_offsets": [3456, 3584]},
              "classifier.0.bias": {"dtype": "I8", "shape": [0], "data_offsets": [3584, 3584]}}
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + b"\0\x3c" * 1792


def vgg19(prefix, metadata, more=None, shape=(64, 3, 3, 3)):
    header = {"__metadata__": metadata, prefix + ".weight": {"dtype": "F16", "shape": shape, "data_offsets": [0, 3456]},
              prefix + ".bias": {"dtype": "F16", "shape": [64], "data_offsets": [3456, 3584]}, **(more or {})}
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + b"\0\x3c" * 1792


class Storage:
    """'FloatStorage' in torch, by its name."""


class Pickler(pickle._Pickler):
    dispatch = dict(pickle._Pickler.dispatch)

    def __init__(self, stream, legacy):
        super().__init__(stream, 2)
        self.legacy = legacy

    def persistent_id(self, thing):
        if not isinstance(thing, Storage):
            return None
        identity = ("storage", Global("torch", "FloatStorage"), "0", "cpu", 6)
        return identity + (None,) if self.legacy else identity


class Global:
    def __init__(self, module, name):
        self.module, self.name = module, name


def save_global(pickler, thing):
    pickler.write(f"c{thing.module}\n{thing.name}\n".encode())


Pickler.dispatch[Global] = save_global


class Call:
    def __init__(self, function, *arguments):
        self.function, self.arguments = function, arguments


def save_call(pickler, thing):
    pickler.save(thing.function)
    pickler.save(thing.arguments)
    pickler.write(b"R")


Pickler.dispatch[Call] = save_call


def state(legacy):
    rebuild = Global("torch._utils", "_rebuild_tensor_v2")
    ordered = Call(Global("collections", "OrderedDict"))
    storage = Storage()
    tensor = Call(rebuild, storage, 0, (2, 3), (3, 1), False, ordered)
    entries = {"weight": tensor, "bias": Call(rebuild, storage, 4, (2,), (1,), False, ordered)}
    if not legacy:
        entries["wrapped"] = Call(Global("torch._utils", "_rebuild_parameter"), tensor, True, ordered)
    stream = io.BytesIO()
    Pickler(stream, legacy).dump(entries)
    return stream.getvalue()


def legacy_pickle(root, keys=("0",), data=struct.pack("<q", 6) + floats(1, 2, 3, 4, 5, 6), **system):
    system = {"protocol_version": 1001, "little_endian": True, **system}
    parts = [pickle.dumps(part, 2) for part in (0x1950A86A20F9469CFC6C, 1001, system)]
    return b"".join(parts) + root + pickle.dumps(list(keys), 2) + data


def text(word):
    return b"X" + struct.pack("<I", len(word)) + word


def storage(kind=b"ctorch\nFloatStorage\n", count=6, view=b"N"):
    return b"(" + text(b"storage") + kind + text(b"0") + text(b"cpu") + bytes((75, count)) + view + b"tQ"


def tensor(block=storage(), offset=0, shape=b"K\2K\3\x86", strides=b"K\3K\1\x86"):
    return b"ctorch._utils\n_rebuild_tensor\n(" + block + bytes((75, offset)) + shape + strides + b"tR"


def entries(value, name=text(b"a")):
    return b"\x80\2}" + name + value + b"s."


ordered, parameter = b"ccollections\nOrderedDict\n", b"ctorch.nn.parameter\nParameter\n"


def pickle_of_python_2():
    """An OrderedDict of pairs; parameters that are given their tensor, by calls and by their state."""
    called = b"ctorch._utils\n_rebuild_parameter\n" + tensor() + b"\x85R"
    given = parameter + tensor() + b"\x85\x81"
    built = parameter + b")\x81" + tensor() + b"\x88\x86b"
    pairs = b"".join(b"]U\1" + name + b"a" + value + b"a" for name, value in ((b"a", called), (b"b", given), (b"c", built)))
    return b"\x80\2" + ordered + b"](" + pairs + b"e\x85R."


def pickle_of_protocol_4():
    """Names on the stack; numbers with a fraction, in the attributes of an OrderedDict."""
    names = b"\x8c\x0bcollections\x8c\x0bOrderedDict\x93"
    contents = names + b")R\x94" + text(b"a") + tensor() + b"s}" + text(b"version") + b"G" + struct.pack(">d", 0.5) + b"sb."
    return b"\x80\4\x95" + struct.pack("<Q", len(contents)) + contents


def bad_pickles():
    call = b"ctorch._utils\n_rebuild_parameter\n"
    values = (storage(ordered), storage(view=b"K\1"), tensor(ordered + b")R"), storage() + storage(count=5), call + b"N\x85R",
              b"ctorch\nFloatStorage\n)R", ordered + b"N\x85R", ordered + b"]Na\x85R", tensor(shape=b"N"), tensor(shape=b"N\x85"),
              tensor(strides=b"K\1\x85"), tensor(shape=b"K\7K\3\x86"), tensor(offset=1), tensor(strides=b"K\1K\2\x86"),
              ordered + b")\x81", parameter + b"N\x85\x81", b"NNb", b"N" + 65 * b"\x85", 65 * b"(")
    good = entries(tensor())
    return [legacy_pickle(entries(value)) for value in values] + [
        legacy_pickle(b"\x80\2N.", (), b""), legacy_pickle(entries(b"N"), (), b""), legacy_pickle(entries(tensor(), text(b"\n"))),
        legacy_pickle(good, little_endian=False), legacy_pickle(good, keys=("1",)), legacy_pickle(good, data=b""),
        legacy_pickle(good, data=struct.pack("<q", 5)), legacy_pickle(good, (), b""), legacy_pickle(good, (), b"0")]


def torch_zip():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, contents in (("data.pkl", state(False)), ("byteorder", b"little"), ("data/0", floats(1, 2, 3, 4, 5, 6))):
            archive.writestr(zipfile.ZipInfo("weights/" + name), contents)
    return stream.getvalue()


def sens(zlib_depth):
    width, height = 4, 3
    matrix = floats(*identity)
    depth = struct.pack(f"<{width * height}H", *range(width * height))
    data = struct.pack("<IQ", 4, 6) + b"sensor" + 4 * matrix + struct.pack("<ii", 2, int(zlib_depth))
    data += struct.pack("<4IfQ", width, height, width, height, 1000, 2)
    for _ in range(2):
        packed = zlib.compress(depth) if zlib_depth else depth
        data += matrix + struct.pack("<4Q", 1, 2, 3, len(packed)) + b"jpg" + packed
    return data + struct.pack("<Q", 0)


def colmap_cameras():
    data = struct.pack("<Q", 4)
    for number, (model, parameters) in enumerate(((0, (500, 320, 240)), (1, (500, 510, 320, 240)), (2, (500, 320, 240, 0.01)),
                                                  (4, (500, 510, 320, 240, 0.01, -0.02, 0.001, 0.001)))):
        data += struct.pack("<IiQQ", number + 1, model, 640, 480) + struct.pack(f"<{len(parameters)}d", *parameters)
    return data


def colmap_images():
    data = struct.pack("<Q", 2)
    for number in range(2):
        data += struct.pack("<I7dI", number + 1, 1, 0, 0, 0, 0.5, number, 0, 1) + b"left/%06d.jpg\0" % number
        data += struct.pack("<Q", number) + struct.pack("<ddq", 1, 2, -1) * number
    return data


def png(width, height, bits, kind, *chunks):
    data = bytes.fromhex("89504e470d0a1a0a")
    for name, contents in ((b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)), *chunks, (b"IEND", b"")):
        data += struct.pack(">I", len(contents)) + name + contents + struct.pack(">I", zlib.crc32(name + contents))
    return data


def exif(order):
    mark = "<" if order == b"II" else ">"
    return order + struct.pack(mark + "HIHHHIHHI", 42, 8, 2, 0x0100, 3, 1, 4, 0, 0)[:-4] + struct.pack(mark + "HHIHH", 0x0112, 3, 1, 6, 0)


def jpeg(components):
    def segment(code, contents):
        return bytes((0xFF, code)) + struct.pack(">H", len(contents) + 2) + contents

    frame = struct.pack(">BHHB", 8, 3, 4, components) + b"".join(bytes((i + 1, 0x11, 0)) for i in range(components))
    adobe = segment(0xEE, b"Adobe\0\x64\0\0\0\0\2") if components == 4 else b""
    return (b"\xFF\xD8" + segment(0xE1, b"Exif\0\0" + exif(b"II")) + adobe + segment(0xC0, frame) + segment(0xC4, b"\0" * 17) +
            segment(0xDA, bytes((1, 1, 0, 0, 63, 0))) + b"\x12\xFF\x00\x34\xFF\xD0\x56\xFF\xFF\xD9")


def jpeg_with_profile():
    """An ICC profile in two pieces, the second first."""
    pieces = b"".join(b"\xFF\xE2\0\x14ICC_PROFILE\0" + bytes((number, 2)) + b"icc " for number in (2, 1))
    return b"\xFF\xD8" + pieces + jpeg(3)[2:]


def riff(*chunks):
    data = b"WEBP" + b"".join(name + struct.pack("<I", len(contents)) + contents + b"\0" * (len(contents) % 2) for name, contents in chunks)
    return b"RIFF" + struct.pack("<I", len(data)) + data


def webp(*before):
    extended = (b"VP8X", bytes((0x28, 0, 0, 0, 3, 0, 0, 2, 0, 0)))
    return riff(extended, *before, (b"VP8L", b"\x2F" + struct.pack("<I", 3 | 2 << 14)), (b"EXIF", b"Exif\0\0" + exif(b"II")))


def zstd_frame(contents):
    """A frame of one raw block, with the size of its contents: single segment, two bytes of size."""
    flags, block = 0x60, struct.pack("<I", (len(contents) << 3) | 1)[:3]
    return struct.pack("<IBH", 0xFD2FB528, flags, len(contents) - 256) + block + contents


def uv_map():
    width, height = 32, 24
    pixels = width * height
    content = b"\xFF" * (pixels // 8) + bytes(i % 3 for i in range(7 * pixels))
    header = b"FRESCOUV" + struct.pack("<5If", 3, width, height, 16, 16, 1000)
    return header + struct.pack("<I", zlib.crc32(header)) + zstd_frame(content)


def checkpoint():
    return struct.pack("<qqQQQ", 2, 3, 2, 1, 2) + floats(1, 2, 3, 4, 5, 6) + bytes(20) + floats(0.5, 0.25)


write("ply", "good_little.ply", ply("little", "<"))
write("ply", "good_big.ply", ply("big", ">"))
write("npy", "good_picture.npy", npy("|u1", (2, 3, 3), bytes(range(18))))
write("npy", "good_floats.npy", npy("<f4", (2, 2), floats(1, 2, 3, 4), version=2))
for kind in ("<u2", "<u4", "<i4", "<i8"):
    write("npy", f"good_{kind[1:]}.npy", npy(kind, (1,), b"\1" * int(kind[2])))
write("npy", "good_number.npy", npy("<f8", (), struct.pack("<d", 1)))
write("npy", "bad_extents.npy", npy("<f8", (1 << 62, 1 << 62), b""))
write("gltf", "good_room.glb", glb())
write("gltf", "good_integers.gltf", gltf_of_integers())
write("gltf", "good_files.gltf", gltf_of_files())
write("gltf", "good_picture.gltf", gltf())
write("gltf", "good_padded.glb", glb_of(gltf(), b"\0"))
# gltfpack -cc and gltf-transform (meshopt, quantize, webp, draco) made good_gltfpack, good_meshopt, good_quantized, good_webp and
# gltf_draco/good_draco of the bumpy surface that scan.mesh is tested with.
transform = {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [1]}}}
for name, changes in (
        ("compressed", {"extensionsRequired": ["KHR_meshopt_compression"]}),
        ("picture_form", {"extensionsRequired": ["KHR_texture_basisu"]}),
        ("quaternion", {"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 3]}]}), ("matrix", {"nodes": [{"mesh": 0, "matrix": 16 * [1]}]}),
        ("no_picture", {"images": [{"uri": "data:image/png;base64,AAAA"}]}), ("gone", {"images": [{"uri": "gone.png"}]}),
        ("wrap", {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 1}]}),
        ("transform", {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": transform}}]}),
        ("infinite", {"nodes": [{"mesh": 0, "scale": [1e300, 1, 1]}]}), ("views", {"bufferViews": [{"buffer": 0, "byteLength": 37}]})):
    write("gltf", f"bad_{name}.gltf", gltf(**changes))
write("safetensors", "good_types.safetensors", safetensors())
write("safetensors", "good_vgg19.safetensors", safetensors_of_vgg19())
empty = {"dtype": "F16", "shape": [0], "data_offsets": [3584, 3584]}
for number, (prefix, metadata, more) in enumerate((
        ("conv1_1", {"input": "BGR in 0..255", "padding": "zeros", "normalized": "unit mean activation"}, None),
        ("conv1_1", {"scale": "raw", "padding": "reflect"}, {"fc6.bias": empty}),
        ("features.0", {"scale": "none"}, None), ("features.0", {"padding": "none"}, None), ("features.0", {"input": "none"}, None),
        ("features.0", {"normalized": "no"}, None), ("features.0", {}, {"features.5.weight": empty}),
        ("features.0", {}, {"features.1.weight": empty}), ("features.0", {}, {"features.2.weight": empty}))):
    write("safetensors", f"good_names_{number}.safetensors", vgg19(prefix, metadata, more))
write("safetensors", "good_shape.safetensors", vgg19("features.0", {}, shape=(3, 64, 3, 3)))
write("safetensors", "bad_tar.safetensors", bytes(257) + b"ustar" + bytes(250))
for name, root in (("legacy", state(True)), ("python_2", pickle_of_python_2()), ("protocol_4", pickle_of_protocol_4())):
    write("torch_pickle", f"good_{name}.pth", legacy_pickle(root))
for number, contents in enumerate(bad_pickles()):
    write("torch_pickle", f"bad_{number:02}.pth", contents)
write("torch_zip", "good_zip.pth", torch_zip())
write("sens", "good_zlib.sens", sens(True))
write("sens", "good_raw.sens", sens(False))
write("sens_depth", "good_4x3.bin", bytes((3, 2)) + zlib.compress(struct.pack("<12H", *range(12))))
write("colmap_binary", "good_cameras.bin", colmap_cameras())
write("colmap_binary", "good_images.bin", colmap_images())
write("picture", "good_rgb.png", png(4, 3, 8, 2, (b"eXIf", exif(b"MM")), (b"IDAT", zlib.compress(bytes(39)))))
write("picture", "good_gray.png", png(4, 3, 16, 0, (b"tRNS", b"\0\1"), (b"IDAT", zlib.compress(bytes(27)))))
write("picture", "good_palette.png", png(4, 3, 4, 3, (b"PLTE", bytes(9)), (b"IDAT", zlib.compress(bytes(9)))))
write("picture", "good_ycc.jpg", jpeg(3))
write("picture", "good_cmyk.jpg", jpeg(4))
write("picture", "good_profile.png", png(4, 3, 8, 2, (b"iCCP", b"a name\0\0" + zlib.compress(bytes(300))), (b"IDAT", zlib.compress(bytes(39)))))
write("picture", "good_profile.jpg", jpeg_with_profile())
write("picture", "good_extended.webp", webp((b"ICCP", b"icc"), (b"ALPH", bytes(3))))
write("picture", "good_lossy.webp", riff((b"VP8 ", b"\x10\0\0\x9D\x01\x2A" + struct.pack("<HH", 4, 3))))
write("picture", "bad_moving.webp", riff((b"VP8X", bytes((2,)) + bytes(9))))
write("picture", "bad_profile.png", png(4, 3, 8, 2, (b"iCCP", b"a name\0\0\x78\x9C"), (b"IDAT", zlib.compress(bytes(39)))))
# heif_picture has files of heif-enc 1.15, of 4 x 4 squares of 16 x 16 pixels: --matrix_coefficients=0 -L -p chroma=444 of a PNG with the
# profile of Display P3 and of one without, and 10 bits with loss (-q 90) of a PNG of 16 bits.
write("uv_map", "good_32x24.uvmap", uv_map())
write("uv_map_planes", "good_planes.bin", bytes((15, 11, 2, 0)) + bytes(range(256)) * 3)
write("uv_map_planes", "good_large.bin", bytes((7, 7, 6, 1)) + b"\xFF" * 900)
write("checked", "good_checkpoint.bin", checkpoint())
print(sum(file.stat().st_size for file in corpus.rglob("*") if file.is_file()), "bytes in", corpus)
