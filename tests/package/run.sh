#!/usr/bin/env bash
# run.sh CMAKE BUILD: installs, moves what is installed, and runs it with an empty environment.
source "$(dirname "$0")/../program_test.sh"
cmake=$1 build=$2

# The linker finds a library outside the system's folders only by its path.
bare=$(grep -ohE ' -l[A-Za-z0-9_+]+' "$build/build.ninja" | grep -vx ' -ldl' | sort -u) || true
[ -z "$bare" ] || fail "linked by their bare names instead of find_library:$bare"

"$cmake" --install "$build" --prefix "$work/prefix" >/dev/null
mkdir "$work/else where"
mv "$work/prefix" "$work/else where/fresco"
moved="$work/else where/fresco"
cd "$work"
env -i "$moved/bin/fresco" stages >found
"$build/bin/fresco" stages >expected
diff expected found || fail "moved, it has other stages"

ln -s "$moved/share/fresco/pipelines" linked
env -i "$moved/bin/fresco" check linked/demo.yaml >said 2>&1 || { cat said; fail "without a home, a linked folder of pipelines is refused"; }

find "$moved/lib/fresco" -name '*.so' ! -name image_opencv.so -delete
env -i "$moved/bin/fresco" doctor | grep -q "^  $moved/lib/fresco  (installation)" || fail "other plugins than its own"

# LD_LIBRARY_PATH has broken libraries: one of the program's, one of a plugin's, and one behind a library of that plugin. They do no harm
# exactly where the archive has its own.
loaded() { ldd "$moved/bin/fresco" "$moved/lib/fresco/image_opencv.so"; }
mapfile -t libraries < <(loaded | awk '$1 ~ /^lib(yaml-cpp|opencv_core|png16)\.so/ { print $1 }' | sort -u)
[ ${#libraries[@]} -eq 3 ] || fail "these libraries are loaded: ${libraries[*]}"
mkdir "$work/broken" "$moved/lib/fresco/bundled"
loads() { env -i LD_LIBRARY_PATH="$work/broken" "$moved/bin/fresco" doctor >said 2>&1; }
for library in "${libraries[@]}"; do
    echo "no library" >"$work/broken/$library"
    ! loads || fail "the broken $library is not used, so this test shows nothing"
    cp "$(loaded | awk -v name="$library" '$1 == name { print $3; exit }')" "$moved/lib/fresco/bundled/"
    loads || { cat said; fail "the archive's $library is not used"; }
done
echo "moved, it has $(wc -l <expected) lines of stages, and uses its own ${libraries[*]}"
