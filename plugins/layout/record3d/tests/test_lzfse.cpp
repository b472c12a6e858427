#include "catch.h"
#include "lzfse.h"
#include "lzfse_packer.h"
#include "shared_data.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <cstring>
#include <filesystem>

namespace
{

using namespace record3d::testing;

Text unpacked(const Text& packed, std::size_t size)
{
    const auto bytes = record3d::unpack_lzfse(std::as_bytes(std::span(packed)), size, "a.depth");
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Matches of all lengths and distances, and what they give.
struct Sample
{
    Text raw, literals;
    std::vector<Match> matches;
};

Sample sample(std::uint64_t seed)
{
    fresco::Random random(seed);
    Sample result;
    std::uint32_t last = 0;
    for (int i = 0; i < 400; ++i)
    {
        Match match{static_cast<std::uint32_t>(random.below(i % 50 == 0 ? 316 : 6)), 0, 0};
        for (std::uint32_t k = 0; k < match.literals; ++k)
            result.literals += static_cast<char>('a' + random.below(2) * random.below(26));
        result.raw += result.literals.substr(result.literals.size() - match.literals);
        if (!result.raw.empty())
        {
            match.repeat = static_cast<std::uint32_t>(random.below(i % 90 == 0 ? 2360 : 12));
            match.distance = last > 0 && i % 3 == 0 ? 0 : 1 + static_cast<std::uint32_t>(random.below(std::ssize(result.raw)));
            last = match.distance > 0 ? match.distance : last;
            for (std::uint32_t k = 0; k < match.repeat; ++k)
                result.raw += result.raw[result.raw.size() - last];
        }
        result.matches.push_back(match);
    }
    const std::size_t more = (4 - result.literals.size() % 4) % 4;
    result.literals += Text(more, 'z');
    result.raw += Text(more, 'z');
    result.matches.push_back({static_cast<std::uint32_t>(more), 0, 0});
    return result;
}

}  // namespace

TEST_CASE("blocks of every kind give what was packed", "[layout.record3d]")
{
    Text packed, raw;
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
    {
        const Sample it = sample(seed);
        packed += entropy_block(it.raw.size(), it.literals, it.matches) + stored_block("stored");
        raw += it.raw + "stored";
    }
    // Each operation: 3 literals and 6 bytes from 3 back; a long distance; a medium one; the one before; literals; a repetition.
    const Text operations = Text("\xE3"
                                 "abc",
                                 4) +
                            Text("\x98\x03"
                                 "de",
                                 4) +
                            Text("\x0F\x08\0", 3) +
                            Text("\xA8\x1C\0"
                                 "x",
                                 4) +
                            Text("\x46"
                                 "y",
                                 2) +
                            Text("\xF2", 1) + Text("\x0E", 1) + Text("\xE0\0", 2) + Text(16, 'l') + Text("\xF0\0", 2);
    Text bytes;
    const auto repeat = [&](std::size_t distance, std::size_t count)
    {
        for (std::size_t i = 0; i < count; ++i)
            bytes += bytes[bytes.size() - distance];
    };
    bytes += "abc";
    bytes += "de";
    repeat(3, 6);
    repeat(8, 4);
    bytes += "x";
    repeat(7, 3);
    bytes += "y";
    repeat(7, 3);
    repeat(7, 2);
    bytes += Text(16, 'l');
    repeat(7, 16);
    packed += byte_block(bytes.size(), operations) + "bvx$";
    raw += bytes;
    CHECK(unpacked(packed, raw.size()) == raw);
}

TEST_CASE("damaged LZFSE data are refused, or give the size that was asked for", "[layout.record3d]")
{
    const Sample it = sample(3);
    const Text good = entropy_block(it.raw.size(), it.literals, it.matches) + stored_block("end") + "bvx$";
    const std::size_t size = it.raw.size() + 3;
    REQUIRE(unpacked(good, size).size() == size);
    for (std::size_t count = 0; count < good.size(); count += 7)
        CHECK_THROWS_AS(unpacked(good.substr(0, count), size), fresco::Error);
    fresco::Random random(5);
    for (int i = 0; i < 3000; ++i)
    {
        Text bad = good;
        bad[static_cast<std::size_t>(random.below(std::ssize(bad)))] ^= static_cast<char>(1 + random.below(255));
        try
        {
            const auto found = unpacked(bad, size).size();
            CHECK(found == size);
        }
        catch (const fresco::Error& error)
        {
            CHECK_THAT(error.what(), Contains("a.depth"));
        }
    }
    const auto error = [](const Text& packed, std::size_t expected)
    {
        try
        {
            unpacked(packed, expected);
        }
        catch (const fresco::Error& refused)
        {
            return Text(refused.what());
        }
        return Text("no error");
    };
    CHECK_THAT(error(good, size - 1), Contains("more than the " + std::to_string(size - 1) + " bytes that were expected"));
    CHECK_THAT(error(good, size + 1), Contains(std::to_string(size) + " bytes; expected " + std::to_string(size + 1)));
    CHECK_THAT(error(stored_block("a") + "bvx1", 1), Contains("byte offset 9: expected a block of LZFSE"));
    CHECK_THAT(error(stored_block("a") + "bvx$ ", 1), Contains("a.depth"));
    CHECK_THAT(error(byte_block(3, Text("\xE1"
                                        "a\xF2",
                                        3)) +
                         "bvx$",
                     3),
               Contains("before the beginning"));
    CHECK_THAT(error(byte_block(3, "\x70") + "bvx$", 3), Contains("the unknown operation 0x70"));
    CHECK_THAT(error(byte_block(3, Text("\xE2"
                                        "ab",
                                        3)) +
                         "bvx$",
                     3),
               Contains("does not give the bytes that it claims"));
    CHECK_THAT(error(entropy_block(1, "abcdefgh", {{1, 0, 0}}) + "bvx$", 1), Contains("a block's header is out of range"));
    CHECK_THAT(error(entropy_block(4, "abcd", {{5, 0, 0}}) + "bvx$", 4), Contains("more literals than it has"));
}

TEST_CASE("depth and confidence of a real recording", "[layout.record3d]")
{
    const auto folder = shared_data("failing/record3d/rgbd", "a real recording of Record3D");
    if (folder.empty())
        return;
    constexpr std::size_t pixels = 192 * 256;
    const auto bytes = [&](const char* name, std::size_t size)
    { return record3d::unpack_lzfse(fresco::read_file(folder / name), size, name); };
    for (const auto& [name, sum] : {std::pair{"0.depth", 121226.49}, std::pair{"1.depth", 107483.21}})
    {
        const auto raw = bytes(name, 4 * pixels);
        double found = 0;
        for (std::size_t i = 0; i < pixels; ++i)
        {
            float meters = 0;
            std::memcpy(&meters, &raw[4 * i], sizeof meters);
            found += meters;
        }
        CHECK(found == Approx(sum).margin(0.01));
    }
    for (const auto& [name, counts] :
         {std::pair{"0.conf", std::array{3832, 8207, 37113}}, std::pair{"1.conf", std::array{4452, 7164, 37536}}})
    {
        std::array<int, 3> found{};
        for (const auto level : bytes(name, pixels))
            ++found.at(std::to_integer<std::size_t>(level));
        CHECK(found == counts);
    }
}
