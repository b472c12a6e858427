#include "catch.h"

#include <fresco/checked_file.h>
#include <fresco/copy_file.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>
#include <fresco/testing.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <sys/resource.h>
#include <sys/stat.h>
#include <thread>

using Catch::Contains;

TEST_CASE("A FIFO or a folder in a file's place is refused, not waited for")
{
    const fresco::testing::TemporaryFolder folder;
    const auto fifo = folder.path() / "mesh.ply";
    REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
    CHECK_THROWS_WITH(fresco::file_hash(fifo), Contains("mesh.ply") && Contains("not a regular file"));
    CHECK_THROWS_WITH(fresco::read_file(fifo), Contains("mesh.ply") && Contains("not a regular file"));
    CHECK_THROWS_WITH(fresco::file_hash(folder.path()), Contains("not a regular file"));
    CHECK_THROWS_WITH(fresco::file_hash(folder.path() / "nothing"), Contains("cannot be read"));
}

TEST_CASE("write_file is whole or not at all, and says why not")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.txt";
    fresco::write_file(file, "one");
    CHECK(fresco::read_text_file(file) == "one");
    CHECK_THROWS_WITH(fresco::write_file(folder.path() / "no" / "b.txt", "two"), Contains("b.txt"));

    // A full disk, as the file size limit shows it.
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1024, before.rlim_max};
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    CHECK_THROWS_WITH(fresco::write_file(file, std::string(5000, 'x')), Contains("a.txt") && Contains("cannot be written"));
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    CHECK(fresco::read_text_file(file) == "one");
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("Files beside the one that is written stay, whatever their names")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.txt";
    for (const char* name : {"a.txt.tmp", "a.txt~", ".a.txt"})
        std::ofstream(folder.path() / name) << "mine";
    fresco::write_file(file, "one");
    fresco::write_file(file, "two");
    CHECK(fresco::read_text_file(file) == "two");
    for (const char* name : {"a.txt.tmp", "a.txt~", ".a.txt"})
        CHECK(fresco::read_text_file(folder.path() / name) == "mine");
}

TEST_CASE("A file that is written has no name yet, so that a killed writer leaves nothing")
{
    const fresco::testing::TemporaryFolder folder;
    fresco::write_file(folder.path() / "from", "text");
    const fresco::FileCopy copy{folder.path() / "from", folder.path() / "to"};
    fresco::copy_files({&copy, 1}, [&] { CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1); });
    CHECK(fresco::read_text_file(folder.path() / "to") == "text");
}

TEST_CASE("A checked file is read back, and damage to it is named")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "state";
    for (const std::string text : {"", "0", "a longer text"})
    {
        fresco::write_checked(file, text);
        CHECK(fresco::read_checked_text(file) == text);
        const std::string whole = fresco::read_text_file(file);
        for (std::size_t at = 0; at < whole.size(); ++at)
        {
            std::string flipped = whole;
            flipped[at] = static_cast<char>(flipped[at] ^ 4);
            fresco::write_file(file, flipped);
            CHECK_THROWS_WITH(fresco::read_checked(file), Contains("state: is damaged"));
            fresco::write_file(file, whole.substr(0, at));
            CHECK_THROWS_WITH(fresco::read_checked(file), Contains("state: is damaged"));
        }
    }
    CHECK_THROWS_AS(fresco::read_checked(folder.path() / "none"), fresco::MissingInput);
}

TEST_CASE("Of several writers of one file one is last, and nothing is mixed or left")
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.txt";
    // Enough of them that one is overtaken many times in a row.
    std::atomic<int> refused{0};
    std::vector<std::thread> writers;
    for (int writer = 0; writer < 16; ++writer)
    {
        writers.emplace_back(
            [&file, &refused, writer]
            {
                const std::string own(static_cast<std::size_t>(1000 * (writer + 1)), static_cast<char>('a' + writer));
                for (int i = 0; i < 200; ++i)
                {
                    try
                    {
                        fresco::write_file(file, own);
                    }
                    catch (const std::exception&)
                    {
                        ++refused;
                    }
                }
            });
    }
    for (auto& writer : writers)
        writer.join();
    CHECK(refused == 0);
    const std::string text = fresco::read_text_file(file);
    REQUIRE_FALSE(text.empty());
    CHECK(text == std::string(static_cast<std::size_t>(1000 * (text[0] - 'a' + 1)), text[0]));
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("A copy is whole or not at all, and is called out before it is in place")
{
    const fresco::testing::TemporaryFolder folder;
    const auto copy_file = [](const auto& from, const auto& to, const std::function<void()>& written = {})
    {
        const fresco::FileCopy copy{from, to};
        fresco::copy_files({&copy, 1}, written);
    };
    const auto from = folder.path() / "from";
    const auto to = folder.path() / "to";
    const std::string text = std::string(3'000'001, 'x') + "end";
    fresco::write_file(from, text);
    fresco::write_file(to, "before");
    copy_file(from, to, [&] { CHECK(fresco::read_text_file(to) == "before"); });
    CHECK(fresco::read_text_file(to) == text);
    CHECK_THROWS_WITH(copy_file(from, to, [] { throw fresco::Error("no more"); }), Contains("no more"));
    CHECK_THROWS_WITH(copy_file(folder.path() / "none", to), Contains("none: cannot be opened"));
    CHECK_THROWS_WITH(copy_file(folder.path(), to), Contains("cannot be read"));
    CHECK_THROWS_WITH(copy_file(from, folder.path() / "no" / "to"), Contains("no/to: cannot be written"));
    CHECK(fresco::read_text_file(to) == text);
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("Many copies are made together: none is in place before all are written")
{
    const fresco::testing::TemporaryFolder folder;
    std::vector<fresco::FileCopy> copies;
    for (int i = 0; i < 20; ++i)
    {
        const std::string name = std::to_string(i);
        std::filesystem::create_directory(folder.path() / name);
        fresco::write_file(folder.path() / name / "from", name);
        copies.push_back({folder.path() / name / "from", folder.path() / name / "to"});
    }
    fresco::copy_files(copies,
                       [&]
                       {
                           for (const auto& copy : copies)
                               CHECK_FALSE(std::filesystem::exists(copy.to));
                       });
    for (int i = 0; i < 20; ++i)
        CHECK(fresco::read_text_file(copies[static_cast<std::size_t>(i)].to) == std::to_string(i));
    fresco::copy_files({});

    fresco::write_file(copies[0].from, "other");
    copies.push_back({folder.path() / "none", folder.path() / "to"});
    CHECK_THROWS_WITH(fresco::copy_files(copies), Contains("none: cannot be opened"));
    CHECK(fresco::read_text_file(copies[0].to) == "0");
}

TEST_CASE("Missing and special files are named")
{
    const fresco::testing::TemporaryFolder folder;
    CHECK_THROWS_AS(fresco::read_file(folder.path() / "none"), fresco::MissingInput);
    CHECK_THROWS_WITH(fresco::read_file(folder.path()), Contains("regular file"));
    fresco::write_file(folder.path() / "big", std::string(100, 'x'));
    CHECK_THROWS_WITH(fresco::read_file(folder.path() / "big", 99), Contains("100 bytes"));
}
