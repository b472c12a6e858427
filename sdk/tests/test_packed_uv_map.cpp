#include "catch.h"
#include "stored_png.h"
#include "uv_map_samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstring>

using fresco::UvMap;

namespace
{

UvMap there_and_back(const UvMap& map, int uv_bits)
{
    return fresco::unpack_uv_map(fresco::pack_uv_map(map, uv_bits, "test"), map.valid.width, map.valid.height, "test");
}

bool same(const UvMap& a, const UvMap& b)
{
    return a.uv == b.uv && a.depth == b.depth && a.cosine == b.cosine && a.valid == b.valid;
}

void check_errors(const UvMap& map, const UvMap& back, int uv_bits)
{
    const auto largest = [&](const fresco::RasterF& kept, const fresco::RasterF& given, double most)
    {
        double error = 0;
        for (std::size_t i = 0; i < given.values.size(); ++i)
        {
            const bool valid = map.valid.values[i / static_cast<std::size_t>(given.channels)] != 0;
            const double expected = valid ? std::clamp(static_cast<double>(given.values[i]), 0.0, most) : 0;
            error = std::max(error, std::abs(static_cast<double>(kept.values[i]) - expected));
        }
        return error;
    };
    const double deepest = static_cast<double>(*std::ranges::max_element(back.depth.values));
    CHECK(back.valid == map.valid);
    CHECK(largest(back.uv, map.uv, 1) <= 0.5 / ((1 << uv_bits) - 1) + 3.1e-8);
    CHECK(largest(back.cosine, map.cosine, 1) <= 0.5 / 255 + 1e-7);
    CHECK(largest(back.depth, map.depth, 1e9) <= std::max(0.0005, 4.8e-7 * deepest) + 6e-8 * deepest);
}

}  // namespace

TEST_CASE("A packed uv map comes back within half a step, and packs to the same bytes again")
{
    for (const auto& [name, map] : all_uv_maps())
        for (const int uv_bits : {16, 17, 18, 22})
        {
            CAPTURE(name, uv_bits);
            const auto bytes = fresco::pack_uv_map(map, uv_bits, "test");
            const UvMap back = fresco::unpack_uv_map(bytes, map.valid.width, map.valid.height, "test");
            check_errors(map, back, uv_bits);
            CHECK(fresco::pack_uv_map(map, uv_bits, "test") == bytes);
            CHECK(fresco::pack_uv_map(back, uv_bits, "test") == bytes);
        }
    // A surface in front of the camera stays there.
    UvMap map = noise_uv_map(3, 1, 2, 51);
    map.depth.values = {1e-5F, 0, -0.0F};
    CHECK(there_and_back(map, 16).depth.values == std::vector<float>{0.001F, 0, 0});
}

TEST_CASE("The bits of texcoords follow the texture, and are found again")
{
    for (const auto& [size_px, bits] : {std::pair{1, 16}, {4096, 16}, {4097, 17}, {8192, 17}, {16384, 18}, {262144, 22}})
        CHECK(fresco::uv_bits_for_texture(size_px) == bits);
    for (const int size_px : {0, 262145})
        CHECK_THROWS_AS(fresco::uv_bits_for_texture(size_px), std::invalid_argument);
    const UvMap map = noise_uv_map(40, 30, 0.8, 21);
    for (const int uv_bits : {16, 17, 18, 19, 20, 21, 22})
        CHECK(fresco::uv_bits_of(there_and_back(map, uv_bits)) == uv_bits);
    CHECK(fresco::uv_bits_of(map) == 22);
    CHECK(fresco::uv_bits_of(noise_uv_map(40, 30, 0, 21)) == 16);
}

