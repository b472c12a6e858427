#include "catch.h"
#include "uv_map_samples.h"

#include <fresco/error.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>
#include <cstring>

using Catch::Contains;
using fresco::UvMap;

namespace
{

constexpr int all_uv_bits[] = {16, 17, 18, 22};

UvMap there_and_back(const UvMap& map, int uv_bits)
{
    return fresco::unpack_uv_map(fresco::pack_uv_map(map, uv_bits, "test"), map.valid.width, map.valid.height, "test");
}

bool same(const UvMap& a, const UvMap& b)
{
    return a.uv == b.uv && a.depth == b.depth && a.cosine == b.cosine && a.valid == b.valid;
}

/// The stored form of a texcoord or a cosine.
double nearest(float value)
{
    return std::clamp(static_cast<double>(value), 0.0, 1.0);
}

void check_errors(const UvMap& map, const UvMap& back, int uv_bits)
{
    double deepest = 0;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] != 0)
            deepest = std::max(deepest, static_cast<double>(map.depth.values[i]));
    const double uv_error = 0.5 / ((1 << uv_bits) - 1) + 3.1e-8;
    const double depth_error = std::max(0.0005, 4.8e-7 * deepest) + 6e-8 * deepest;
    bool good = back.valid == map.valid;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] == 0)
            good = good && back.uv.values[2 * i] == 0 && back.uv.values[2 * i + 1] == 0 && back.depth.values[i] == 0 &&
                   back.cosine.values[i] == 0;
        else
        {
            for (const std::size_t k : {2 * i, 2 * i + 1})
                good = good && std::abs(back.uv.values[k] - nearest(map.uv.values[k])) <= uv_error;
            good = good && std::abs(back.cosine.values[i] - nearest(map.cosine.values[i])) <= 0.5 / 255 + 1e-7;
            good = good && std::abs(static_cast<double>(back.depth.values[i]) - map.depth.values[i]) <= depth_error;
            good = good && (back.depth.values[i] > 0) == (map.depth.values[i] > 0);
        }
    CHECK(good);
}

}  // namespace

TEST_CASE("A packed uv map comes back within half a step, invalid pixels as zeros")
{
    for (const auto& [name, map] : all_uv_maps())
        for (const int uv_bits : all_uv_bits)
        {
            CAPTURE(name, uv_bits);
            const UvMap back = there_and_back(map, uv_bits);
            check_errors(map, back, uv_bits);
            CHECK(same(there_and_back(back, uv_bits), back));
        }
    // 0.032 texel of 4096, as 18 bits of 16384.
    CHECK(0.5 / 65535 * 4096 + 4096 * 3.1e-8 <= 0.032);
    CHECK(0.5 / 262143 * 16384 + 16384 * 3.1e-8 <= 0.032);
}

TEST_CASE("Packing gives the same bytes again, of any map and of its own")
{
    for (const auto& [name, map] : all_uv_maps())
    {
        CAPTURE(name);
        const auto bytes = fresco::pack_uv_map(map, 16, "test");
        CHECK(fresco::pack_uv_map(map, 16, "test") == bytes);
        const UvMap back = fresco::unpack_uv_map(bytes, map.valid.width, map.valid.height, "test");
        CHECK(fresco::pack_uv_map(back, 16, "test") == bytes);
    }
}

TEST_CASE("What invalid pixels hold does not reach the file")
{
    UvMap map = charts_uv_map(80, 60);
    const auto bytes = fresco::pack_uv_map(map, 16, "test");
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
        if (map.valid.values[i] == 0)
            map.uv.values[2 * i] = map.depth.values[i] = map.cosine.values[i] = -1e30F;
    CHECK(fresco::pack_uv_map(map, 16, "test") == bytes);
}

TEST_CASE("What lies in front of the camera stays there")
{
    UvMap map = noise_uv_map(9, 9, 2, 51);
    map.depth.at(4, 5) = 1e-5F;
    map.depth.at(5, 5) = 0;
    map.depth.at(6, 5) = -0.0F;
    const UvMap back = there_and_back(map, 16);
    CHECK(back.depth.at(4, 5) == 0.001F);
    CHECK(back.depth.at(5, 5) == 0);
    CHECK(back.depth.at(6, 5) == 0);
}

