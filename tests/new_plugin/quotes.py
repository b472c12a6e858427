#!/usr/bin/env python3
"""quotes.py SOURCE: in sdk/docs, a block of code after a line `<!-- quote FILE -->` stands in FILE, line by line, as it is.

Lines that are left out are written `…`. Fails where a quote does not hold, and where there is none.
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
quotes = failed = 0
for page in sorted((root / "sdk/docs").glob("**/*.md")):
    for match in re.finditer(r"<!-- quote (\S+) -->\n```\w*\n(.*?)^```$", page.read_text(), re.M | re.S):
        quotes += 1
        file, text = match.groups()
        source, at = (root / file).read_text(), 0
        for piece in re.split(r"^[ \t]*…\n", text, flags=re.M):
            found = source.find(piece, at)
            if found < 0:
                failed += 1
                print(f"{page.relative_to(root)}: this is not in {file}:\n{piece}")
                break
            at = found + len(piece)
print(f"{quotes} quotes")
sys.exit(1 if failed or quotes < 4 else 0)
