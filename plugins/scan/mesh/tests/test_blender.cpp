#include "blender.h"
#include "catch.h"

#include "model_samples.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/process.h>
#include <fresco/testing.h>

#include <cstdlib>

using namespace fresco;
using fresco::testing::TestRun;

namespace
{

/// A folder with a program "blender" of its own in PATH, a shell script, and a model "a.dae" that only the program looks at.
struct FakeBlender
{
    testing::TemporaryFolder folder;
    std::string path = std::getenv("PATH");
    explicit FakeBlender(const std::string& script)
    {
        write_file(folder.path() / "a.dae", std::string_view("a model"));
        if (!script.empty())
            write_file(folder.path() / "blender", "#!/bin/sh\nfor glb; do :; done\n" + script);
        std::filesystem::permissions(folder.path() / (script.empty() ? "a.dae" : "blender"), std::filesystem::perms::owner_all);
        setenv("PATH", script.empty() ? folder.path().c_str() : (folder.path().string() + ":" + path).c_str(), 1);
    }
    FakeBlender(const FakeBlender&) = delete;
    FakeBlender& operator=(const FakeBlender&) = delete;
    ~FakeBlender() { setenv("PATH", path.c_str(), 1); }

    void read(TestRun& run) const
    {
        testing::run_stage(FRESCO_PLUGIN_FILE, "scan.mesh", Value::Map{{"path", (folder.path() / "a.dae").string()}}, {},
                           folder.path() / "out", run, {{"image_io", std::make_shared<stored_png::Codec>()}});
    }
    std::string error() const
    {
        TestRun run;
        return testing::error_of([&] { read(run); });
    }
};

}  // namespace

TEST_CASE("a model that Blender converts is read, and depends on Blender and on the files that the model names", "[scan.mesh]")
{
    const testing::TemporaryFolder models;
    const std::string box = model_samples::write_glb_box(models.path()).string();
    const FakeBlender blender("echo fresco: version 9.9\necho fresco: file $PWD/no.png\necho fresco: file " + box + "\ncp " +
                              box + " \"$glb\"\n");
    TestRun run;
    blender.read(run);
    CHECK(run.reported.at("faces").as_int() == 12);
    CHECK(run.reported.at("blender").as_string() == "9.9");
    CHECK(run.files_read == std::vector<std::filesystem::path>{blender.folder.path() / "blender", box});
    CHECK(run.folders_read.size() == 2);
    REQUIRE(run.messages.size() == 3);
    CHECK_THAT(run.messages[0], Contains("warning: a.dae: it names ") && Contains("/no.png, which is not there"));
    CHECK(run.messages[1] == "a.dae: read by Blender 9.9, " + (blender.folder.path() / "blender").string());
}

TEST_CASE("a model that Blender cannot convert is refused with what to do", "[scan.mesh]")
{
    CHECK_THAT(FakeBlender("").error(), Contains("a.dae: .dae files are read by Blender, and no program \"blender\" is in PATH; "
                                                 "install it, or save the model as .glb"));
    CHECK_THAT(FakeBlender("echo fresco: version 1.2\necho fresco: no importer\n").error(),
               Contains("a.dae: Blender 1.2 (") && Contains("has no importer for .dae files; install one that has"));
    CHECK_THAT(FakeBlender("echo fresco: version 1.2\necho why >&2\nexit 1\n").error(),
               Contains("a.dae: Blender 1.2 cannot read it: it ended with exit code 1, or save") && Contains("| why"));
    CHECK_THAT(FakeBlender("kill -SEGV $$\n").error(), Contains("Segmentation fault (signal 11)"));
    const FakeBlender bad("echo no model >\"$glb\"\n");
    CHECK_THAT(bad.error(), Contains((bad.folder.path() / "a.dae").string() + ": ") && !Contains("model.glb"));
    const FakeBlender slow("sleep 100\n");
    TestRun run;
    run.cancel_after(1);
    CHECK_THROWS_AS(slow.read(run), Canceled);
}
