#include "catch.h"
#include "codec.h"

#include <fresco/files_io.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <string>

using namespace fresco;
using namespace samples;

namespace
{

/// Pictures of heif-enc: 4 x 4 squares of 16 x 16 pixels, of the color below.
Bytes sample(const std::string& name)
{
    return read_file(std::filesystem::path(FRESCO_SOURCE_FOLDER) / "tests/fuzz/corpus/heif_picture" / name);
}

/// The picture as PNG, with the sample's profile if it has one.
Bytes same_png(std::span<const std::byte> icc)
{
    Png png{.width = 64, .height = 64, .color_type = 2};
    for (int y = 0; y < 64; ++y)
    {
        put(png.rows, 0, 1);
        for (int x = 0; x < 64; ++x)
            put(png.rows, bytes_of({40 + 60 * (x / 16), 200 - 50 * (y / 16), 30 + 20 * (x / 16 + y / 16)}));
    }
    if (!icc.empty())
        png.before_data = profile_chunk(icc);
    return file_of(png);
}

/// The ICC profile in a sample: behind "prof", as long as its first number says.
Bytes profile_in(const Bytes& file)
{
    const std::size_t begin = find(file, {'p', 'r', 'o', 'f'}) + 4;
    REQUIRE(begin < file.size());
    const std::size_t size = std::to_integer<std::size_t>(file[begin + 2]) << 8U | std::to_integer<std::size_t>(file[begin + 3]);
    const auto part = std::span(file).subspan(begin, size);
    return {part.begin(), part.end()};
}

int most_apart(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b)
{
    REQUIRE(a.size() == b.size());
    const auto larger = [](int x, int y) { return std::max(x, y); };
    return std::transform_reduce(a.begin(), a.end(), b.begin(), 0, larger, [](int x, int y) { return std::abs(x - y); });
}

}  // namespace

TEST_CASE_METHOD(WithCodec, "image.opencv: HEIC and AVIF have the pixels of the PNG, with its profile")
{
    const Bytes heic = sample("good_p3.heic");
    // The encoder goes through YCbCr, which rounds.
    CHECK(most_apart(codec.rgb(heic), codec.rgb(same_png(profile_in(heic)))) <= 2);
    CHECK(most_apart(codec.rgb(heic), codec.rgb(same_png({}))) > 9);
    const Bytes avif = sample("good_srgb.avif");
    CHECK(most_apart(codec.rgb(avif), codec.rgb(same_png({}))) <= 1);
    // 10 bits, with loss.
    const Bytes deep = sample("good_deep.heic");
    CHECK(codec.images->check(codec.write(deep)).bits == 10);
    CHECK(most_apart(codec.rgb(deep), codec.rgb(same_png(profile_in(deep)))) <= 4);
    const auto header = codec.images->header(codec.write(heic));
    CHECK((header.width == 64 && header.height == 64 && header.orientation == 1));
    CHECK_FALSE(codec.images->check(codec.write(heic)).alpha);
    CHECK_THROWS_WITH(codec.images->read_depth(codec.write(deep)), Contains("expected a depth picture"));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: AVIF that names its colors by numbers")
{
    Bytes avif = sample("good_srgb.avif");
    const std::size_t primaries = find(avif, {'n', 'c', 'l', 'x'}) + 5;
    avif[primaries] = std::byte{12};
    // The primaries in the profile are rounded to 5 digits.
    CHECK(most_apart(codec.rgb(avif), codec.rgb(same_png(profile_in(sample("good_p3.heic"))))) <= 2);
    avif[primaries + 2] = std::byte{16};
    CHECK_THROWS_WITH(codec.rgb(avif), Contains("high dynamic range"));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: HEIC and AVIF that are cut, too large or of another kind are refused")
{
    for (const char* name : {"good_p3.heic", "good_srgb.avif"})
        refuses_every_beginning(codec, sample(name));
    Bytes large = sample("good_p3.heic");
    const std::size_t size = find(large, {'i', 's', 'p', 'e'}) + 8;
    for (const std::size_t side : {size, size + 4})
        large[side + 2] = std::byte{0x70};
    CHECK_THROWS_WITH(codec.rgb(large), Contains("at most 300 megapixels"));
    Bytes film;
    put(film, 16, 4);
    put(film, "ftypisom");
    put(film, 0, 4);
    CHECK_THROWS_WITH(codec.rgb(film), Contains("byte 16: the file has no index of pictures (box meta)"));
}
