#!/usr/bin/env bash
# run.sh CMAKE BUILD torch|plain: install to a fresh prefix, whose pages must have no dead links; then begin a plugin of each kind, build, test, describe and run it.
source "$(dirname "$0")/../program_test.sh"
cmake=$1 build=$2 torch=$3

"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
fresco=$work/prefix/bin/fresco
cd "$work"
python3 "$(dirname "$0")/links.py" "$work/prefix/share/fresco"
kinds=(stage layout)
fast=(-DCMAKE_CXX_FLAGS_RELEASE=-O0)  # To compile.
# The tests of all these plugins compile the same main, which holds all of Catch.
! command -v ccache >/dev/null || fast+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
export CCACHE_DIR=$work/ccache
[ "$torch" = plain ] || kinds+=(loss features texture)
build_and_test() { # FOLDER
    "$cmake" -S "$1" -B "$1/build" -G Ninja "${fast[@]}" -DCMAKE_PREFIX_PATH="$work/prefix" >log 2>&1 || { cat log; exit 1; }
    "$cmake" --build "$1/build" >log 2>&1 || { cat log; exit 1; }
    ctest --test-dir "$1/build" --output-on-failure >log 2>&1 || { cat log; exit 1; }
    grep -q "100% tests passed, 0 tests failed out of 1" log || { cat log; exit 1; }
}
for kind in "${kinds[@]}"; do
    type=paint.made_$kind folder=paint_made_$kind
    "$fresco" new "$kind" "$type" >said
    # What it says is what is done here.
    grep -qx "  cmake -S $folder -B $folder/build -DCMAKE_PREFIX_PATH=$work/prefix" said || { cat said; exit 1; }
    build_and_test "$folder"
    FRESCO_PLUGIN_PATH=$folder/build "$fresco" describe "$type" >log
    grep -q "$type" log
    [ "$kind" != layout ] || python3 "$(dirname "$0")/recording.py" "$folder/recording"
    weights=()
    [ "$kind" != texture ] || weights=(--set "weights=$(dirname "$0")/../vgg19_relu1_1.safetensors")
    FRESCO_PLUGIN_PATH=$folder/build "$fresco" run "$folder/pipeline.yaml" "${weights[@]}" --store store --out "out_$kind" >log 2>&1 || { cat log; exit 1; }
    "$cmake" --install "$folder/build" >/dev/null --prefix "$work/prefix"
    "$fresco" describe "$type" >/dev/null  # Beside fresco's own now.
done
if [ "$torch" = torch ]; then
    for kind in loss features texture; do
        [ "$(ls "out_$kind/views" | wc -l)" = 4 ] || { echo "$kind: no views"; exit 1; }
    done
fi
# A plugin of the tree with tests and a shared component, copied, as sdk/docs/plugins.md says.
mkdir mine
cp -r "$(dirname "$0")/../../plugins/texture/bake" mine/
sed -n '/^\*\*A plugin of the tree, elsewhere/,/^Give the copy/p' "$(dirname "$0")/../../sdk/docs/plugins.md" |
    sed -n '/^```cmake/,/^```$/p' | grep -v '^```' >mine/CMakeLists.txt
build_and_test mine
"$fresco" init room >/dev/null
"$fresco" check room/pipeline.yaml
echo "new plugins of these kinds were built, tested and run: ${kinds[*]}"
