#include "catch.h"
#include "uv_map_samples.h"

#include <fresco/error.h>
#include <fresco/uv_maps.h>

#include <cstring>

using Catch::Contains;
using fresco::UvMap;

namespace
{

constexpr int width = 96;
constexpr int height = 72;

std::vector<std::byte> packed()
{
    return fresco::pack_uv_map(charts_uv_map(width, height), 18, "test");
}

/// The error's text; "" if the map came back as it was, "another" if it came back differently.
std::string outcome(const std::vector<std::byte>& file)
{
    static const UvMap expected = fresco::unpack_uv_map(packed(), width, height, "test");
    try
    {
        const UvMap map = fresco::unpack_uv_map(file, width, height, "000000_72.uvmap");
        return map.uv == expected.uv && map.depth == expected.depth && map.cosine == expected.cosine &&
                       map.valid == expected.valid
                   ? ""
                   : "another";
    }
    catch (const fresco::Error& error)
    {
        return error.what();
    }
}

/// A well-meant checksum over a header that is not.
void seal(std::vector<std::byte>& file)
{
    std::uint32_t remainder = ~0U;
    for (std::size_t i = 0; i < 84; ++i)
    {
        remainder ^= std::to_integer<std::uint32_t>(file[i]);
        for (int bit = 0; bit < 8; ++bit)
            remainder = remainder >> 1U ^ (remainder % 2 != 0 ? 0xedb88320U : 0U);
    }
    remainder = ~remainder;
    std::memcpy(file.data() + 84, &remainder, 4);
}

std::string sealed(std::size_t offset, std::uint32_t value, std::size_t bytes = 4)
{
    auto file = packed();
    std::memcpy(file.data() + offset, &value, bytes);
    seal(file);
    return outcome(file);
}

std::uint32_t entry(const std::vector<std::byte>& file, std::size_t offset)
{
    std::uint32_t value = 0;
    std::memcpy(&value, file.data() + offset, 4);
    return value;
}

}  // namespace

TEST_CASE("A packed uv map cut anywhere is refused, and says where it ends and what to do")
{
    const auto whole = packed();
    REQUIRE(outcome(whole).empty());
    for (std::size_t cut = 0; cut < 200; ++cut)
    {
        const std::size_t size = whole.size() * cut / 200;
        CAPTURE(size);
        const auto error = outcome({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
        CHECK_THAT(error, Contains("000000_72.uvmap: offset " + std::to_string(size) + ":") && Contains("fresco store verify"));
    }
    auto longer = whole;
    longer.push_back(std::byte{0});
    CHECK_THAT(outcome(longer), Contains("offset " + std::to_string(longer.size())));
}

TEST_CASE("Flipped bytes of a packed uv map give an error or the same map, never another")
{
    const auto whole = packed();
    fresco::Random random(41);
    int refused = 0;
    for (int i = 0; i < 500; ++i)
    {
        auto file = whole;
        // Every byte of the header, then anywhere.
        const auto at = i < 88 ? static_cast<std::size_t>(i)
                               : static_cast<std::size_t>(random.below(static_cast<std::int64_t>(whole.size())));
        file[at] ^= static_cast<std::byte>(1 + random.below(255));
        CAPTURE(at);
        const auto error = outcome(file);
        CHECK(error != "another");
        if (!error.empty())
        {
            ++refused;
            CHECK_THAT(error, Contains("000000_72.uvmap: offset "));
        }
    }
    CHECK(refused > 450);
}

TEST_CASE("A header made up with its checksum right is held against the parts and the index")
{
    const auto whole = packed();
    CHECK_THAT(sealed(0, 0), Contains("offset 0: expected \"FRESCOUV\""));
    CHECK_THAT(sealed(8, 3), Contains("offset 8: expected form 2, got 3"));
    CHECK_THAT(sealed(12, 97), Contains("is 97x72; the index says 96x72"));
    CHECK_THAT(sealed(16, 0xffffffffU), Contains("the index says 96x72"));
    CHECK_THAT(sealed(20, 1), Contains("offset 20: 1 valid pixels are listed"));
    CHECK_THAT(sealed(24, 0x10081717U), Contains("offset 24: expected 16 to 22 bits"));
    CHECK_THAT(sealed(24, 0x10081412U), Contains("offset 24: expected 16 to 22 bits"));
    CHECK_THAT(sealed(24, 0x10071212U), Contains("offset 24: expected 16 to 22 bits"));
    CHECK_THAT(sealed(24, 0x20081212U), Contains("offset 24: expected 16 to 22 bits"));
    // Fewer bits: a part is there that should not be. More: one is too few.
    CHECK_THAT(sealed(24, 0x10081010U), Contains("expected no bytes"));
    CHECK_THAT(sealed(24, 0x16081212U), Contains("offset") && Contains("damaged"));
    CHECK_THAT(sealed(28, 0), Contains("offset 28: expected steps of depth"));
    CHECK_THAT(sealed(28, 0x7fc00000U), Contains("offset 28: expected steps of depth"));
    CHECK_THAT(sealed(32, entry(whole, 32) + 1), Contains("the header lists parts up to " + std::to_string(whole.size() + 1)));
    CHECK_THAT(sealed(32, 0xffffffffU), Contains("the header lists parts up to"));
    // Bytes moved from one part to the next.
    for (std::size_t offset = 32; offset < 80; offset += 4)
    {
        auto file = whole;
        if (entry(file, offset) == 0)
            continue;
        const std::uint32_t less = entry(file, offset) - 1;
        const std::uint32_t more = entry(file, offset + 4) + 1;
        std::memcpy(file.data() + offset, &less, 4);
        std::memcpy(file.data() + offset + 4, &more, 4);
        seal(file);
        CHECK_THAT(outcome(file), Contains("000000_72.uvmap: offset "));
    }
    // An index that agrees with the header does not help: the mask's frame says its own size.
    auto half = whole;
    half[16] = std::byte{36};
    seal(half);
    CHECK_THROWS_WITH(fresco::unpack_uv_map(half, 96, 36, "m"), Contains("m: offset 88: expected a frame of 432 bytes, got 864"));
    CHECK_THROWS_WITH(fresco::unpack_uv_map(whole, 96, 73, "m"), Contains("is 96x72; the index says 96x73"));
}

TEST_CASE("A packed uv map that claims more pixels than its bytes can hold is refused before memory is taken for them")
{
    const auto claimed = [](std::uint32_t width, std::uint32_t height)
    {
        auto file = packed();
        std::memcpy(file.data() + 12, &width, 4);
        std::memcpy(file.data() + 16, &height, 4);
        seal(file);
        return fresco::unpack_uv_map(file, static_cast<int>(width), static_cast<int>(height), "m");
    };
    CHECK_THROWS_WITH(claimed(2'000'000'000, 2'000'000'000), Contains("m: offset 12: expected 1 to 268435456 pixels"));
    CHECK_THROWS_WITH(claimed(0, 72), Contains("m: offset 12: expected 1 to 268435456 pixels, got 0x72"));
    CHECK_THROWS_WITH(claimed(16384, 16384), Contains("m: offset 12: 16384x16384 pixels cannot be in"));
}
