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
    for (const char version : {'\1', '\2', '\3'})
    {
        std::string other = file;
        other[6] = version;
        other.insert(10, version == '\1' ? 0 : 2, '\0');
        CHECK(parse(other).count() == 3);
    }
    std::string fourth = file;
    fourth[6] = 4;
    CHECK_THROWS_WITH(parse(fourth), Catch::Contains("n.npy: byte 6: NPY version 4"));
    refused("|u1", ">u2", "not supported");
    refused("(3,), }", "(99999999999999, 9999999999), }", "too large");
    refused("(3,), ", "(-1,),", "n.npy: byte 61: expected at most 8 numbers");
}

TEST_CASE("NPY in Fortran order is read in C order, by every rank and size of elements")
{
    const auto fortran = [](NpyType type, const std::vector<std::size_t>& shape, const auto& values)
    {
        auto bytes = fresco::to_npy(type, shape, std::as_bytes(std::span(values)));
        const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        const std::size_t at = text.find("False");
        for (std::size_t i = 0; i < 5; ++i)
            bytes[at + i] = static_cast<std::byte>("True "[i]);
        return fresco::parse_npy(bytes, "f.npy");
    };
    // Element (i, j, k) is 100 i + 10 j + k.
    std::vector<std::uint16_t> values;
    std::vector<std::uint16_t> expected;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 2; ++i)
                values.push_back(static_cast<std::uint16_t>(100 * i + 10 * j + k));
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 4; ++k)
                expected.push_back(static_cast<std::uint16_t>(100 * i + 10 * j + k));
    const auto array = fortran(NpyType::uint16, {2, 3, 4}, values);
    CHECK(array.shape == std::vector<std::size_t>{2, 3, 4});
    CHECK(std::ranges::equal(array.as<std::uint16_t>(), expected));
    CHECK(std::ranges::equal(fortran(NpyType::float64, {2, 2}, std::vector<double>{1, 2, 3, 4}).as<double>(),
                             std::vector<double>{1, 3, 2, 4}));
    CHECK(std::ranges::equal(fortran(NpyType::uint16, {24}, values).as<std::uint16_t>(), values));
    CHECK(fortran(NpyType::uint8, {}, std::vector<std::uint8_t>{7}).as<std::uint8_t>()[0] == 7);
    CHECK(fortran(NpyType::uint8, {0, 4}, std::vector<std::uint8_t>{}).count() == 0);
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
