#!/usr/bin/env bash
# run.sh BUILD SOURCE: one machine has the scan and a codec, the other the dataset, NPY and no codec at all.
source "$(dirname "$0")/../program_test.sh"
build=$1 source=$2

options='epochs: 1, repeats_count: 2, max_steps: 8, depth_levels: true, theta_d_m: 0.6, protocol: released_matterport3d,
         angle_limit_deg: 60,
         losses: {style: {type: loss.gram, features: {type: features.vgg19, weights: "'$source/../vgg19_relu1_1.safetensors'"}}}'
cat >"$work/scan.yaml" <<YAML
version: 1
stages:
  scan: {type: scan.synthetic_room, frames_count: 5, color_width_px: 160, color_height_px: 120, depth_px: [80, 60], edge_m: 0.15}
  atlas: {type: atlas.project, input: scan.mesh, size_px: 128}
  uvmaps: {type: uvmaps.raster, input: {mesh: atlas, frames: scan.frames}, heights_px: [48, 96]}
  texture: {type: texture.optimize, input: {uvmaps: uvmaps, frames: scan.frames, style: {file: $source/../picture.npy}}, $options}
  bake: {type: texture.bake, input: {texture: texture, mesh: atlas}}
  room: {type: dataset.write, input: {uvmaps: uvmaps, frames: scan.frames, mesh: atlas, style: {file: $source/../picture.npy}}, path: room, pictures: true}
YAML
"$build/bin/fresco" run "$work/scan.yaml" --store "$work/store" --out "$work/out"

# The other machine: no plugin that reads pictures, casts rays or flattens meshes.
server=$work/server
mkdir -p "$server/bin" "$server/lib/fresco"
cp "$build/bin/fresco" "$server/bin/"
cp -P "$build"/lib/*.so* "$server/lib/"
for plugin in dataset_read texture_optimize texture_laplacian optimizer_adam loss_gram features_vgg19 texture_bake; do
    cp "$build/lib/fresco/$plugin".{so,json} "$server/lib/fresco/"
done
cp -r "$work/out/room" "$server/room"
cat >"$server/room.yaml" <<YAML
version: 1
components: {image_io: none}
stages:
  room: {type: dataset.read, path: room}
  texture: {type: texture.optimize, input: {uvmaps: room, frames: room, style: room}, $options}
  bake: {type: texture.bake, input: {texture: texture, mesh: room}}
YAML
rm -rf "$work/out"
"$server/bin/fresco" run "$server/room.yaml" --store "$server/store" --out "$server/out"

# The texture's layers and the baked mesh of each store, by name and contents.
sums() {
    (cd "$1/objects" && find . \( -path '*/texture/*.packed' -o -path '*/textured_mesh/*.packed' \) -type f -exec sha256sum {} +) | sed 's, .*/,  ,' | sort -k2
}
sums "$work/store" >"$work/direct"
sums "$server/store" >"$work/through"
[ "$(wc -l <"$work/direct")" -ge 5 ] || fail "found only: $(cat "$work/direct")"
diff "$work/direct" "$work/through" || fail "the results differ"
cmp "$work"/store/objects/*/atlas/mesh.ply "$server"/store/objects/*/mesh/mesh.ply

# With NumPy, as plugins/dataset/write/README.md says.
if python=$(python_with numpy); then
    "$python" "$source/read_with_numpy.py" "$server/room"
else
    skip "the dataset read with NumPy: no python3 with numpy is at hand"
fi
