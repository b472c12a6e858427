#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/run_context.h>
#include <fresco/testing.h>

using namespace fresco;
namespace fs = std::filesystem;

TEST_CASE("a piece is kept while its note and all its files are whole, whether the result that has it was published or not")
{
    testing::TestRun run;
    const KeptPieces kept(run);
    CHECK_FALSE(kept.find(3));
    fs::create_directories(kept.folder() / "a");
    write_file(kept.folder() / "a/b.npy", "12345");
    kept.note(3, {"a/b.npy"}, Value::Map{{"sharpness", 0.1}});
    const KeptPieces again(run);
    REQUIRE(again.find(3));
    CHECK(again.find(3)->at("sharpness").as_double() == 0.1);
    CHECK_FALSE(again.find(4));
    CHECK(run.messages.empty());
    const testing::TemporaryFolder folder;
    // Twice to the same place.
    for (const char* place : {"lost", "to", "to"})
    {
        kept.link({"a/b.npy"}, folder.path() / place);
        CHECK(read_text_file(folder.path() / place / "a/b.npy") == "12345");
        CHECK(kept.find(3));
    }
    fs::remove_all(folder.path() / "lost");
    const fs::path note = run.checkpoint_folder() / "piece_3.json";
    const std::string whole = read_text_file(note);

    std::string flipped = whole;
    flipped[flipped.find("0.1")] = '1';
    const auto refused = [&](std::size_t piece)
    {
        run.messages.clear();
        CHECK_FALSE(again.find(piece));
        REQUIRE(run.messages.size() == 1);
        CHECK_THAT(run.messages[0], StartsWith("warning: a finished piece is made again: "));
    };
    write_file(run.checkpoint_folder() / "piece_4.json", whole);
    refused(4);
    write_file(note, flipped);
    refused(3);
    write_file(note, whole);
    write_file(kept.folder() / "a/b.npy", "12346");
    refused(3);
    fs::remove(kept.folder() / "a/b.npy");
    refused(3);
    CHECK(read_text_file(folder.path() / "to/a/b.npy") == "12345");
    CHECK_THROWS_WITH(kept.link({"a/b.npy"}, folder.path() / "to"), Contains("a/b.npy: cannot be written"));
}