TEST_CASE("A flat wall costs next to nothing across a straight seam too, and a hole in it costs only its mask")
{
    const int width = 256;
    const int height = 128;
    UvMap wall{{width, height, 2}, {width, height, 1, 2}, {width, height, 1, 0.5F}, {width, height, 1, 1}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            wall.uv.at(x, y, 0) = static_cast<float>(64 * x + (x < 100 ? 0 : 30000)) / 65535;
            wall.uv.at(x, y, 1) = static_cast<float>(64 * y) / 65535;
        }
    const auto whole = fresco::pack_uv_map(wall, 16, "test");
    CHECK(8.0 * static_cast<double>(whole.size()) / (width * height) < 0.15);
    for (int y = 20; y < 60; ++y)
        for (int x = 20; x < 60; ++x)
            wall.valid.at(x, y) = 0;
    const auto bytes = fresco::packed_uv_map_bytes(whole, "test");
    const auto with_hole = fresco::packed_uv_map_bytes(fresco::pack_uv_map(wall, 16, "test"), "test");
    CHECK(with_hole.uv == bytes.uv);
    CHECK(with_hole.cosine == bytes.cosine);
    CHECK(with_hole.depth == bytes.depth);
}

TEST_CASE("The parts of a packed map are its bytes")
{
    const auto bytes = fresco::pack_uv_map(charts_uv_map(160, 120), 16, "test");
    const auto parts = fresco::packed_uv_map_bytes(bytes, "test");
    CHECK(parts.header == 88);
    CHECK(std::min({parts.validity, parts.uv, parts.cosine, parts.depth}) > 20);
    CHECK(parts.header + parts.validity + parts.uv + parts.cosine + parts.depth == bytes.size());
}

TEST_CASE("The bits of texcoords follow the texture, and are found again")
{
    CHECK(fresco::uv_bits_for_texture(1) == 16);
    CHECK(fresco::uv_bits_for_texture(4096) == 16);
    CHECK(fresco::uv_bits_for_texture(4097) == 17);
    CHECK(fresco::uv_bits_for_texture(8192) == 17);
    CHECK(fresco::uv_bits_for_texture(16384) == 18);
    CHECK(fresco::uv_bits_for_texture(262144) == 22);
    CHECK_THROWS_AS(fresco::uv_bits_for_texture(0), std::invalid_argument);
    CHECK_THROWS_AS(fresco::uv_bits_for_texture(262145), std::invalid_argument);
    const UvMap map = noise_uv_map(40, 30, 0.8, 21);
    for (const int uv_bits : {16, 17, 18, 19, 20, 21, 22})
        CHECK(fresco::uv_bits_of(there_and_back(map, uv_bits)) == uv_bits);
    CHECK(fresco::uv_bits_of(map) == 22);
    CHECK(fresco::uv_bits_of(noise_uv_map(40, 30, 0, 21)) == 16);
}

TEST_CASE("A map that cannot be packed is refused by pixel and value")
{
    const auto refused = [](UvMap map)
    {
        try
        {
            fresco::pack_uv_map(map, 16, "000003_48.uvmap");
        }
        catch (const fresco::Error& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    const float inf = std::numeric_limits<float>::infinity();
    const UvMap good = noise_uv_map(8, 6, 2, 31);
    REQUIRE(refused(good).empty());
    for (const float value : {1.5F, -0.001F, inf, -inf, std::numeric_limits<float>::quiet_NaN()})
    {
        UvMap map = good;
        map.uv.at(5, 3, 1) = value;
        CHECK_THAT(refused(map), Contains("000003_48.uvmap: uv: pixel (5, 3)") && Contains("from 0 to 1"));
        map = good;
        map.cosine.at(7, 5) = value;
        CHECK_THAT(refused(map), Contains("cosine: pixel (7, 5)"));
        map.valid.at(7, 5) = 0;
        CHECK(refused(map).empty());
    }
    for (const float value : {-0.001F, inf, -inf, std::numeric_limits<float>::quiet_NaN()})
    {
        UvMap map = good;
        map.depth.at(0, 1) = value;
        CHECK_THAT(refused(map), Contains("depth: pixel (0, 1)") && Contains("meters"));
    }
    UvMap map = good;
    map.depth.at(0, 1) = -0.0F;
    CHECK(refused(map).empty());
    map.depth = fresco::RasterF(8, 7);
    CHECK_THAT(refused(map), Contains("depth: is 8x7x1") && Contains("8x6"));
    CHECK_THAT(refused(UvMap{{0, 0, 2}, {}, {}, {}}), Contains("expected 1 to "));
    CHECK_THROWS_AS(fresco::pack_uv_map(good, 15, "test"), std::invalid_argument);
    CHECK_THROWS_AS(fresco::pack_uv_map(good, 23, "test"), std::invalid_argument);
}

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
