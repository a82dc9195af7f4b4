#!/usr/bin/env python3
"""Writes THIRD-PARTY.md: every crate that is linked into the command, its licence, and the licence texts.

    .ci/notices.py            write it
    .ci/notices.py --check    fail if it is not current, or if a crate has a licence that is not on the list below

Needs Python 3.11 and cargo; the crates' sources must be in cargo's registry (`cargo fetch`)."""

import json
import pathlib
import re
import subprocess
import sys

# Licences under which a crate may be linked into a binary that is offered as MIT OR Apache-2.0.
ALLOWED = {
    "MIT", "MIT-0", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "ISC", "Zlib",
    "0BSD", "Unlicense", "CC0-1.0", "Unicode-3.0", "BSL-1.0", "OFL-1.1", "Ubuntu-font-1.0",
}
# Crates whose manifest names no licence: what their licence file says.
STATED = {}
# The targets that releases are built for.
TARGETS = [
    "x86_64-unknown-linux-gnu", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-msvc", "aarch64-apple-darwin",
    "wasm32-unknown-unknown",
]
ROOT = pathlib.Path(__file__).resolve().parent.parent
FILE = ROOT / "THIRD-PARTY.md"
TEXTS = re.compile(r"^(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)


def allowed(expression):
    """Whether an SPDX expression (also the old form with `/`) can be met with licences of the list."""
    words = expression.replace("/", " OR ").replace("(", " ( ").replace(")", " ) ").split()
    words = re.sub(r"(\S+) WITH (\S+)", r"\1@WITH@\2", " ".join(words)).split()
    python = [
        w.lower() if w in ("AND", "OR") else w if w in "()" else str(w.replace("@", " ") in ALLOWED) for w in words
    ]
    return eval(" ".join(python))  # Only True, False, and, or and brackets.


def linked():
    """The packages that the command links, on all targets of TARGETS, without crates that run at build time only."""
    metadata = json.loads(subprocess.check_output(["cargo", "metadata", "--format-version", "1", "--locked"], cwd=ROOT))
    packages = {(p["name"], p["version"]): p for p in metadata["packages"] if p["source"]}
    found = set()
    for target in TARGETS:
        command = ["cargo", "tree", "--locked", "--target", target, "-e", "normal,no-proc-macro", "--prefix", "none"]
        for line in subprocess.check_output(command, cwd=ROOT, text=True).splitlines():
            name, version = line.split()[:2]
            found.add((name, version.removeprefix("v")))
    return [packages[key] for key in sorted(found) if key in packages]


def texts(package):
    folder = pathlib.Path(package["manifest_path"]).parent
    files = [f for f in sorted(folder.rglob("*")) if f.is_file() and TEXTS.match(f.name) and len(f.relative_to(folder).parts) <= 2]
    files = [f for f in files if f.suffix.lower() in ("", ".md", ".txt", ".mit", ".apache", ".apache2")
             or re.match(r"^\.[A-Z]", f.suffix)]
    return [f.read_text(errors="replace").strip() for f in files]


def main():
    packages = linked()
    bad = []
    for p in packages:
        p["license"] = p["license"] or STATED.get(p["name"]) or "unknown"
        if p["license"] == "unknown" or not allowed(p["license"]):
            bad.append(f"{p['name']} {p['version']}: {p['license']}")
    if bad:
        sys.exit("These licences are not on the list of .ci/notices.py:\n  " + "\n  ".join(bad))
    lines = [
        "# Third-party notices", "",
        "The command `pse` contains these crates. Each keeps its own licence, which follows the table;",
        "texts that several crates share stand once. `.ci/notices.py` writes this file.", "",
        "| crate | version | licence |", "|---|---|---|",
    ]
    lines += [f"| {p['name']} | {p['version']} | {p['license']} |" for p in packages]
    shared = {}
    for p in packages:
        for text in texts(p):
            # The same licence with other line breaks is the same text.
            shared.setdefault(" ".join(text.split()), (text, []))[1].append(p["name"])
    page = (ROOT / "src/cli/view/page/codemirror.LICENSE").read_text()
    shared["codemirror"] = (page, ["CodeMirror (in the page of `pse view`)"])
    for text, names in shared.values():
        lines += ["", "## " + ", ".join(sorted(set(names))), "", "```text"]
        lines += [line.rstrip().replace("```", "'''") for line in text.splitlines()]
        lines += ["```"]
    written = "\n".join(lines) + "\n"
    if "--check" in sys.argv:
        if not FILE.exists() or FILE.read_text() != written:
            sys.exit("THIRD-PARTY.md is not current: run .ci/notices.py")
        print(f"THIRD-PARTY.md is current: {len(packages)} crates")
    else:
        FILE.write_text(written)
        print(f"{len(packages)} crates, {len(shared)} texts, {len(written)} bytes")


main()
