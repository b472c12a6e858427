#!/usr/bin/env bash
# run.sh FRESCO SOURCE
source "$(dirname "$0")/../program_test.sh"
fresco=$1 source=$2

cat >"$work/room.yaml" <<YAML
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 6, color_width_px: 160, color_height_px: 120, depth_px: [80, 60], edge_m: 0.08}
  atlas: {type: atlas.project, input: scan.mesh, size_px: 512}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [120]}
  texture: {type: texture.from_frames, input: {uvmaps: uvmaps, frames: scan.frames}}
  bake: {type: texture.bake, input: {texture: texture, mesh: atlas}}
  plain: {type: export.gltf, input: bake, path: plain.glb, up: keep}
  lit: {type: export.gltf, input: bake, path: lit.glb, material: pbr, image_format: jpeg, up: z}
  small: {type: export.gltf, input: bake, path: small.glb, up: keep, max_texture_px: 128, image_format: jpeg}
  bare: {type: export.gltf, input: atlas, path: bare.glb}
  obj: {type: export.mesh, input: bake, path: obj/room.obj, up: z}
  ply: {type: export.mesh, input: bake, path: vertex.ply, image_format: jpeg, up: z}
  colors_ply: {type: export.mesh, input: bake, path: colors.ply, colors: true, up: z}
  standing: {type: export.gltf, input: {textured_mesh: bake, frames: scan}, path: standing.glb}
  standing_obj: {type: export.mesh, input: {textured_mesh: bake, frames: scan}, path: obj/standing.obj}
  standing_ply: {type: export.mesh, input: {textured_mesh: bake, frames: scan}, path: standing.ply}
  picture: {type: export.mesh, input: bake, path: picture.npy}
  usdz: {type: export.usdz, input: bake, path: unlit.usdz, up: z}
  usdz_lit: {type: export.usdz, input: bake, path: lit.usdz, material: pbr, image_format: jpeg, up: z}
  page: {type: export.page, input: {textured_mesh: bake, frames: scan}, path: room.html}
  relief: {type: texture.relief, input: bake}
  relief_glb: {type: export.gltf, input: {textured_mesh: bake, relief: relief}, path: relief.glb, up: z}
  relief_usdz: {type: export.usdz, input: {textured_mesh: bake, relief: relief}, path: relief.usdz, up: z}
  relief_page: {type: export.page, input: {textured_mesh: bake, frames: scan, relief: relief}, path: relief.html}
  page_bare: {type: export.page, input: bake, path: bare.html, up: z}
YAML
"$fresco" run "$work/room.yaml" --store "$work/store" --out "$work/out"

# The same room as a model of its own, its colors put back by its own texture coordinates and by a second set; with two materials, too.
cat >"$work/split.py" <<'PYTHON'
import json
import struct
import sys

data = open(sys.argv[1], "rb").read()
(size,) = struct.unpack_from("<I", data, 12)
document, binary = json.loads(data[20:20 + size]), data[20 + size:]
(primitive,) = document["meshes"][0]["primitives"]
indices = document["accessors"][primitive["indices"]]
half = indices["count"] // 6 * 3
offset = indices.get("byteOffset", 0) + half * {5123: 2, 5125: 4}[indices["componentType"]]
document["accessors"].append({**indices, "count": indices["count"] - half, "byteOffset": offset})
indices["count"] = half
document["materials"].append({**document["materials"][0], "name": "other"})
document["meshes"][0]["primitives"].append({**primitive, "indices": len(document["accessors"]) - 1, "material": 1})
text = json.dumps(document).encode()
text += b" " * (-len(text) % 4)
with open(sys.argv[2], "wb") as file:
    file.write(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(binary), len(text), b"JSON") + text + binary)
PYTHON
python3 "$work/split.py" "$work/out/plain.glb" "$work/out/two_materials.glb"
for name in keep second several; do
    model=plain uvs=$name
    [ $name != several ] || model=two_materials uvs=second
    cat >"$work/$name.yaml" <<YAML
version: 1
stages:
  scan: {type: scan.mesh, path: out/$model.glb}
  atlas: {type: atlas.model, input: {mesh: scan}, uvs: $uvs, size_px: 1024}
  photo: {type: texture.from_model, input: {model: scan, mesh: atlas}}
  bake: {type: texture.bake, input: {texture: photo, mesh: atlas}}
  glb: {type: export.model, input: {textured_mesh: bake, model: scan}, file: out/$model.glb, path: $name, uvs: $uvs}
YAML
    "$fresco" run "$work/$name.yaml" --store "$work/store" --out "$work/out"
done

cp "$source"/tests/gltf_validator/* "$work/"
(cd "$work" && npm install --no-audit --no-fund --loglevel=error && node validate.mjs out/*.glb)

(cd "$work/out" && "$fresco" describe lit.glb) >"$work/origin"
for line in 'export.gltf' '  input  *textured_mesh  *texture.bake' '  option  *material  *pbr' '  option  *edge_m  *0.08'; do
    grep -q "^$line" "$work/origin" || { cat "$work/origin"; fail "the GLB does not tell: $line"; }
done
! grep -q "$work" "$work/origin" || fail "the GLB tells where it was made"

for package in "$work"/out/*.usdz; do
    ! python3 -m zipfile -t "$package" | grep corrupted || fail "Python's zipfile finds damage in $package"
done
(cd "$work" && npm pack --loglevel=error tinyusdz@0.9.0-rc10 >/dev/null && tar -xzf tinyusdz-*.tgz)
node "$source/tests/exports/usdz.mjs" "$work/package" "$work/out/obj/room.obj" "$work/out/unlit.usdz" "$work/out/lit.usdz"

chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -n "$chromium" ]; then
    timeout 600 node "$source/tests/exports/page.mjs" "$chromium" "$work/out/room.html" "$work/out/bare.html" "$work/out/relief.html"
    (cd "$work" && npm pack --loglevel=error iwer@2.5.0 >/dev/null && mkdir headset && tar -xzf iwer-*.tgz -C headset)
    timeout 600 node "$source/tests/exports/vr.mjs" "$chromium" "$work/out/room.html" "$work/headset/package/build/iwer.min.js"
    (cd "$work" && npm pack --loglevel=error three@0.170.0 >/dev/null && mkdir three && tar -xzf three-*.tgz -C three)
    timeout 600 node "$source/tests/exports/three.mjs" "$chromium" "$work/three" "$work"/out/{plain,keep,second,several}.glb
else
    skip "the pages of the room in a browser: there is no chromium"
fi

if command -v blender >/dev/null; then
    blender --background --factory-startup --python-exit-code 9 --python "$source/tests/exports/import.py" -- "$work/out" >"$work/blender.log" 2>&1 ||
        { cat "$work/blender.log"; fail "Blender does not read what was written"; }
    grep '^read ' "$work/blender.log"
else
    skip "the exports read by Blender: there is no blender"
fi
