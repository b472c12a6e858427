#include "catch.h"
#include "usdz.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

using namespace fresco;
using Catch::Contains;

namespace
{
using Contents = std::vector<std::pair<std::string, std::string>>;

std::string packed(const Contents& contents)
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.usdz";
    ZipWriter zip(file);
    for (const auto& [name, data] : contents)
    {
        zip.begin(name);
        for (std::size_t at = 0; at < data.size(); at += 7)
            zip.write(std::string_view(data).substr(at, 7));
    }
    zip.finish();
    return read_text_file(file);
}
}  // namespace

TEST_CASE("every file of a package begins at a multiple of 64 bytes, whatever the lengths of names and data")
{
    Contents contents;
    for (std::size_t length = 0; length < 140; ++length)
        contents.emplace_back("n" + std::string(length, 'x'), std::string(length * 3 % 200, static_cast<char>(length)));
    const std::string package = packed(contents);
    const std::vector<UsdzEntry> entries = read_usdz(package, "a.usdz");
    REQUIRE(entries.size() == contents.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
    {
        CHECK(entries[i].name == contents[i].first);
        CHECK(entries[i].data == contents[i].second);
        CHECK(static_cast<std::size_t>(entries[i].data.data() - package.data()) % 64 == 0);
    }
    CHECK(packed(contents) == package);
}

TEST_CASE("the first bytes of a package are those of the specification")
{
    using namespace std::string_literals;
    const std::string package = packed({{"a", "123456789"}});
    // The checksum of these digits is known: CBF43926.
    const std::string header = "PK\3\4\x0a\0\0\0\0\0\0\0\x21\0\x26\x39\xf4\xcb\x09\0\0\0\x09\0\0\0\1\0\x21\0"s;
    CHECK(package.substr(0, 30) == header);
    CHECK(package.substr(30, 5) == "a\x86\x19\x1d\0"s);
    CHECK(package.substr(64, 9) == "123456789");
    CHECK(package.size() == 64 + 9 + 46 + 1 + 22);
}

TEST_CASE("a package that was changed or cut is refused")
{
    const std::string package = packed({{"room.usda", "text"}, {"picture.png", std::string(100, 'p')}});
    const std::vector<UsdzEntry> entries = read_usdz(package, "a.usdz");
    for (std::size_t length = 0; length < package.size(); ++length)
        CHECK_THROWS_WITH(read_usdz(package.substr(0, length), "a.usdz"), Contains("a.usdz: "));
    CHECK_THROWS_AS(read_usdz(package + "x", "a.usdz"), Error);
    std::size_t unnoticed = 0;
    for (std::size_t at = 0; at < package.size(); ++at)
    {
        std::string changed = package;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        try
        {
            if (read_usdz(changed, "a.usdz").at(1).data == entries[1].data)
                ++unnoticed;
        }
        catch (const Error&)
        {
            continue;
        }
    }
    // Padding, and in the directory and its end the versions, attributes, numbers of disks and comments.
    const std::size_t padding = 64 - 30 - 9 - 2 + 192 - (64 + 4 + 30 + 11) - 2;
    CHECK(unnoticed <= padding + 2 * (2 + 12) + 6);
}

TEST_CASE("a full disk is an error that names the file")
{
    CHECK_THROWS_WITH(ZipWriter("/gone/a.usdz"), Contains("/gone/a.usdz: cannot be written: "));
    if (!std::filesystem::exists("/dev/full"))
        return;
    const auto fill = []
    {
        ZipWriter zip("/dev/full");
        zip.begin("a");
        zip.write(std::string(1 << 20, 'a'));
        zip.finish();
    };
    CHECK_THROWS_WITH(fill(), Contains("No space left on device"));
}
