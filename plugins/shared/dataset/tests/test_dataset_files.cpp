#include "catch.h"

#include <fresco/dataset/dataset_files.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/testing.h>

#include <cmath>
#include <limits>

using namespace fresco;
using Catch::Contains;

TEST_CASE("texcoords as uint16 are off by half a step of 1/65535 at most, and exact at both ends")
{
    RasterF uv(1000, 1, 2);
    for (std::size_t i = 0; i < uv.values.size(); ++i)
        uv.values[i] = static_cast<float>(i) / static_cast<float>(uv.values.size() - 1);
    const RasterF back = dataset::restored(dataset::quantized(uv));
    for (std::size_t i = 0; i < uv.values.size(); ++i)
        CHECK(std::abs(back.values[i] - uv.values[i]) <= 0.5 / 65535 + 1e-7);
    CHECK(back.values.front() == 0);
    CHECK(back.values.back() == 1);
    uv.values = {-1e-6F, 1 + 1e-6F};
    CHECK(dataset::quantized(uv).values[0] == 0);
    CHECK(dataset::quantized(uv).values[1] == 65535);
}

TEST_CASE("rasters read back from NPY, and only as what they are")
{
    Raster8 picture(3, 2, 3);
    picture.at(2, 1, 2) = 9;
    const auto npy = dataset::to_npy(picture);
    CHECK(dataset::raster8_from(npy, 3, 2, 3, "a.npy") == picture);
    CHECK(dataset::picture_from(npy, "a.npy") == picture);
    CHECK_THROWS_WITH(dataset::raster8_from(npy, 2, 3, 3, "a.npy"), "a.npy: an array of 2 x 3 x 3; expected 3 x 2 x 3");
    CHECK_THROWS_WITH(dataset::raster8_from(npy, 3, 2, 1, "a.npy"), Contains("expected 2 x 3"));
    CHECK_THROWS_WITH(dataset::raster_f_from(npy, 3, 2, 3, "a.npy"), "a.npy: wrong array type; expected float32");
    const RasterF depth(4, 2, 1, 1.5F);
    CHECK(dataset::raster_f_from(dataset::to_npy(depth), 4, 2, 1, "d.npy") == depth);
    CHECK_THROWS_WITH(dataset::picture_from(dataset::to_npy(depth), "d.npy"), Contains("d.npy: expected a picture, uint8"));
    CHECK_THROWS_WITH(dataset::picture_from(dataset::to_npy(Raster8(0, 0)), "d.npy"), Contains("1 to 200 million pixels"));
}

TEST_CASE("a file is read only as it was stamped")
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.npy";
    const auto npy = dataset::to_npy(Raster8(5, 5));
    const auto stamp = dataset::write_stamped(file, npy);
    CHECK(stamp.bytes == npy.size());
    CHECK(dataset::read_stamped(file, stamp) == npy);
    auto changed = npy;
    changed.back() = std::byte{1};
    write_file(file, changed);
    CHECK_THROWS_WITH(dataset::read_stamped(file, stamp), Contains("a.npy: its contents differ from dataset.json"));
    changed.pop_back();
    write_file(file, changed);
    CHECK_THROWS_WITH(dataset::read_stamped(file, stamp), Contains("a.npy: has " + std::to_string(npy.size() - 1) + " bytes"));
    std::filesystem::remove(file);
    CHECK_THROWS_AS(dataset::read_stamped(file, stamp), MissingInput);
}

TEST_CASE("values out of range are named by pixel")
{
    Raster8 valid(3, 2, 1, 1);
    CHECK_NOTHROW(dataset::check_valid(valid, 6, "v"));
    CHECK_THROWS_WITH(dataset::check_valid(valid, 5, "v"), "v: 6 valid pixels; expected 5");
    valid.at(1, 1) = 2;
    CHECK_THROWS_WITH(dataset::check_valid(valid, 5, "v"), "v: pixel (1, 1) holds 2; expected 0 or 1");
    valid.at(1, 1) = 0;

    RasterF uv(3, 2, 2, 1 + 5e-6F);
    CHECK_NOTHROW(dataset::check_uv(uv, "u"));
    uv.at(2, 0, 1) = 1.001F;
    CHECK_THROWS_WITH(dataset::check_uv(uv, "u"), Contains("u: pixel (2, 0) holds 1.001"));
    uv.at(2, 0, 1) = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(dataset::check_uv(uv, "u"), Contains("u: pixel (2, 0) holds nan"));

    RasterF depth(3, 2, 1, 2);
    depth.at(1, 1) = 0;
    CHECK_NOTHROW(dataset::check_depth(depth, valid, "d"));
    depth.at(0, 1) = 0;
    CHECK_THROWS_WITH(dataset::check_depth(depth, valid, "d"), Contains("d: pixel (0, 1) is valid and has no depth"));
    depth.at(0, 1) = std::numeric_limits<float>::infinity();
    CHECK_THROWS_WITH(dataset::check_depth(depth, valid, "d"), Contains("d: pixel (0, 1) holds inf"));
    CHECK_THROWS_WITH(dataset::check_cosine(RasterF(2, 1, 1, -0.5F), "c"), Contains("c: pixel (0, 0) holds -0.5"));
}
