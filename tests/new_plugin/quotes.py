#!/usr/bin/env python3
"""quotes.py SOURCE: in sdk/docs, a block of code after a line `<!-- quote FILE -->` stands in FILE, line by line, as it is.

Lines that are left out are written `…`. Fails if a quote does not hold, and without any quotes.
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
quotes = failed = listed = 0
for page in sorted((root / "sdk/docs").glob("**/*.md")):
    text = page.read_text()
    listed += text.count("<!-- quote ")
    for match in re.finditer(r"<!-- quote (\S+) -->\n```\w*\n(.*?)^```$", text, re.M | re.S):
        quotes += 1
        file, text = match.groups()
        source, at = "\n" + (root / file).read_text(), 0
        for piece in re.split(r"^[ \t]*…\n", text, flags=re.M):
            found = source.find("\n" + piece, at)  # From a line's begin on.
            if found < 0:
                failed += 1
                print(f"{page.relative_to(root)}: this is not in {file}:\n{piece}")
                break
            at = found + len(piece)  # Its last line's end stays: the next piece begins behind it.
print(f"{quotes} quotes")
sys.exit(1 if failed or quotes == 0 or quotes != listed else 0)
