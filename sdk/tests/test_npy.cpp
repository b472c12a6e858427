#include "cut_bytes.h"

#include <fresco/error.h>
#include <fresco/npy.h>

#include <functional>
#include <numeric>
#include <string>

using fresco::NpyType;

TEST_CASE("NPY reads back what was written, for every rank, and a file cut at any byte or with one more is refused")
{
    for (const std::vector<std::size_t>& shape : {std::vector<std::size_t>{}, {6}, {2, 3}, {3, 1, 2}, {0, 4}})
    {
        const auto count = std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
        const std::vector<std::uint16_t> values(count, 517);
        auto bytes = fresco::to_npy(NpyType::uint16, shape, std::as_bytes(std::span(values)));
        CHECK((bytes.size() - count * 2) % 64 == 0);
        const auto array = fresco::parse_npy(bytes, "a.npy");
        CHECK(array.shape == shape);
        CHECK(std::ranges::equal(array.as<std::uint16_t>(), values));
        CHECK_THROWS_AS(array.as<float>(), fresco::Error);
        check_cuts_are_refused(bytes, "cut.npy", [](const auto& cut) { fresco::parse_npy(cut, "cut.npy"); });
        bytes.push_back(std::byte{0});
        CHECK_THROWS_WITH(fresco::parse_npy(bytes, "long.npy"), Catch::Contains("long.npy"));
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
    const auto refused = [&](const std::string& old, const std::string& other, const std::string& reason)
    {
        std::string changed = file;
        changed.replace(changed.find(old), other.size(), other);
        CHECK_THROWS_WITH(parse(changed), Catch::Contains("n.npy: byte ") && Catch::Contains(reason));
    };
    refused("False", "True ", "ascontiguousarray");
    refused("|u1", ">u2", "not supported");
    refused("(3,), }", "(99999999999999, 9999999999), }", "too large");
    refused("(3,), ", "(-1,),", "n.npy: byte 61: expected at most 8 numbers");
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
