#include "catch.h"

#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files_io.h>
#include <fresco/parallel.h>
#include <fresco/testing.h>

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <functional>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace fresco;
using Catch::Contains;
using fresco::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace
{

void write_plainly(const fs::path& file, const std::string& text)
{
    std::ofstream(file) << text;
}

/// A guarded folder `own` beside somebody else's files in `home`.
struct Neighbors
{
    TemporaryFolder folder;
    fs::path own = folder.path() / "own";
    fs::path home = folder.path() / "home";

    Neighbors()
    {
        fs::create_directories(own / "sub");
        fs::create_directories(home / "sub");
        write_plainly(home / "thesis", "mine");
        write_plainly(home / "sub" / "thesis", "mine");
        forbid_links_below(own, "remove it, or choose another");
    }
    void check_home() const
    {
        std::size_t count = 0;
        for (const auto& entry : fs::recursive_directory_iterator(home))
            count += entry.is_regular_file() ? 1 : 0;
        CHECK(count == 2);
        CHECK(read_text_file(home / "thesis") == "mine");
        CHECK(read_text_file(home / "sub" / "thesis") == "mine");
    }
};

}  // namespace

TEST_CASE("write_file is whole or not at all, says why not, and touches no other file")
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.txt";
    for (const char* name : {"a.txt.tmp", "a.txt~", ".a.txt"})
        write_plainly(folder.path() / name, "mine");
    write_file(file, "zero");
    write_file(file, "one");
    CHECK(read_text_file(file) == "one");
    CHECK_THROWS_WITH(write_file(folder.path() / "no" / "b.txt", "two"), Contains("b.txt"));

    // A full disk, as the file size limit shows it.
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1024, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    CHECK_THROWS_WITH(write_file(file, std::string(5000, 'x')), Contains("a.txt") && Contains("cannot be written"));
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    CHECK(read_text_file(file) == "one");
    CHECK(entries_of(folder.path()).size() == 4);
    for (const char* name : {"a.txt.tmp", "a.txt~", ".a.txt"})
        CHECK(read_text_file(folder.path() / name) == "mine");
}

TEST_CASE("A checked file is read back, and damage to it is named")
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "state";
    for (const std::string text : {"", "a longer text"})
    {
        write_checked(file, text);
        CHECK(read_checked_text(file) == text);
        const std::string whole = read_text_file(file);
        for (std::size_t at = 0; at < whole.size(); ++at)
        {
            std::string flipped = whole;
            flipped[at] = static_cast<char>(flipped[at] ^ 4);
            for (const std::string& damaged : {flipped, whole.substr(0, at)})
            {
                write_file(file, damaged);
                CHECK_THROWS_WITH(read_checked(file), Contains("state: is damaged"));
            }
        }
    }
    CHECK_THROWS_AS(read_checked(folder.path() / "none"), MissingInput);
}

TEST_CASE("Of several writers of one file one is last, and nothing is mixed or left")
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.txt";
    const auto own = [](std::size_t writer) { return std::string(1000 * (writer + 1), static_cast<char>('a' + writer)); };
    // Enough of them that one is overtaken many times in a row.
    parallel_for(16, 1, 16,
                 [&](std::size_t writer, std::size_t)
                 {
                     for (int i = 0; i < 200; ++i)
                         write_file(file, own(writer));
                 });
    const std::string text = read_text_file(file);
    REQUIRE_FALSE(text.empty());
    CHECK(text == own(static_cast<std::size_t>(text[0] - 'a')));
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("Copies are made together: none has a name before all are written, and a failure leaves what was there")
{
    const TemporaryFolder folder;
    std::vector<FileCopy> copies;
    for (int i = 0; i < 20; ++i)
    {
        const fs::path own = folder.path() / std::to_string(i);
        fs::create_directory(own);
        write_file(own / "from", i == 7 ? std::string(3'000'001, 'x') + "end" : std::to_string(i));
        copies.push_back({own / "from", own / "to"});
    }
    write_file(copies[0].to, "before");
    copy_files(copies,
               [&]
               {
                   CHECK(read_text_file(copies[0].to) == "before");
                   for (std::size_t i = 1; i < copies.size(); ++i)
                       CHECK(entries_of(copies[i].to.parent_path()).size() == 1);
               });
    for (const FileCopy& copy : copies)
        CHECK(read_text_file(copy.to) == read_text_file(copy.from));
    copy_files({});

    write_file(copies[0].from, "other");
    const auto refused = [&](const FileCopy& last, const std::string& reason) {
        CHECK_THROWS_WITH(copy_files(std::vector{copies[0], last}), Contains(reason));
    };
    refused({folder.path() / "none", folder.path() / "to"}, "none: cannot be opened");
    refused({folder.path(), folder.path() / "to"}, "reading failed");
    refused({copies[1].from, folder.path() / "no" / "to"}, "no/to: cannot be written");
    CHECK_THROWS_WITH(copy_files(copies, [] { throw Error("no more"); }), Contains("no more"));
    CHECK(read_text_file(copies[0].to) == "0");
    CHECK(entries_of(folder.path()).size() == copies.size());
}

TEST_CASE("Missing, special and too large files are named, and a FIFO is not waited for")
{
    const TemporaryFolder folder;
    const auto fifo = folder.path() / "mesh.ply";
    REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
    for (const fs::path& special : {fifo, folder.path()})
    {
        CHECK_THROWS_WITH(file_hash(special), Contains("not a regular file"));
        CHECK_THROWS_WITH(read_file(special), Contains("not a regular file"));
    }
    CHECK_THROWS_WITH(file_hash(folder.path() / "none"), Contains("cannot be opened"));
    CHECK_THROWS_AS(read_file(folder.path() / "none"), MissingInput);
    write_file(folder.path() / "big", std::string(100, 'x'));
    CHECK_THROWS_WITH(read_file(folder.path() / "big", 99), Contains("100 bytes"));
}

