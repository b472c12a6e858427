#include "catch.h"
#include "color_profile.h"
#include "opencv_codec.h"
#include "picture_info.h"

using namespace image_opencv;

namespace
{

std::vector<std::byte> profile_called(std::string_view name, bool is_wide)
{
    std::vector<std::byte> profile(140);
    for (const char c : name)
    {
        if (is_wide)
            profile.push_back(std::byte{0});
        profile.push_back(static_cast<std::byte>(c));
    }
    return profile;
}

}  // namespace

TEST_CASE("What needs a library that is missing is refused by its name, and what to do")
{
    const std::vector<std::byte> bytes(20);
    for (const auto& read : {+[](std::span<const std::byte> file) { check_heif(file, "a.heic", Walk::whole); },
                             +[](std::span<const std::byte> file) { decode_heif(file, "a.heic"); }})
        CHECK_THROWS_WITH(read(bytes), Contains("a.heic: ") && Contains("install libheif-dev"));
    const fresco::Raster8 picture(2, 1, 3, 9);
    for (const bool is_wide : {false, true})
    {
        CHECK_THROWS_WITH(in_srgb(picture, profile_called("Display P3", is_wide), "a.jpg"),
                          Contains("a.jpg: ") && Contains("install liblcms2-dev"));
        CHECK(std::get<fresco::Raster8>(in_srgb(picture, profile_called("sRGB IEC61966-2.1", is_wide), "a.jpg")) == picture);
    }
    CHECK(std::get<fresco::Raster8>(in_srgb(picture, {}, "a.jpg")) == picture);
    CHECK_THROWS_WITH(in_srgb(picture, bytes, "a.jpg"), Contains("Little CMS 2"));
    CHECK_THROWS_WITH(icc_of_primaries({}, 0, "a.avif"), Contains("a.avif: ") && Contains("Little CMS 2"));
}
