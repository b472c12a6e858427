#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/reference.h"
#include <fresco/files_io.h>
#include <fresco/testing.h>

using namespace fresco::host;
using namespace fresco::host::testing;
using Catch::Contains;

namespace
{

Catalog small_catalog()
{
    Catalog catalog;
    catalog.add(described("mesh.pass", "stage", R"({
        "options": [{"name": "size_px", "kind": "int", "default": 5, "min": 1.0, "unit": "px", "help": "A size | in texels"},
                    {"name": "path", "kind": "input_file", "required": true, "help": "A file"},
                    {"name": "note", "kind": "text", "default": "", "in_key": false, "help": "A note"},
                    {"name": "style", "kind": "component", "component_kind": "loss", "help": "A loss"}],
        "components": [{"name": "codec", "kind": "component", "component_kind": "codec", "default": {"type": "codec.plain"},
                        "optional": true, "help": "Encodes"}],
        "inputs": [{"name": "mesh", "artifact": "mesh", "version": 1, "optional": true, "help": "What comes in"}],
        "outputs": [{"name": "out", "artifact": "table", "version": 3, "help": "What goes out"}]})"));
    catalog.add(described("loss.gram", "loss", "{}"));
    catalog.add(described("read.mesh", "reader", R"({"artifact": "mesh", "extensions": [".ply", ".obj"]})"));
    return catalog;
}

std::string text_of(const std::vector<ReferencePage>& pages, const std::string& file)
{
    const auto page = std::ranges::find(pages, file, &ReferencePage::file);
    return page == pages.end() ? "no such page" : page->text;
}

}  // namespace

TEST_CASE("every type has a page, made of its declaration", "[reference]")
{
    const auto pages = reference_pages(small_catalog());
    REQUIRE(pages.size() == 4);
    CHECK(text_of(pages, "mesh.pass.md") ==
          "<!-- Written by 'fresco reference' -->\n"
          "# mesh.pass\n\nWhat mesh.pass does.\n\nA stage, in the plugin `mesh.pass`.\n"
          "\n## Inputs\n\n| port | artifact | |\n|---|---|---|\n| `mesh` | mesh, optional | What comes in |\n"
          "\n## Outputs\n\n| port | artifact | |\n|---|---|---|\n| `out` | table (version 3) | What goes out |\n"
          "\n## Options\n\n| option | default | accepted | |\n|---|---|---|---|\n"
          "| `size_px` | `5` | an integer of at least 1 | A size \\| in texels |\n"
          "| `path` | required | the path of an existing file | A file |\n"
          "| `note`° | `\"\"` | text | A note |\n"
          "| `style` | none | {type: …} of kind 'loss', or none | A loss |\n"
          "\n° does not affect the result: changing it reruns nothing.\n"
          "\nFor `style`: [`loss.gram`](loss.gram.md).\n"
          "\n## Components\n\nThe pipeline [chooses them](../pipelines.md#shared-components) for all its stages.\n"
          "\n| kind | default | | |\n|---|---|---|---|\n| `codec` | [`codec.plain`](codec.plain.md) | may be none | Encodes |\n");
    CHECK_THAT(text_of(pages, "read.mesh.md"),
               Contains("A component of kind `reader`") && Contains("It reads `mesh` from files that end in `.ply`, `.obj`.\n"));
    CHECK_THAT(text_of(pages, "README.md"),
               Contains("\n## Stages\n\n| type | |\n|---|---|\n| [`mesh.pass`](mesh.pass.md) | What mesh.pass does |\n") &&
                   Contains("## Components of kind loss") &&
                   Contains("| `mesh` | [`read.mesh`](read.mesh.md) | [`mesh.pass`](mesh.pass.md) |\n") &&
                   Contains("| `table` | [`mesh.pass`](mesh.pass.md) | |\n"));
}

TEST_CASE("pages are written where they differ, and nothing else is touched", "[reference]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto place = folder.path() / "reference";
    const auto pages = reference_pages(small_catalog());
    CHECK(reference_differences(pages, place).size() == pages.size());
    CHECK(write_reference(pages, place).size() == pages.size());
    CHECK(reference_differences(pages, place).empty());
    CHECK(write_reference(pages, place).empty());

    fresco::write_file(place / "mesh.pass.md", pages.front().text + "and more\n");
    fresco::write_file(place / "loss.gone.md", text_of(pages, "loss.gram.md"));
    fresco::write_file(place / "notes.md", "Mine.\n");
    const auto differences = reference_differences(pages, place);
    REQUIRE(differences.size() == 2);
    CHECK_THAT(differences[0], Contains("reference/mesh.pass.md: is not what the plugin declares") ||
                                   Contains("reference/loss.gram.md: is not what the plugin declares"));
    CHECK_THAT(differences[1], Contains("reference/loss.gone.md: no plugin has this type"));
    CHECK(write_reference(pages, place).size() == 2);
    CHECK_FALSE(std::filesystem::exists(place / "loss.gone.md"));
    CHECK(fresco::read_text_file(place / "notes.md") == "Mine.\n");

    fresco::write_file(place / "README.md", "My own words.\n");
    CHECK_THROWS_WITH(write_reference(pages, place), Contains("README.md: exists and is not a page of the reference"));
    CHECK(fresco::read_text_file(place / "README.md") == "My own words.\n");
}
