#include "catch.h"
#include "picture_info.h"
#include "picture_samples.h"

using namespace samples;
using namespace image_opencv;
using Catch::Contains;

namespace
{

Bytes small_png()
{
    Png png{.width = 2, .height = 2, .color_type = 2};
    png.rows = bytes_of({0, 1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12});
    png.before_data = chunk("tEXt", bytes_of({'a', 0, 'b'}));
    return file_of(png);
}

void refused_png(const Bytes& bytes, const std::string& reason, Walk walk = Walk::whole)
{
    CHECK_THROWS_WITH(check_png(bytes, "a.png", walk), Contains("a.png: byte ") && Contains(reason));
}

}  // namespace

TEST_CASE("PNG check: size, bits and kind of every allowed type")
{
    const std::vector<std::pair<int, std::vector<int>>> allowed{
        {0, {1, 2, 4, 8, 16}}, {2, {8, 16}}, {3, {1, 2, 4, 8}}, {4, {8, 16}}, {6, {8, 16}}};
    for (int type = 0; type < 8; ++type)
        for (int bits = 0; bits <= 32; ++bits)
        {
            bool good = false;
            for (const auto& [t, list] : allowed)
                good = good || (t == type && std::find(list.begin(), list.end(), bits) != list.end());
            Png png{.width = 640, .height = 480, .bits = bits, .color_type = type};
            INFO("type " << type << ", bits " << bits);
            if (!good)
            {
                refused_png(file_of(png), "not defined", Walk::size);
                continue;
            }
            const auto info = check_png(file_of(png), "a.png", Walk::size);
            CHECK(info.width == 640);
            CHECK(info.height == 480);
            CHECK(info.bits == bits);
            CHECK(info.is_gray == (type == 0));
        }
}

TEST_CASE("PNG check: a file cut at any byte is refused")
{
    const Bytes good = small_png();
    CHECK(check_png(good, "a.png", Walk::whole).width == 2);
    for (std::size_t size = 0; size < good.size(); ++size)
    {
        INFO("the first " << size << " of " << good.size());
        const Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
        CHECK_THROWS_AS(check_png(cut, "a.png", Walk::whole), CutPicture);
    }
}

TEST_CASE("PNG check: every flipped bit is found")
{
    const Bytes good = small_png();
    for (std::size_t i = 0; i < good.size(); ++i)
        for (unsigned bit = 0; bit < 8; ++bit)
        {
            Bytes bad = good;
            bad[i] ^= static_cast<std::byte>(1U << bit);
            CHECK_THROWS_AS(check_png(bad, "a.png", Walk::whole), fresco::Error);
        }
}

TEST_CASE("PNG check: more than 300 megapixels are refused by the header alone")
{
    CHECK_NOTHROW(check_png(file_of(Png{.width = 20'000, .height = 10'000}), "a.png", Walk::size));
    refused_png(file_of(Png{.width = 20'000, .height = 15'001}), "20000 x 15001 pixels; at most 300 megapixels", Walk::size);
    refused_png(file_of(Png{.width = 0xFFFFFFFF, .height = 0xFFFFFFFF}), "at most 300 megapixels", Walk::size);
    refused_png(file_of(Png{.width = 0, .height = 5}), "0 x 5 pixels", Walk::size);
    refused_png(file_of(Png{.width = 5, .height = 0}), "5 x 0 pixels", Walk::size);
}

TEST_CASE("PNG check: missing, doubled and misplaced chunks are refused")
{
    Png png{.width = 1, .height = 1, .rows = bytes_of({0, 7})};
    png.with_data = false;
    refused_png(file_of(png), "no IDAT chunk");
    png.with_data = true;
    png.before_data = header_chunk(png);
    refused_png(file_of(png), "a second IHDR chunk");
    png.before_data = chunk("IDAT", {});
    put(png.before_data, chunk("tEXt", {}));
    refused_png(file_of(png), "not consecutive");
    refused_png(file_of(Png{.color_type = 3, .rows = bytes_of({0, 0})}), "PLTE chunk is missing");
    Bytes no_header = png_signature();
    put(no_header, chunk("IDAT", {}));
    refused_png(no_header, "expected an IHDR chunk");
    Bytes endless = png_signature();
    put(endless, header_chunk(Png{}));
    put(endless, 0xFFFFFFF0U, 4);
    put(endless, "IDAT");
    refused_png(endless, "a chunk of 4294967280 bytes");
}

TEST_CASE("PNG check: transparency of gray and orientation are read, bytes after the end are left alone")
{
    Png png{.width = 1, .height = 1, .bits = 16, .rows = bytes_of({0, 1, 2})};
    png.before_data = chunk("tRNS", bytes_of({1, 2}));
    put(png.before_data, chunk("eXIf", tiff_orientation(6, true)));
    Bytes file = file_of(png);
    put(file, "appended");
    const auto info = check_png(file, "a.png", Walk::whole);
    CHECK(info.transparent_gray == 258);
    CHECK(info.orientation == 6);
}
