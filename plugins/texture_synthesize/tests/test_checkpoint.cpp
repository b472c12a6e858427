#include "catch.h"
#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <fstream>
#include <span>

using namespace fresco;
using namespace fresco::synthesize;

namespace
{

Checkpoint sample(std::size_t colors, std::size_t matches)
{
    Checkpoint result{2, 5, {}, {}, {1, 2.5F}};
    for (std::size_t i = 0; i < colors; ++i)
        result.colors.push_back({static_cast<float>(i), -1, 0.5F});
    for (std::size_t i = 0; i < matches; ++i)
        result.matches.push_back({{3, static_cast<float>(i)}, 7.25F});
    return result;
}

/// What reading damaged bytes comes to: an error that names the file, or nothing.
bool is_refused(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    try
    {
        return !read_checkpoint(file);
    }
    catch (const Error& error)
    {
        return std::string(error.what()).find(file.string()) != std::string::npos;
    }
}

}  // namespace

TEST_CASE("a checkpoint comes back as it was written")
{
    testing::TemporaryFolder folder;
    const auto file = folder.path() / "round.bin";
    CHECK_FALSE(read_checkpoint(file));
    for (const auto& [colors, matches] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{0, 3}, std::pair{200, 17}})
    {
        const Checkpoint written = sample(static_cast<std::size_t>(colors), static_cast<std::size_t>(matches));
        write_checkpoint(file, written);
        const auto read = read_checkpoint(file);
        REQUIRE(read);
        CHECK(read->level == 2);
        CHECK(read->rounds == 5);
        CHECK(read->colors == written.colors);
        CHECK(read->crowding == written.crowding);
        CHECK(std::ranges::equal(read->matches, written.matches,
                                 [](const Match& a, const Match& b) { return a.at == b.at && a.distance == b.distance; }));
    }
    CHECK_THROWS_WITH(write_checkpoint(folder.path() / "no" / "such" / "round.bin", sample(1, 1)), Catch::Contains("round.bin"));
}

TEST_CASE("a damaged checkpoint is refused by name")
{
    testing::TemporaryFolder folder;
    const auto file = folder.path() / "round.bin";
    write_checkpoint(file, sample(3, 2));
    std::vector<std::byte> bytes = read_file(file);
    std::size_t read = 0;
    for (std::size_t length = 0; length < bytes.size(); ++length)
        read += !is_refused(file, std::span(bytes).first(length));
    CHECK(read == 0);
    for (std::size_t i = 0; i < bytes.size(); ++i)
    {
        const std::byte whole = bytes[i];
        bytes[i] ^= static_cast<std::byte>(1U << i % 8);
        read += !is_refused(file, bytes);
        bytes[i] = whole;
    }
    CHECK(read == 0);
    bytes.push_back(std::byte{0});
    CHECK(is_refused(file, bytes));
    bytes.pop_back();
    CHECK_FALSE(is_refused(file, bytes));
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    CHECK_THROWS_WITH(read_checkpoint(file), Catch::Contains("round.bin"));
}
