#!/usr/bin/env python3
"""Runs folders of image and mesh files through `pse info` and `pse run`, and compares with a table.

    tests/suites/run.py update TABLE FOLDER...    writes the table
    tests/suites/run.py check TABLE FOLDER...     compares with it; status 1 if something differs

The table has a line for each file: its path below the folder, a digest of the file, and what became of it. A file
that is read has a digest of what `pse info` prints and one of the pixels (of meshes, of their normals in a small
view). A file that is refused has the beginning of the message. A file that ends in a crash or takes longer than
--seconds is always reported, and makes the status 1.

Files are of other projects, so none is here; see docs/reliability.md. The files of tests/kinds, which are made by
make_kinds.py, are checked by src/image/tests/kinds.rs.
"""

import argparse
import concurrent.futures
import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

IMAGES = "exr png jpg jpeg tif tiff tx hdr bmp dib tga icb vda vst webp".split()
MESHES = "obj ply gltf glb".split()


def digest(content):
    return hashlib.sha256(content).hexdigest()[:16]


def command(arguments, folder, seconds):
    """The status of a command, or `hang`; what it printed; its message."""
    try:
        done = subprocess.run(arguments, cwd=folder, capture_output=True, timeout=seconds, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired:
        return "hang", b"", ""
    return done.returncode, done.stdout, done.stderr.decode(errors="replace")


def outcome(pse, path, seconds):
    """What becomes of a file: a word, and details in one line."""
    name = str(path)
    with tempfile.TemporaryDirectory() as folder:
        results = []
        output = Path(folder, "out.tif")
        write = ["--bits", "32", "--raw", "-o", str(output)]
        if path.suffix.lower()[1:] in MESHES:
            view = ["-e", "color = normal", "--mesh", name, "--size", "64x48"]
        else:
            view = ["-e", "color = color", "-i", name]
        for arguments in (["info", name], ["run", "-q", *view, *write]):
            status, printed, message = command([pse, *arguments], folder, seconds)
            if status == "hang":
                return "hang", f"pse {arguments[0]} took more than {seconds} seconds"
            if status == 1 and message.strip():
                # Lines are broken at the width of a terminal, names included.
                words = " ".join(message.replace(name, "FILE").replace("│", " ").split())
                results.append(f"{arguments[0]} refused: {words[:200]}")
            elif status != 0:
                return "crash", f"pse {arguments[0]} ended with status {status}"
            elif arguments[0] == "info":
                results.append("info " + digest(printed.replace(name.encode(), b"FILE")))
            elif output.exists():
                results.append("run " + digest(output.read_bytes()))
            else:
                return "crash", "pse run ended with status 0 and wrote nothing"
        refused = sum("refused" in result for result in results)
        return ("read", "partly read", "refused")[refused], "; ".join(results)


def files(folders, extensions):
    for folder in map(Path, folders):
        found = [folder] if folder.is_file() else sorted(folder.rglob("*"))
        for path in found:
            if path.is_file() and path.suffix.lower()[1:] in extensions:
                below = path.name if folder.is_file() else path.relative_to(folder).as_posix()
                yield f"{folder.name}/{below}", path.resolve()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=["update", "check"])
    parser.add_argument("table", type=Path)
    parser.add_argument("folder", nargs="+")
    parser.add_argument("--pse", default=os.environ.get("PSE", "target/release/pse"), help="the program to try")
    parser.add_argument("--seconds", type=float, default=60, help="the longest time for a file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="files that are tried at a time")
    arguments = parser.parse_args()
    pse = str(Path(arguments.pse).resolve())
    every = list(files(arguments.folder, IMAGES + MESHES))
    known = {}
    if arguments.action == "check":
        for line in arguments.table.read_text().splitlines():
            name, *rest = line.split("\t")
            known[name] = rest
    lines, counts, wrong = [], {}, 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        found = pool.map(lambda file: outcome(pse, file[1], arguments.seconds), every)
        for (name, path), (word, details) in zip(every, found):
            suffix = path.suffix.lower()[1:]
            counts.setdefault(suffix, {}).setdefault(word, 0)
            counts[suffix][word] += 1
            line = [digest(path.read_bytes()), word, details]
            lines.append("\t".join([name, *line]) + "\n")
            before = known.pop(name, None)
            bad = word in ("crash", "hang")
            if arguments.action == "check" and before is None:
                print(f"new: {name}: {word}: {details}")
            elif arguments.action == "check" and before[0] != line[0]:
                print(f"another file than in the table: {name}")
            elif arguments.action == "check" and before != line:
                print(f"differs: {name}\n  before: {before[1]}: {before[2]}\n  now:    {word}: {details}")
                bad = True
            elif bad:
                print(f"{word}: {name}: {details}")
            wrong += bad
    for name in known:
        print(f"not found: {name}")
    if arguments.action == "update":
        arguments.table.write_text("".join(lines))
    for suffix, words in sorted(counts.items()):
        print(f"{suffix}: " + ", ".join(f"{count} {word}" for word, count in sorted(words.items())))
    print(f"{len(every)} files, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
