#include "catch.h"

#include <fresco/error.h>
#include <fresco/npy.h>

#include <cstring>
#include <string>

using fresco::NpyType;

namespace
{

std::vector<std::byte> sample()
{
    const std::vector<float> values{1.5F, -2, 3, 4, 5, 6};
    const std::vector<std::size_t> shape{2, 3};
    return fresco::to_npy(NpyType::float32, shape, std::as_bytes(std::span(values)));
}

}  // namespace

TEST_CASE("NPY reads back what was written, for every rank")
{
    for (const std::vector<std::size_t>& shape : {std::vector<std::size_t>{}, {6}, {2, 3}, {3, 1, 2}, {0, 4}})
    {
        std::size_t count = 1;
        for (const std::size_t extent : shape)
            count *= extent;
        const std::vector<std::uint16_t> values(count, 517);
        const auto bytes = fresco::to_npy(NpyType::uint16, shape, std::as_bytes(std::span(values)));
        CHECK((bytes.size() - count * 2) % 64 == 0);
        const auto array = fresco::parse_npy(bytes, "a.npy");
        CHECK(array.shape == shape);
        CHECK(std::ranges::equal(array.as<std::uint16_t>(), values));
        CHECK_THROWS_AS(array.as<float>(), fresco::Error);
    }
}

TEST_CASE("NumPy's own headers are read")
{
    std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (3,), }";
    header.append(128 - 10 - header.size() - 1, ' ');
    header += '\n';
    std::string file = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header + "abc";
    const auto parse = [](const std::string& text) { return fresco::parse_npy(std::as_bytes(std::span(text)), "n.npy"); };
    CHECK(parse(file).count() == 3);
    std::string fortran = file;
    fortran.replace(fortran.find("False"), 5, "True ");
    CHECK_THROWS_WITH(parse(fortran), Catch::Contains("ascontiguousarray"));
    std::string big_endian = file;
    big_endian.replace(big_endian.find("|u1"), 3, ">u2");
    CHECK_THROWS_WITH(parse(big_endian), Catch::Contains("not supported"));
    std::string huge = file;
    huge.replace(huge.find("(3,), }"), 31, "(99999999999999, 9999999999), }");
    CHECK_THROWS_AS(parse(huge), fresco::Error);
    std::string negative = file;
    negative.replace(negative.find("(3,), "), 6, "(-1,),");
    CHECK_THROWS_WITH(parse(negative), Catch::Contains("n.npy: byte 61: a negative extent"));
}

TEST_CASE("An NPY file cut at any byte or with a byte more is refused")
{
    const auto bytes = sample();
    for (std::size_t size = 0; size < bytes.size(); ++size)
        CHECK_THROWS_AS(fresco::parse_npy(std::span(bytes).first(size), "cut.npy"), fresco::Error);
    auto longer = bytes;
    longer.push_back(std::byte{0});
    CHECK_THROWS_WITH(fresco::parse_npy(longer, "long.npy"), Catch::Contains("long.npy"));
}

TEST_CASE("A raster is an array of two or three dimensions, and comes back from it")
{
    for (const int channels : {1, 3})
    {
        const fresco::Raster16 raster(5, 4, channels, 517);
        const auto array = fresco::parse_npy(fresco::to_npy(raster), "a.npy");
        CHECK(array.shape.size() == (channels == 1 ? 2 : 3));
        CHECK(fresco::to_raster<std::uint16_t>(array, "a.npy") == raster);
        CHECK_THROWS_WITH(fresco::to_raster<float>(array, "a.npy"), "a.npy: array of type uint16; expected float32");
    }
    CHECK_THROWS_WITH(fresco::to_raster<float>(fresco::NpyArray{}, "a.npy"), Catch::Contains("a.npy: expected an array H x W"));
}
