#!/usr/bin/env bash
# try.sh: the packages in build/packages, each in a bare Debian 12 of its own that comes from this machine's apt sources: as nobody, with
# an empty environment and no network, they must write the files that build/bin/fresco writes. Needs root and mmdebstrap.
set -euo pipefail
cd "$(dirname "$0")/../.."
fail() { echo "error: $*" >&2; exit 1; }
mapfile -t sources < <(grep -ls bookworm /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources)
[ ${#sources[@]} -gt 0 ] || fail "no file in /etc/apt names the release bookworm, so there is nowhere to get a bare Debian 12 from"
work=$(mktemp -d)
# If mmdebstrap was killed, its tree still has this machine's /dev.
trap 'rm -rf --one-file-system "$work"' EXIT
chmod 755 "$work"

logged() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }
bare() { # NAME [OPTION...]: only essential packages and apt, and those that OPTIONs name
    echo "$1: making a bare Debian"
    logged mmdebstrap --variant=minbase --dpkgopt=force-unsafe-io "${@:2}" bookworm "$work/$1" "${sources[@]}"
    cp framework/package/try.yaml "$work/$1/tmp/"
}
in_tree() { # NAME PROGRAM [ARGUMENT...]
    unshare --mount --net --pid --fork bash -c 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && cd / &&
        exec chroot "$0" setpriv --reuid=65534 --regid=65534 --clear-groups env -i "$@"' "$work/$1" "${@:2}"
}
paint() { # PIPELINES FOLDER PROGRAM...: the demo, and what it leaves out
    local pipelines=$1 folder=$2
    shift 2
    "$@" run "$pipelines/demo.yaml" --store "$folder/store" --out "$folder/out/demo" &&
        "$@" run "$folder/try.yaml" --store "$folder/store" --out "$folder/out/try"
}
compare() { # NAME
    diff -r --exclude=report.html --exclude=run.json "$work/build/out" "$work/$1/tmp/out" || fail "$1: its results differ from the build's"
    echo "$1: $(find "$work/$1/tmp/out" -type f | wc -l) files as the build writes them"
}

mkdir "$work/build"
cp framework/package/try.yaml "$work/build/"
logged paint pipelines "$work/build" build/bin/fresco

# The archive by the steps of its Apptainer definition, then moved.
step() { sed -n "/^%$1\$/,/^%/{/^%/d;p}" build/packages/fresco.def; }
bare archive
setup=$(step setup)
(cd build/packages && APPTAINER_ROOTFS=$work/archive sh -ec "$setup")
chroot "$work/archive" sh -ec "$(step post)"
logged in_tree archive sh -ec "$(step test)"
logged paint /pipelines /tmp in_tree archive sh -ec "$(step runscript)" fresco
compare archive
mv "$work/archive/opt/fresco" "$work/archive/opt/else where"
in_tree archive "/opt/else where/bin/fresco" run "/opt/else where/share/fresco/pipelines/demo.yaml" --store /tmp/store --out /tmp/out/demo \
    --json-log >"$work/log"
! grep '"event":"begin"' "$work/log" || fail "archive: moved, it runs stages again"

bare package --hook-dir=/usr/share/mmdebstrap/hooks/file-mirror-automount --include="$(realpath build/packages/*.deb)"
logged paint /usr/share/fresco/pipelines /tmp in_tree package fresco
compare package
cmp "$work/package/usr/bin/fresco" "$work/archive/opt/else where/bin/fresco"
for plugin in "$work"/package/usr/lib/fresco/*.so; do
    cmp "$plugin" "$work/archive/opt/else where/lib/fresco/$(basename "$plugin")"
done