TEST_CASE("A map that cannot be packed is refused by pixel and value")
{
    const auto refused = [](UvMap map)
    { return fresco::testing::error_of([&] { fresco::pack_uv_map(map, 16, "000003_48.uvmap"); }); };
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
    }
    for (const float value : {-0.001F, inf})
    {
        UvMap map = good;
        map.depth.at(0, 1) = value;
        CHECK_THAT(refused(map), Contains("depth: pixel (0, 1)") && Contains("meters"));
    }
    UvMap map = good;
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
    UvMap map;
    const auto error = fresco::testing::error_of([&] { map = fresco::unpack_uv_map(file, width, height, "000000_72.uvmap"); });
    return !error.empty() || same(map, expected) ? error : "another";
}

/// A well-meant checksum over a header that is not.
void seal(std::vector<std::byte>& file)
{
    const std::uint32_t sum = stored_png::crc32(reinterpret_cast<const std::uint8_t*>(file.data()), 32);
    std::memcpy(file.data() + 32, &sum, 4);
}

std::string sealed(std::size_t offset, std::uint32_t value)
{
    auto file = packed();
    std::memcpy(file.data() + offset, &value, sizeof value);
    seal(file);
    return outcome(file);
}

}  // namespace

TEST_CASE("A packed uv map that is cut or has flipped bytes is refused at its offset or comes back the same, never another")
{
    const auto whole = packed();
    REQUIRE(outcome(whole).empty());
    CHECK_THAT(outcome({whole.begin(), whole.begin() + 35}), Contains("000000_72.uvmap: offset 35:"));
    CHECK_THAT(outcome({whole.begin(), whole.end() - 1}), Contains("offset 36:") && Contains("fresco store verify"));
    auto longer = whole;
    longer.push_back(std::byte{0});
    CHECK_THAT(outcome(longer), Contains("offset 36:"));
    fresco::Random random(41);
    int refused = 0;
    for (int i = 0; i < 500; ++i)
    {
        auto file = whole;
        // Every byte of the header, then anywhere.
        const auto at = i < 36 ? static_cast<std::size_t>(i)
                               : static_cast<std::size_t>(random.below(static_cast<std::int64_t>(whole.size())));
        file[at] ^= static_cast<std::byte>(1 + random.below(255));
        CAPTURE(at);
        const auto error = outcome(file);
        CHECK(error != "another");
        refused += error.find("000000_72.uvmap: offset ") == 0 ? 1 : 0;
    }
    CHECK(refused > 450);
}

TEST_CASE("A header made up with its checksum right is held against the frame and the index")
{
    const auto whole = packed();
    CHECK_THAT(sealed(0, 0), Contains("offset 0:"));
    CHECK_THAT(sealed(8, 2), Contains("offset 8: expected form 3, got 2"));
    CHECK_THAT(sealed(12, 97), Contains("is 97x72; the index says 96x72"));
    CHECK_THAT(sealed(20, 15), Contains("offset 20:"));
    // Fewer or more planes than the frame has.
    CHECK_THAT(sealed(20, 16), Contains("offset 36: expected a Zstandard frame"));
    CHECK_THAT(sealed(24, 22), Contains("offset 36: expected a Zstandard frame"));
    CHECK_THAT(sealed(28, 0), Contains("offset 28:"));
    // An index that agrees with the header does not help.
    auto half = whole;
    half[16] = std::byte{36};
    seal(half);
    CHECK_THROWS_WITH(fresco::unpack_uv_map(half, 96, 36, "m"), Contains("m: offset 36:"));
    CHECK_THROWS_WITH(fresco::unpack_uv_map(whole, 96, 73, "m"), Contains("is 96x72; the index says 96x73"));
    // More pixels than the bytes can hold are refused before memory is taken for them.
    for (const auto& [width, height] : {std::pair{2'000'000'000U, 2'000'000'000U}, {0U, 72U}, {16384U, 16384U}})
    {
        auto file = whole;
        std::memcpy(file.data() + 12, &width, 4);
        std::memcpy(file.data() + 16, &height, 4);
        seal(file);
        CHECK_THROWS_WITH(fresco::unpack_uv_map(file, static_cast<int>(width), static_cast<int>(height), "m"),
                          Contains("m: offset 12:"));
    }
}
