# To be sourced: bare Debian systems in $work, made by mmdebstrap from this machine's apt sources and gone when the script ends. Needs root.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
fail() { echo "error: $*" >&2; exit 1; }
declare -A names=([12]=bookworm [13]=trixie)
here=$(. /etc/os-release && echo "${VERSION_ID:-}")
work=$(mktemp -d)
# If mmdebstrap was killed, its tree still has this machine's /dev.
trap 'rm -rf --one-file-system "$work"' EXIT
chmod 755 "$work"

logged() { "$@" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }; }

# bare NAME RELEASE [OPTION...]: only essential packages and apt, and those that OPTIONs of mmdebstrap name.
bare() {
    local name=$1 codename=${names[$2]} own=${names[$here]:-} file sources=()
    [ -n "$own" ] || fail "the apt sources of this machine are not those of Debian 12 or 13, so there is nowhere to get a bare Debian from"
    mkdir -p "$work/sources"
    for file in $(grep -lsw "$own" /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources); do
        # Sources of other projects may not have that release.
        grep -q debian.org "$file" || [ "$own" = "$codename" ] || continue
        sed "s/\b$own\b/$codename/g" "$file" >"$work/sources/$(basename "$file")"
        sources+=("$work/sources/$(basename "$file")")
    done
    [ ${#sources[@]} -gt 0 ] || fail "no file in /etc/apt names the release $own, so there is nowhere to get a bare Debian from"
    echo "$name: making a bare Debian $2"
    logged mmdebstrap --variant=minbase --dpkgopt=force-unsafe-io "${@:3}" "$codename" "$work/$name" "${sources[@]}"
    cp --dereference /etc/resolv.conf "$work/$name/etc/"
    echo "127.0.0.1 localhost $(hostname)" >"$work/$name/etc/hosts"
}

# in_tree NAME USER PROGRAM [ARGUMENT...]: with an empty environment; with $network=none, without a network. The tree is the root of a mount
# namespace, not a chroot, because programs there make namespaces of their own.
in_tree() {
    local isolation=(--mount --pid --fork)
    [ "${network:-}" != none ] || isolation+=(--net)
    unshare "${isolation[@]}" bash -c 'mount --bind "$0" "$0" && cd "$0" && mount -t proc proc proc && mount --rbind /dev dev &&
        mount --rbind /sys sys && pivot_root . mnt && cd / && umount -l /mnt &&
        exec setpriv --reuid="$1" --regid="$(id -g "$1")" --init-groups env -i HOME="$(getent passwd "$1" | cut -d: -f6)" \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "${@:2}"' "$work/$1" "${@:2}"
}
