#include <fresco/files_io.h>
#include <fresco/kept_pieces.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

using namespace fresco;
namespace fs = std::filesystem;

TEST_CASE("a piece is kept while all its files have their sizes")
{
    const testing::TemporaryFolder folder;
    const KeptPieces kept(folder.path());
    CHECK_FALSE(kept.find(3));
    fs::create_directories(kept.folder() / "a");
    write_file(kept.folder() / "a/b.npy", "12345");
    kept.note(3, {"a/b.npy"}, Value::Map{{"sharpness", 0.1}});
    const KeptPieces again(folder.path());
    REQUIRE(again.find(3));
    CHECK(again.find(3)->at("sharpness").as_double() == 0.1);
    CHECK_FALSE(again.find(4));
    write_file(kept.folder() / "a/b.npy", "1234");
    CHECK_FALSE(again.find(3));
}

TEST_CASE("pieces are there still when the result that has them was not published")
{
    const testing::TemporaryFolder folder;
    const KeptPieces kept(folder.path());
    fs::create_directories(kept.folder() / "a");
    write_file(kept.folder() / "a/b.npy", "12345");
    kept.note(3, {"a/b.npy"}, Value::Map{});
    // Twice to the same place.
    for (const char* place : {"lost", "to", "to"})
    {
        kept.link({"a/b.npy"}, folder.path() / place);
        CHECK(read_text_file(folder.path() / place / "a/b.npy") == "12345");
        CHECK(kept.find(3));
    }
    fs::remove_all(folder.path() / "lost");
    fs::remove_all(kept.folder());
    CHECK(read_text_file(folder.path() / "to/a/b.npy") == "12345");
    CHECK_THROWS_WITH(kept.link({"a/b.npy"}, folder.path() / "to"), Catch::Contains("a/b.npy: cannot be written"));
}
