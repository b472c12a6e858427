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
    again.move({"a/b.npy"}, folder.path() / "to");
    CHECK(read_text_file(folder.path() / "to/a/b.npy") == "1234");
    CHECK_FALSE(again.find(3));
    CHECK_THROWS_WITH(again.move({"a/b.npy"}, folder.path() / "to"), Catch::Contains("a/b.npy: cannot be written"));
}
