#!/usr/bin/env python3
"""links.py FOLDER: every link of every page below FOLDER, an installation's or the tree, leads to a file or folder below it, and to a
heading that is there. Prints those that do not; fails, too, without any links."""
import pathlib
import re
import sys
import urllib.parse

root = pathlib.Path(sys.argv[1]).resolve()
link = re.compile(r"\]\(([^()\s]+(?:\([^()\s]*\)[^()\s]*)?)\)")
skipped = {".git", "build", "out", ".fresco"}


def anchors_of(page):
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    names = set()
    for heading in re.findall(r"^#+ +(.*?) *$", text, re.M):
        name = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()).replace(" ", "-")
        while name in names:
            name += "-1"
        names.add(name)
    return names


def problem_of(page, target):
    path, _, anchor = urllib.parse.unquote(target).partition("#")
    file = (page.parent / path).resolve() if path else page
    if not file.exists():
        return "there is no such file"
    if root != file and root not in file.parents and root.parent.parent not in file.parents:
        return "leads out of the folder"
    if anchor and file.suffix == ".md" and anchor not in anchors_of(file):
        return "there is no such heading"
    return None


links = 0
problems = []
for page in sorted(root.rglob("*.md")):
    if any(part in skipped or part.startswith("build") for part in page.relative_to(root).parts):
        continue
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target in link.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        links += 1
        if problem := problem_of(page, target):
            problems.append(f"{page.relative_to(root)}: ({target}): {problem}")
print("\n".join(problems) if problems else f"{links} links")
sys.exit(bool(problems) or not links)
