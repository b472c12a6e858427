#!/usr/bin/env bash
# try.sh: the packages in build/packages, each in a bare Debian of its own: as nobody, with an empty environment and no network, they must
# write the files that build/bin/fresco writes. The archive by the steps of its Apptainer definition, the .deb by those of its Dockerfile.
source "$(dirname "$0")/bare_debian.sh"

as_nobody() { network=none in_tree "$1" nobody env -i "${@:2}"; }
paint() { # PIPELINES FOLDER PROGRAM...: the demo, and what it leaves out
    local pipelines=$1 folder=$2
    shift 2
    "$@" run "$pipelines/demo.yaml" --store "$folder/store" --out "$folder/out/demo" &&
        "$@" run "$folder/try.yaml" --set picture="$pipelines/pictures/night_sky.jpg" --store "$folder/store" --out "$folder/out/try"
}
compare() { # NAME
    diff -r --exclude=report.html --exclude=run.json "$work/build/out" "$work/$1/tmp/out" || fail "$1: its results differ from the build's"
    echo "$1: $(find "$work/$1/tmp/out" -type f | wc -l) files as the build writes them"
}

mkdir "$work/build"
cp framework/package/try.yaml tests/vgg19_relu1_1.safetensors "$work/build/"
logged paint pipelines "$work/build" build/bin/fresco

# Then the archive is moved.
step() { sed -n "/^%$1\$/,/^%/{/^%/d;p}" build/packages/fresco.def; }
bare archive "$here"
setup=$(step setup)
(cd build/packages && APPTAINER_ROOTFS=$work/archive sh -ec "$setup")
chroot "$work/archive" sh -ec "$(step post)"
cp framework/package/try.yaml tests/vgg19_relu1_1.safetensors "$work/archive/tmp/"
logged as_nobody archive sh -ec "$(step test)"
logged paint /pipelines /tmp as_nobody archive sh -ec "$(step runscript)" fresco
compare archive
mv "$work/archive/opt/fresco" "$work/archive/opt/else where"
as_nobody archive "/opt/else where/bin/fresco" run "/opt/else where/share/fresco/pipelines/demo.yaml" --store /tmp/store --out /tmp/out/demo \
    --json-log >"$work/log"
! grep '"event":"begin"' "$work/log" || fail "archive: moved, it runs stages again"

bare package "$here"
docker=build/packages/Dockerfile
read -r _ files target < <(grep ^COPY "$docker")
cp build/packages/$files "$work/package$target"
cp framework/package/try.yaml tests/vgg19_relu1_1.safetensors "$work/package/tmp/"
logged in_tree package root sh -ec "$(sed -n 's/^RUN //p' "$docker")"
entry=$(sed -n 's/^ENTRYPOINT \["\(.*\)"\]$/\1/p' "$docker")
logged paint /usr/share/fresco/pipelines /tmp as_nobody package "$entry"
compare package
cmp "$work/package/usr/bin/fresco" "$work/archive/opt/else where/bin/fresco"
for plugin in "$work"/package/usr/lib/fresco/*.so; do
    cmp "$plugin" "$work/archive/opt/else where/lib/fresco/$(basename "$plugin")"
    cmp "${plugin%.so}.json" "$work/archive/opt/else where/lib/fresco/$(basename "$plugin" .so).json"
done
