#!/usr/bin/env bash
# site.sh ROOM.html: build/site, the documentation as a website with a search, and a room to walk through.
set -euo pipefail
cd "$(dirname "$0")/../.."
pages=build/site-pages
rm -rf $pages build/site
mkdir -p $pages
git ls-files -z -- '*.md' '*.jpg' pipelines sdk/docs sdk/examples sdk/python sdk/blender sdk/include LICENSE CITATION.cff | tar -c --null -T - | tar -x -C $pages
mv $pages/.github $pages/github  # mkdocs leaves out what begins with a dot.
cp "$1" $pages/room.html
# To folders, which a website cannot show, and to files of the project that are not pages: to the text only.
python3 - $pages <<'PY'
import pathlib, re, sys
pages = pathlib.Path(sys.argv[1])
for page in pages.rglob("*.md"):
    def link(found):
        text, target = found[1], found[2].replace(".github/", "github/")
        path = target.partition("#")[0]
        there = page.parent / path
        if re.match("[a-z]+:", target) or not path or there.suffix in {".md", ".jpg", ".html"} or there.is_file():
            return f"[{text}]({target})"
        readme = there / "README.md"
        return f"[{text}]({path.rstrip('/')}/README.md)" if readme.is_file() else text
    page.write_text(re.sub(r"\[([^\]\[]*)\]\(([^)\s]+)\)", link, page.read_text()))
home = pages / "README.md"
home.write_text(home.read_text().replace("\n## Features", "\n[Walk through the painted room](room.html): in this browser, on a phone, with a headset.\n\n## Features", 1))
PY
cat >build/mkdocs.yml <<YAML
site_name: fresco
docs_dir: site-pages
site_dir: site
theme: {name: mkdocs, highlightjs: false}
use_directory_urls: false
plugins: [search]
nav:
  - README.md
  - Gallery: pipelines/gallery.md
  - Pipelines: [pipelines/README.md, sdk/docs/pipelines.md, pipelines/results.md, pipelines/cluster.md, pipelines/paper/README.md]
  - Your data: [sdk/docs/phones.md, sdk/docs/your-recording.md, sdk/docs/python.md, sdk/docs/blender.md, sdk/docs/commands.md, sdk/docs/artifacts.md]
  - Reference: [sdk/docs/command-line.md, sdk/docs/reference/README.md, sdk/docs/guarantees.md]
  - Plugins: [sdk/docs/writing-a-plugin.md, sdk/docs/plugins.md, sdk/docs/writing-a-layout.md, sdk/README.md, plugins/README.md]
  - Project: [sdk/docs/building.md, sdk/docs/dependencies.md, CHANGELOG.md]
YAML
mkdocs --quiet build --strict --config-file build/mkdocs.yml
