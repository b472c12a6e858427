#include "cut_bytes.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/zip.h>

#include <algorithm>
#include <cstring>
#include <zlib.h>

using namespace fresco;

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

/// An archive of one file that is packed by deflate.
std::string deflated(const std::string& name, const std::string& data)
{
    const auto* bytes = reinterpret_cast<const Bytef*>(data.data());
    const auto count = static_cast<uLong>(data.size());
    uLong size = compressBound(count);
    std::string stream(size, '\0');
    REQUIRE(compress2(reinterpret_cast<Bytef*>(stream.data()), &size, bytes, count, Z_BEST_COMPRESSION) == Z_OK);
    // zlib's own header and checksum are left out; what the archive says about the stored file becomes true of the packed one.
    std::string archive = packed({{name, stream.substr(2, size - 6)}});
    const auto put = [&](std::size_t at, std::uint64_t value, std::size_t width)
    { std::memcpy(archive.data() + at, &value, width); };
    for (const std::size_t at : {archive.find("PK\3\4") + 8, archive.find("PK\1\2") + 10})
    {
        put(at, Z_DEFLATED, 2);
        put(at + 6, crc32(0, bytes, static_cast<uInt>(count)), 4);
        put(at + 14, count, 4);
    }
    return archive;
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

TEST_CASE("Files that are packed by deflate are read in full or refused")
{
    std::string text;
    for (int i = 0; i < 300; ++i)
        text += "row " + std::to_string(i * i) + "\n";
    const std::string archive = deflated("rgbd/0.conf", text);
    const ZipReader reader = opened(archive);
    CHECK(text_of(reader.unpacked("rgbd/0.conf", text.size())) == text);
    CHECK(opened(deflated("empty", "")).unpacked("empty", 10).empty());
    CHECK_THROWS_WITH(reader.unpacked("rgbd/0.conf", text.size() - 1), Contains("bytes; expected at most"));
    CHECK_THROWS_WITH(reader.contents("rgbd/0.conf"), Contains("is compressed; expected it stored"));
    for (std::size_t at = 0; at < archive.size(); ++at)
    {
        std::string changed = archive;
        changed[at] = static_cast<char>(changed[at] ^ 4);
        std::string found = text;
        testing::error_of([&] { found = text_of(opened(changed).unpacked("rgbd/0.conf", std::size_t{1} << 30U)); });
        CHECK(found == text);
    }
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
