#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md: runs every example as its head comment says, into docs/pictures.
# docs/gallery.sh [WIDTHxHEIGHT [NAME...]]: all of them, or those named (with those that they read).
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
size=${1:-480x360}
(cd "$root" && cargo build --release --quiet)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
ln -s "$root/examples" examples
PATH="$root/target/release:$PATH"
shift || true
programs=(examples/*.pse)
[ $# -eq 0 ] || programs=("${@/#/examples/}") programs=("${programs[@]/%/.pse}")
lines=$(grep -h -E '^# pse (run|flow)' "${programs[@]}" | sed 's/^# //')
# What reads a picture comes after what makes it.
{
    grep -v -e ' -i ' <<<"$lines" || true
    grep -e ' -i ' <<<"$lines" | grep -v '=' || true
    grep -e ' -i [a-z]*=' <<<"$lines" || true
} |
while read -r line; do
    case $line in
        *' -i '*) ;;
        *' --size '*) ;;
        *) line="$line --size $size" ;;
    esac
    case $line in
        *'|'*) ;;
        *) sh -c "$line --quiet" ;;
    esac
done
mkdir -p "$root/docs/pictures"
for picture in *.png; do
    case $picture in
        *.00[0-9][0-9].png) [ "${picture%.0012.png}" != "$picture" ] || continue ;;
    esac
    name=${picture%.png}
    # JPEG keeps the repository small.
    pse run -e 'color = color' -i "$picture" -o "$root/docs/pictures/${name%.0012}.jpg" --quiet
done
