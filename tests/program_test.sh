# To be sourced by the tests that run programs: $work, a folder that goes when they end, nothing of the user's in the programs' way, and
# `fail` and `skip` with what there is to say.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME=$work/cache XDG_DATA_HOME=$work/data
unset FRESCO_PLUGIN_PATH
test_name=$(basename "$(dirname "$(realpath "$0")")")
fail() { echo "$test_name: $*" >&2; exit 1; }
# python_with MODULE, …: an installed interpreter that has these modules; fails without one.
python_with() {
    local python
    for python in /usr/bin/python3 "$(command -v python3)"; do
        "$python" -c "import $*" 2>/dev/null && { echo "$python"; return; }
    done
    return 1
}
# Skipped tests are listed at the end of the whole check.
skip() {
    echo "SKIPPED $*"
    [ -z "${FRESCO_SKIP_LOG:-}" ] || echo "$*" >>"$FRESCO_SKIP_LOG"
}
