#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md: runs every example as its head comment says, into docs/pictures.
# docs/gallery.sh [WIDTHxHEIGHT]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
size=${1:-480x360}
(cd "$root" && cargo build --release --quiet)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
ln -s "$root/examples" examples
PATH="$root/target/release:$PATH"
# What reads a picture comes after what makes it.
lines=$(grep -h '^# pse run' examples/*.pse | sed 's/^# //')
{ grep -v -e ' -i ' <<<"$lines"; grep -e ' -i ' <<<"$lines" | grep -v '='; grep -e ' -i [a-z]*=' <<<"$lines"; } |
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
