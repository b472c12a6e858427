#include "catch.h"
#include "hand_made_catalog.h"

#include "pipeline/path_marks.h"
#include "pipeline/pipeline_options.h"
#include <fresco/option_declaration.h>

using namespace fresco::host;
using namespace fresco::host::testing;
using fresco::Marks;
using fresco::Value;

namespace
{

/// A stage whose component of kind "form" goes by the path, and components for folders, files and both.
Catalog catalog_of_forms()
{
    Catalog catalog;
    catalog.add(stage("scan.any", "", "frames frames", R"(
        {"name": "path", "kind": "input_path", "required": true, "help": "The scan"},
        {"name": "form", "kind": "component", "component_kind": "form", "chosen_by": "path", "default": "auto", "help": "Its form"})"));
    const auto form = [&](const std::string& type, const Marks& marks)
    {
        TypeDescription description = described(
            type, "form",
            R"({"options": [{"name": "gap_s", "kind": "number", "default": 0.5, "help": "A gap"}], "inputs": [], "outputs": []})");
        description.declaration.set("marks", marks.describe());
        catalog.add(description);
    };
    form("form.lists", {.contains = {"rgb.txt", "poses.txt|poses"}});
    form("form.model", {.contains = {"cameras.*|sparse/cameras.*"}});
    form("form.shots", {.contains = {"shots.json"}, .before = {"form.model"}});
    form("form.told", {.contains = {"frames.json"}, .before = {"*"}});
    form("form.pack", {.formats = {{.name = "a pack", .extensions = {".pack"}, .begins = {"PACK"}}}});
    catalog.add(described("form.plain", "form", R"({"options": [], "inputs": [], "outputs": []})"));
    return catalog;
}

PipelineResult check_scan(const TemporaryFolder& folder, const std::string& options, const Sets& sets = {})
{
    static const Catalog catalog = catalog_of_forms();
    return check(folder, "version: 1\nstages:\n  scan: {type: scan.any, " + options + "}\n", catalog, sets);
}

}  // namespace

TEST_CASE("auto is the component whose marks the path has", "[pipeline]")
{
    const TemporaryFolder folder;
    for (const char* file : {"lists/rgb.txt", "lists/poses/1.txt", "model/sparse/cameras.bin", "both/cameras.txt",
                             "both/shots.json", "told/frames.json", "told/shots.json", "told/cameras.txt"})
        folder.write(file, "");
    folder.write("a.PACK", "PACK of data");
    for (const auto& [path, type] : {std::pair{"lists", "form.lists"},
                                     {"model", "form.model"},
                                     {"both", "form.shots"},
                                     {"told", "form.told"},
                                     {"a.PACK", "form.pack"}})
    {
        CAPTURE(path);
        const std::string expected = R"("form":{"type":")" + std::string(type) + R"(","gap_s":0.5})";
        CHECK_THAT(options_of(check_scan(folder, "path: " + std::string(path)), "scan"), Contains(expected));
        CHECK_THAT(options_of(check_scan(folder, "form: auto, path: " + std::string(path)), "scan"), Contains(expected));
    }
    const PipelineResult told = check_scan(folder, "path: told");
    CHECK(types_by_marks(*told.pipeline.find("scan")) == std::map<std::string, std::string>{{"form", "form.told"}});
    // A layout that the pipeline names is used, with its own options, even if the folder has the marks of another.
    CHECK_THAT(options_of(check_scan(folder, "path: both, form: {type: form.model, gap_s: 2}"), "scan"),
               Contains(R"({"type":"form.model","gap_s":2.0})"));
    CHECK_THAT(options_of(check_scan(folder, "path: both, form: form.plain"), "scan"), Contains(R"({"type":"form.plain"})"));
    CHECK_THAT(options_of(check_scan(folder, "path: lists", {{"scan.form.type", "form.plain"}}), "scan"), Contains("form.plain"));
}

TEST_CASE("where no component fits, or several, each is listed with what it looks for and what was found", "[pipeline]")
{
    const TemporaryFolder folder;
    for (const char* file : {"half/rgb.txt", "half/notes.md", "two/rgb.txt", "two/poses.txt", "two/cameras.txt"})
        folder.write(file, "");
    folder.write("bad.pack", "something else");
    const std::string root = folder.path().string(), at = "p.yaml:3:32: error: stage 'scan' (scan.any): option 'path': ";
    const auto problem = [&](const std::string& options) { return joined_lines(check_scan(folder, options)); };
    CHECK(problem("path: half") ==
          at + "no form fits '" + root +
              "/half'\n  form.lists looks for rgb.txt (found) and poses.txt or poses\n  form.model looks for cameras.* or "
              "sparse/cameras.*\n  form.pack looks for .pack files\n  form.shots looks for shots.json\n  form.told looks for "
              "frames.json");
    CHECK(problem("path: two") ==
          at + "several components of kind form fit '" + root +
              "/two'; name one, form: form.lists or form.model\n  form.lists looks for rgb.txt (found) and "
              "poses.txt (found) or poses\n  form.model looks for cameras.* (found) or sparse/cameras.*");
    CHECK(check_scan(folder, "path: half").exit_code() == 3);
    CHECK(check_scan(folder, "path: two").exit_code() == 2);
    // A file is held to its format, a component that is named to its marks.
    CHECK_THAT(problem("path: bad.pack"), StartsWith(at + "'" + root + "/bad.pack' is not a pack"));
    CHECK(problem("path: two, form: form.shots") == at + "form.shots does not fit '" + root +
                                                        "/two'; form.lists and form.model do\n  form.shots looks for "
                                                        "shots.json");
    // Only what is wrong is reported.
    CHECK(problem("path: nowhere") == at + "no such folder or file '" + root + "/nowhere'");
    CHECK_THAT(problem("path: two, form: form.other"), Contains("unknown type 'form.other'"));
}
