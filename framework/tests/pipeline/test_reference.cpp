#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/reference.h"
#include <fresco/files_io.h>
#include <fresco/testing.h>

using namespace fresco::host;
using namespace fresco::host::testing;

TEST_CASE("every type has a page, made of its declaration", "[reference]")
{
    const auto pages = reference_pages(catalog_with_codecs());
    CHECK(pages.at("mesh.pass.md") == "<!-- Written by 'fresco reference' -->\n"
                                      "# mesh.pass\n\nWhat mesh.pass does.\n\nA stage, in the plugin `mesh.pass`.\n"
                                      "\n## Inputs\n\n| port | artifact | |\n|---|---|---|\n| `mesh` | mesh, optional | |\n"
                                      "\n## Outputs\n\n| port | artifact | |\n|---|---|---|\n| `mesh` | mesh | |\n"
                                      "\n## Options\n\n| option | default | accepted | |\n|---|---|---|---|\n"
                                      "| `title` | `\"\"` | text | A text |\n| `size` | `1.0` | a number | A number |\n");
    CHECK_THAT(pages.at("texture.optimize.md"),
               Contains("| `preview`° |") && Contains("\n° does not affect the result: changing it reruns nothing.\n") &&
                   Contains("\nFor `losses`: [`loss.content`](loss.content.md), [`loss.gram`](loss.gram.md).\n"));
    CHECK_THAT(pages.at("picture.peek.md"), Contains("| `codec` | [`codec.plain`](codec.plain.md) | may be none | Encodes |"));
    CHECK_THAT(pages.at("read.image.md"), Contains("It reads `image` from files that end in `.png`, `.jpg`.\n"));
    CHECK_THAT(pages.at("README.md"), Contains("| [`mesh.pass`](mesh.pass.md) | What mesh.pass does |\n") &&
                                          Contains("| `texture` | [`texture.optimize`](texture.optimize.md) | "
                                                   "[`export.gltf`](export.gltf.md) |\n"));
}

TEST_CASE("pages are written where they differ, and nothing else is touched", "[reference]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto place = folder.path() / "reference";
    const auto pages = reference_pages(hand_made_catalog());
    CHECK(write_reference(pages, place).size() == pages.size());
    CHECK(fresco::read_text_file(place / "mesh.pass.md") == pages.at("mesh.pass.md"));
    CHECK(write_reference(pages, place).empty());

    fresco::write_file(place / "mesh.pass.md", pages.at("mesh.pass.md") + "and more\n");
    fresco::write_file(place / "loss.gone.md", pages.at("loss.gram.md"));
    CHECK(write_reference(pages, place) == std::vector<std::string>{"loss.gone.md", "mesh.pass.md"});
    CHECK_FALSE(std::filesystem::exists(place / "loss.gone.md"));

    fresco::write_file(place / "README.md", "My own words.\n");
    CHECK_THROWS_WITH(write_reference(pages, place), Contains("README.md: exists and is not a page of the reference"));
    CHECK(fresco::read_text_file(place / "README.md") == "My own words.\n");
}