TEST_CASE("Below a guarded folder no link is followed by whatever opens, makes, lists or removes")
{
    const Neighbors place;
    SECTION("a link in place of a folder")
    {
        fs::create_directory_symlink(place.home, place.own / "link");
        const fs::path through = place.own / "link" / "thesis";
        const auto refusal = Contains("own/link: is a symbolic link in place of a folder: remove it, or choose another");
        CHECK_THROWS_WITH(open_file(through, O_WRONLY | O_TRUNC), refusal);
        CHECK_THROWS_WITH(read_file(through), refusal);
        CHECK_THROWS_WITH(write_file(through, "other"), refusal);
        CHECK_THROWS_WITH(make_folder(place.own / "link" / "new"), refusal);
        CHECK_THROWS_WITH(make_folder(place.own / "link"), refusal);
        CHECK_THROWS_WITH(entries_of(place.own / "link"), refusal);
        CHECK_THROWS_WITH(remove_path(through), refusal);
        CHECK_THROWS_WITH(rename_path(place.own / "sub", through), refusal);
        CHECK_THROWS_WITH(make_link("x", through), refusal);
        CHECK_THROWS_WITH(sync_folder(place.own / "link"), refusal);
        CHECK(!path_status(through));
        CHECK(!is_folder(place.own / "link"));
        // The link itself goes, not what it leads to.
        CHECK(remove_path(place.own / "link"));
    }
    SECTION("a link in place of a file")
    {
        const fs::path link = place.own / "link";
        fs::create_symlink(place.home / "thesis", link);
        const auto refusal = Contains("own/link: is a symbolic link in place of a file: remove it, or choose another");
        CHECK_THROWS_WITH(open_file(link, O_WRONLY | O_TRUNC), refusal);
        CHECK_THROWS_WITH(read_file(link), refusal);
        CHECK(!is_file(link));
        // A whole file takes the link's place.
        write_file(link, "other");
        CHECK(read_text_file(link) == "other");
        // A link to nothing makes no file elsewhere.
        fs::create_symlink(place.home / "new", place.own / "nowhere");
        CHECK_THROWS_WITH(open_file(place.own / "nowhere", O_RDWR | O_CREAT), Contains("symbolic link"));
    }
    SECTION("a hard link, and a way out")
    {
        CHECK_THROWS_WITH(write_file(place.own / ".." / "home" / "thesis", "other"), Contains("leads out of its folder by '..'"));
        fs::create_hard_link(place.home / "thesis", place.own / "hard");
        CHECK_THROWS_WITH(open_file(place.own / "hard", O_WRONLY | O_TRUNC),
                          Contains("own/hard: has a second name, a hard link"));
        CHECK(read_text_file(place.own / "hard") == "mine");
    }
    SECTION("other things in place of a file are named, and not waited for")
    {
        REQUIRE(mkfifo((place.own / "fifo").c_str(), 0600) == 0);
        for (const int flags : {O_RDONLY, O_WRONLY, O_RDWR | O_CREAT})
        {
            CHECK_THROWS_WITH(open_file(place.own / "fifo", flags), Contains("fifo: is a FIFO in place of a file: remove it"));
            CHECK_THROWS_WITH(open_file(place.own / "sub", flags), Contains("sub: is a folder in place of a file: remove it"));
        }
        CHECK_THROWS_WITH(make_folder(place.own / "fifo" / "x"), Contains("fifo: is a FIFO in place of a folder: remove it"));
        CHECK_THROWS_WITH(write_file(place.own / "sub", "x"), Contains("sub"));
    }
    SECTION("a tree is removed, and not what its links lead to")
    {
        fs::create_directories(place.own / "tree" / "deep");
        fs::create_directory_symlink(place.home, place.own / "tree" / "deep" / "link");
        fs::create_symlink(place.home / "thesis", place.own / "tree" / "file");
        CHECK(remove_path(place.own / "tree"));
        CHECK(!fs::exists(fs::symlink_status(place.own / "tree")));
        CHECK(remove_path(place.own / "tree"));
    }
    place.check_home();
}

TEST_CASE("Links to a guarded folder are the user's, and followed")
{
    const Neighbors place;
    const fs::path link = place.folder.path() / "link";
    fs::create_directory_symlink(place.home, link);
    forbid_links_below(link / "store", "remove it, or choose another");
    make_folder(link / "store" / "keys");
    write_file(link / "store" / "keys" / "a", "text");
    CHECK(read_text_file(place.home / "store" / "keys" / "a") == "text");
    CHECK(entries_of(link / "store") == std::vector<fs::path>{link / "store" / "keys"});
    // By its other name, too.
    fs::create_directory_symlink(place.own, place.home / "store" / "logs");
    CHECK_THROWS_WITH(write_file(place.home / "store" / "logs" / "a", "text"), Contains("store/logs: is a symbolic link"));
    CHECK_THROWS_WITH(write_file(link / "store" / "logs" / "a", "text"), Contains("store/logs: is a symbolic link"));
    // Elsewhere links are followed as usual.
    make_folder(link / "new");
    CHECK(fs::is_directory(place.home / "new"));
    CHECK(read_text_file(link / "thesis") == "mine");
}
