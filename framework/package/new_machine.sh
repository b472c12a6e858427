#!/usr/bin/env bash
# new_machine.sh RELEASE demo|test|"test --all": the committed tree in a bare Debian, by the README's command, as a user whom sudo lets install packages.
# All that the command prints goes to build/try, and from the demo its results.
source "$(dirname "$0")/bare_debian.sh"
release=$1 task=$2 result=$PWD/build/try/debian$1-${2// --/-}
[ -z "$(git status --porcelain)" ] || echo "note: changes that are not committed are not tried"
rm -rf "$result"
mkdir -p "$result"
bare machine "$release" --include=sudo,git,ca-certificates
# What this machine trusts, such as the certificate of a proxy.
cp -r /usr/local/share/ca-certificates "$work/machine/usr/local/share/"
logged chroot "$work/machine" update-ca-certificates
user=painter
chroot "$work/machine" useradd --create-home --shell /bin/bash $user
echo "$user ALL=(ALL) NOPASSWD: ALL" >"$work/machine/etc/sudoers.d/$user"
git clone --quiet --no-hardlinks . "$work/machine/home/$user/fresco"
chroot "$work/machine" chown -R $user:$user /home/$user/fresco

begin=$SECONDS
echo "$task: ./bootstrap $task"
in_tree machine $user bash -c "cd ~/fresco && time ./bootstrap $task" >"$result/log" 2>&1 || { tail -n 100 "$result/log" >&2; fail "Debian $release: ./bootstrap $task failed; all of it is in $result/log"; }
grep -E '^== |tests passed|^The room, painted|^(real|user)' "$result/log" | grep -v '^== Skipped'
sed -n '/^== Skipped/,/^real/p' "$result/log" | grep -v '^real' || true
[ "$task" != demo ] || cp -r "$work/machine/home/$user/fresco/out" "$result/"
echo "Debian $release: $((SECONDS - begin)) s with the packages that were installed; log: $result/log"
