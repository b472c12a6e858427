#include "cut_bytes.h"
#include "made_weights.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>

using namespace fresco::weights;

namespace
{

std::string state_dict_error(std::span<const std::byte> bytes)
{
    return fresco::testing::error_of([&] { parse_state_dict(bytes, "w.pth"); });
}

}  // namespace

TEST_CASE("State dicts of every age and protocol are read")
{
    for (const std::string& name :
         std::vector<std::string>{"legacy.pth", "legacy_old.pth", "legacy_parameters.pth", "legacy_protocol4.pth",
                                  "legacy_double.pth", "zip.pth", "zip_half.pth", "zip_protocol4.pth", "zip_wrapped.pth"})
    {
        CAPTURE(name);
        const auto file = read_weights(made_weights() / name);
        REQUIRE(file.contents.tensors.size() == 2);
        CHECK(file.contents.tensors[0].name == "features.0.weight");
        CHECK(file.contents.tensors[0].shape == std::vector<std::size_t>{64, 3, 3, 3});
        CHECK(file.contents.tensors[1].name == "features.0.bias");
        CHECK(file.contents.form == (name.starts_with("zip") ? Form::zip_pickle : Form::legacy_pickle));
        const auto weight = to_float32(file.contents.tensors[0], name);
        const auto bias = to_float32(file.contents.tensors[1], name);
        REQUIRE(weight.size() == 64 * 27);
        REQUIRE(bias.size() == 64);
        // Numbers below 2 in 64ths fit half precision too. The bias begins at the sixth element of its storage.
        for (std::size_t i = 0; i < weight.size(); ++i)
            REQUIRE(weight[i] == made_number(i));
        for (std::size_t i = 0; i < bias.size(); ++i)
            REQUIRE(bias[i] == made_number(i + 12));
    }
}

TEST_CASE("What no state dict needs is refused by name, and nothing is executed")
{
    const auto refused = [](const std::string& name, const std::string& what)
    {
        CAPTURE(name);
        CHECK_THROWS_WITH(read_weights(made_weights() / name), Contains(name) && Contains(what));
    };
    refused("bad_evil.pth", "eval");
    refused("bad_type.pth", "torch.OtherStorage");
    refused("bad_compressed.pth", "compressed");
    refused("bad_script.pth", "TorchScript");
    refused("bad_two.pth", "two entries");
    refused("bad_nested.pth", "'epoch' is not a tensor");
    CHECK_THROWS_AS(read_weights(made_weights() / "none.pth"), fresco::MissingInput);
}

TEST_CASE("A file cut anywhere is refused")
{
    for (const char* name : {"legacy.pth", "legacy_parameters.pth", "zip.pth"})
        check_cuts_are_refused(made_bytes(name), name, [&](const auto& cut) { parse_state_dict(cut, name); });
}

TEST_CASE("Wrong bytes in the elements of a zip archive are found")
{
    auto bytes = made_bytes("zip.pth");
    const float number = made_number(100);
    const auto pattern = std::as_bytes(std::span(&number, 1));
    const auto place = std::search(bytes.begin() + 2000, bytes.end(), pattern.begin(), pattern.end());
    REQUIRE(place != bytes.end());
    *place ^= std::byte{1};
    CHECK_THAT(state_dict_error(bytes), Contains("checksum"));
}

TEST_CASE("The format is recognized by the first bytes")
{
    CHECK_THAT(state_dict_error({}), Contains("safetensors"));
    CHECK_THAT(state_dict_error(bytes_of("PK")), Contains("zip"));
    CHECK_THAT(state_dict_error(bytes_of("\x80\x02")), Contains("pickle ends"));
    CHECK_THAT(state_dict_error(bytes_of(std::string(257, 'x') + "ustar")), Contains("tar archive"));
    // A safetensors header of 128 bytes begins like a pickle.
    std::string header = R"({"a":{"dtype":"U8","shape":[1],"data_offsets":[0,1]}})";
    header.resize(128, ' ');
    const auto bytes = bytes_of(std::string("\x80\0\0\0\0\0\0\0", 8) + header + "x");
    CHECK(parse_state_dict(bytes, "w").find("a") != nullptr);
}

TEST_CASE("Half precision, the other types and what is not finite")
{
    const auto value = [](ElementType type, const std::string& text)
    {
        const auto bytes = bytes_of(text);
        return to_float32({"t", type, {1}, bytes}, "w").at(0);
    };
    CHECK(value(ElementType::float16, std::string("\x00\x3c", 2)) == 1.0F);
    CHECK(value(ElementType::float16, std::string("\x00\xc0", 2)) == -2.0F);
    CHECK(value(ElementType::float16, std::string("\x01\x00", 2)) == std::ldexp(1.0F, -24));
    CHECK(value(ElementType::float16, std::string("\xff\x7b", 2)) == 65504.0F);
    CHECK(value(ElementType::bfloat16, std::string("\x20\x40", 2)) == 2.5F);
    CHECK_THROWS_WITH(value(ElementType::float16, std::string("\x00\x7c", 2)), Contains("finite") && Contains("'t'"));
    CHECK_THROWS_WITH(value(ElementType::float32, std::string("\x00\x00\xc0\x7f", 4)), Contains("finite"));
    CHECK_THROWS_WITH(value(ElementType::int32, "abcd"), Contains("floating-point"));
}

TEST_CASE("Every number of half precision is read")
{
    for (std::uint32_t bits = 0; bits < 0x10000; ++bits)
    {
        if ((bits & 0x7c00U) == 0x7c00U)
            continue;
        const auto half = static_cast<std::uint16_t>(bits);
        const TensorView tensor{"t", ElementType::float16, {1}, std::as_bytes(std::span(&half, 1))};
        const int exponent = static_cast<int>(bits >> 10U & 31U);
        const double units = (bits & 1023U) + (exponent > 0 ? 1024.0 : 0.0);
        const double size = std::ldexp(units, std::max(exponent, 1) - 25);
        if (to_float32(tensor, "w").front() != (bits < 0x8000U ? size : -size))
            FAIL("number " << bits);
    }
}
