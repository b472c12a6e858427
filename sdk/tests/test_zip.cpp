#include "cut_bytes.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/zip.h>

#include <algorithm>

using namespace fresco;
using Catch::Contains;

namespace
{
using Contents = std::vector<std::pair<std::string, std::string>>;

std::string packed(const Contents& contents)
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.zip";
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

std::string_view text_of(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

ZipReader opened(const std::string& archive)
{
    return {std::as_bytes(std::span(archive)), "a.zip"};
}
}  // namespace

TEST_CASE("Every file of a zip archive begins at a multiple of 64 bytes, whatever the lengths of names and data")
{
    Contents contents;
    for (std::size_t length = 0; length < 140; ++length)
        contents.emplace_back("n" + std::string(length, 'x'), std::string(length * 3 % 200, static_cast<char>(length)));
    const std::string archive = packed(contents);
    const ZipReader reader = opened(archive);
    CHECK(reader.names().size() == contents.size());
    for (const auto& [name, data] : contents)
    {
        const auto found = reader.contents(name);
        CHECK(text_of(found) == data);
        CHECK((found.data() - std::as_bytes(std::span(archive)).data()) % 64 == 0);
    }
    CHECK_THROWS_WITH(reader.contents("gone"), Contains("a.zip: the archive lacks the entry 'gone'"));
}

TEST_CASE("A zip archive that was changed or cut is refused, or still holds what was written")
{
    const std::string text(100, 'p');
    const std::string archive = packed({{"room.usda", "text"}, {"picture.png", text}});
    check_cuts_are_refused(std::as_bytes(std::span(archive)), "a.zip: byte ", [](const auto& cut) { ZipReader(cut, "a.zip"); });
    CHECK_THROWS_AS(opened(archive + "x"), Error);
    std::size_t noticed = 0;
    for (std::size_t at = 0; at < archive.size(); ++at)
    {
        std::string changed = archive;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        std::string_view found = text;
        noticed += testing::error_of([&] { found = text_of(opened(changed).contents("picture.png")); }).empty() ? 0 : 1;
        CHECK(found == text);
    }
    CHECK(noticed > text.size());
}

TEST_CASE("ZipWriter: a full disk is an error that names the file")
{
    CHECK_THROWS_WITH(ZipWriter("/gone/a.zip"), Contains("/gone/a.zip: cannot be written: "));
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
