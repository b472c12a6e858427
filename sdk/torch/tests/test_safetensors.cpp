#include "catch.h"

#include <fresco/torch/tensor.h>

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>

#include <cstring>
#include <string>

using namespace fresco;

namespace
{

/// A file with the given header text and `data` after it.
std::string file_text(const std::string& header, const std::string& data)
{
    const std::uint64_t length = header.size();
    std::string text(8, '\0');
    std::memcpy(text.data(), &length, 8);
    return text + header + data;
}

struct File
{
    testing::TemporaryFolder folder;
    std::filesystem::path path = folder.path() / "t.safetensors";

    SafeTensors read(const std::string& bytes) const
    {
        write_file(path, bytes);
        return read_safetensors(path);
    }
};

}  // namespace

TEST_CASE("every type that is written is read back")
{
    const File file;
    SafeTensors contents;
    for (const auto type : {at::kFloat, at::kDouble, at::kInt, at::kLong, at::kByte, at::kBool})
        contents.tensors.emplace(std::string("t.") + at::toString(type),
                                 at::arange(0, 6, at::kLong).remainder(2).reshape({2, 3}).to(type));
    contents.tensors.emplace("scalar", at::full({}, 2.5, at::kFloat));
    contents.tensors.emplace("empty", at::zeros({0, 3}, at::kFloat));
    contents.tensors.emplace("strided", at::arange(0, 12, at::kFloat).reshape({3, 4}).t());
    contents.metadata = {{"step", "7"}, {"quote", "\"\n"}};
    write_safetensors(file.path, contents);
    const auto read = read_safetensors(file.path);
    CHECK(read.metadata == contents.metadata);
    REQUIRE(read.tensors.size() == contents.tensors.size());
    for (const auto& [name, tensor] : contents.tensors)
    {
        CAPTURE(name);
        REQUIRE(read.tensors.count(name) == 1);
        CHECK(read.tensors.at(name).scalar_type() == tensor.scalar_type());
        CHECK(at::equal(read.tensors.at(name), tensor));
    }
    const auto first = read_file(file.path);
    write_safetensors(file.path, read);
    CHECK((read_file(file.path) == first));
    contents.tensors.emplace("half", at::zeros({1}, at::kHalf));
    CHECK_THROWS_AS(write_safetensors(file.path, contents), std::invalid_argument);
    CHECK((read_file(file.path) == first));
}

TEST_CASE("a file made by hand is read, half precision too, and refused by name when it is cut")
{
    const File file;
    const std::string text = file_text(
        R"({"b":{"dtype":"F16","shape":[1],"data_offsets":[0,2]},"a":{"dtype":"I8","shape":[1,1],"data_offsets":[2,3]}}  )",
        std::string("\x00\x3c\xff", 3));
    const auto read = file.read(text);
    CHECK(read.tensors.at("b").to(at::kFloat).item<float>() == 1.0F);
    CHECK(read.tensors.at("a").to(at::kLong).item<std::int64_t>() == -1);
    // Every kind of damage is tested where the bytes are read: sdk/weights.
    CHECK_THROWS_WITH(file.read(text.substr(0, text.size() - 1)), Catch::Contains("t.safetensors: "));
}
