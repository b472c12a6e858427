#include "catch.h"
#include "uv_map_samples.h"

#include <fresco/error.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstring>
#include <zstd.h>

using Catch::Contains;
using fresco::UvMap;

namespace
{

constexpr int all_uv_bits[] = {16, 17, 18, 22};

/// What sdk/docs/uv_maps.md says, pixel by pixel and without a check.
class PlainReader
{
  public:
    explicit PlainReader(const std::vector<std::byte>& file)
        : file_(file), width_(number(12)), height_(number(16)), pixels_(width_ * height_)
    {
    }

    UvMap map()
    {
        const int width = static_cast<int>(width_);
        const int height = static_cast<int>(height_);
        UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
        const auto mask = part();
        float steps_per_meter = 0;
        std::memcpy(&steps_per_meter, file_.data() + 28, sizeof steps_per_meter);
        const int uv_bits = std::to_integer<int>(file_[24]);
        const int depth_bits = std::to_integer<int>(file_[27]);
        const auto last = static_cast<float>((1 << uv_bits) - 1);
        const auto u = steps(uv_bits);
        const auto v = steps(uv_bits);
        const auto cosine = steps(8);
        const auto depth = steps(depth_bits);
        for (std::size_t i = 0; i < pixels_; ++i)
        {
            map.valid.values[i] = mask[i / 8] >> i % 8 & 1;
            if (map.valid.values[i] == 0)
                continue;
            map.uv.values[2 * i] = static_cast<float>(u[i]) / last;
            map.uv.values[2 * i + 1] = static_cast<float>(v[i]) / last;
            map.cosine.values[i] = static_cast<float>(cosine[i]) / 255;
            map.depth.values[i] = static_cast<float>(depth[i]) / steps_per_meter;
        }
        return map;
    }

  private:
    std::size_t number(std::size_t offset) const
    {
        std::size_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value |= std::to_integer<std::size_t>(file_[offset + i]) << 8 * i;
        return value;
    }
    std::vector<std::uint8_t> part()
    {
        const std::size_t size = number(entry_);
        entry_ += 4;
        std::vector<std::uint8_t> bytes(4 * pixels_ + 8);
        const std::size_t count = size == 0 ? 0 : ZSTD_decompress(bytes.data(), bytes.size(), file_.data() + at_, size);
        at_ += size;
        bytes.resize(count);
        return bytes;
    }
    std::vector<std::int64_t> steps(int bits)
    {
        const auto low = part();
        const auto extra = part();
        const auto large = part();
        std::vector<std::int64_t> result;
        std::size_t next_large = 0;
        for (std::size_t i = 0; i < pixels_; ++i)
        {
            std::int64_t n = low[i];
            if (n == 255 && bits > 8)
            {
                n = large[next_large] + 256 * large[large.size() / 2 + next_large];
                ++next_large;
            }
            if (!extra.empty())
                n = n * (std::int64_t{1} << (bits - 16)) + extra[i];
            const std::int64_t difference = n % 2 == 0 ? n / 2 : -(n + 1) / 2;
            const std::int64_t left = i % width_ > 0 ? result[i - 1] : 0;
            const std::int64_t above = i >= width_ ? result[i - width_] : 0;
            const std::int64_t corner = i % width_ > 0 && i >= width_ ? result[i - width_ - 1] : 0;
            const std::int64_t modulus = std::int64_t{1} << bits;
            result.push_back(((left + above - corner + difference) % modulus + modulus) % modulus);
        }
        return result;
    }

    const std::vector<std::byte>& file_;
    std::size_t width_;
    std::size_t height_;
    std::size_t pixels_;
    std::size_t entry_ = 32;
    std::size_t at_ = 88;
};

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

TEST_CASE("Unpacking agrees with the form's description taken word by word")
{
    for (const auto& [name, map] : all_uv_maps())
        for (const int uv_bits : all_uv_bits)
        {
            CAPTURE(name, uv_bits);
            const auto bytes = fresco::pack_uv_map(map, uv_bits, "test");
            CHECK(same(PlainReader(bytes).map(), fresco::unpack_uv_map(bytes, map.valid.width, map.valid.height, "test")));
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
