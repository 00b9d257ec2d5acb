#!/usr/bin/env python3
"""Prints comment words per code word of headers and of .cc files: of all, and with --modules of each module.

A word is a run of letters, digits and underscores. Comments are // and /* */ outside of string and character literals.
  scripts/comment_share.py [--modules] [REVISION]      of the working tree, or of a commit
"""

import argparse
import collections
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
PARTS = re.compile(
    r'(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<text>R"\w*\(.*?\)\w*"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\')', re.S)
WORD = re.compile(r"\w+")


def count_words(source):
    """(comment words, code words)"""
    comment, code, end = 0, 0, 0
    for part in PARTS.finditer(source):
        code += len(WORD.findall(source[end:part.start()]))
        if part["comment"]:
            comment += len(WORD.findall(part["comment"]))
        else:
            code += len(WORD.findall(part["text"]))
        end = part.end()
    return comment, code + len(WORD.findall(source[end:]))


def sources(revision):
    """(path, text) of each file of the library and the programs."""
    if revision is None:
        for folder in ("src", "colmap_adapter"):
            for path in sorted((ROOT / folder).rglob("*")):
                if path.suffix in (".h", ".cc"):
                    yield path.relative_to(ROOT), path.read_text()
        return
    git = lambda *words: subprocess.run(["git", "-C", ROOT, *words], check=True, capture_output=True, text=True).stdout
    for name in git("ls-tree", "-r", "--name-only", revision, "src", "colmap_adapter").splitlines():
        if name.endswith((".h", ".cc")):
            yield pathlib.Path(name), git("show", f"{revision}:{name}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--modules", action="store_true", help="also each module")
    parser.add_argument("revision", nargs="?", help="commit; without it the working tree")
    arguments = parser.parse_args()
    sums = collections.defaultdict(lambda: [0, 0])
    for path, text in sources(arguments.revision):
        module = path.parts[1] if path.parts[0] == "src" else path.parts[0]
        comment, code = count_words(text)
        for row in ("all", module) if arguments.modules else ("all",):
            sums[row, path.suffix][0] += comment
            sums[row, path.suffix][1] += code
    for row in sorted({row for row, _ in sums}, key=lambda name: (name != "all", name)):
        shares = [sums[row, suffix][0] / max(1, sums[row, suffix][1]) for suffix in (".h", ".cc")]
        print(f"{row:<16} headers {shares[0]:.3f}   .cc {shares[1]:.3f}")


if __name__ == "__main__":
    main()
