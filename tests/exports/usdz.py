"""usdz.py FILE…: the packages by Python's zipfile, against the usdz specification: a layer first, then its pictures, stored, whole, at
multiples of 64 bytes, without comments or encryption."""
import re
import struct
import sys
import zipfile

for name in sys.argv[1:]:
    with zipfile.ZipFile(name) as package, open(name, "rb") as file:
        entries = package.infolist()
        assert package.testzip() is None and not package.comment
        layer, *pictures = [entry.filename for entry in entries]
        assert layer.endswith(".usda") and pictures and all(name.endswith((".png", ".jpg")) for name in pictures), (layer, pictures)
        end = 0
        for entry in entries:
            assert entry.compress_type == zipfile.ZIP_STORED and entry.flag_bits == 0 and entry.date_time[0] == 1980, entry
            assert entry.header_offset == end, f"{name}: {entry.filename} begins at {entry.header_offset}, not at {end}"
            file.seek(entry.header_offset)
            header = struct.unpack("<4s5H3I2H", file.read(30))
            assert header[0] == b"PK\3\4" and header[6:9] == (entry.CRC, entry.compress_size, entry.file_size)
            data = entry.header_offset + 30 + header[9] + header[10]
            assert data % 64 == 0, f"{name}: the data of {entry.filename} begin at byte {data}"
            end = data + entry.file_size
        text = package.read(layer).decode("ascii")
        assert re.match(r'#usda 1\.0\n\(\n    defaultPrim = "room"\n    metersPerUnit = 1\n    upAxis = "Y"\n\)', text)
        assert re.findall(r"@(.*)@", text) == pictures
        for picture in pictures:
            assert package.read(picture).startswith(b"\x89PNG" if picture.endswith(".png") else b"\xff\xd8\xff")
    print(f"{name}: {layer} of {entries[0].file_size} bytes, {len(pictures)} pictures of {sum(entry.file_size for entry in entries[1:])} bytes")
