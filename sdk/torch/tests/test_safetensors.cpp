#include "catch.h"

#include <fresco/torch/tensor.h>

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>

#include <span>
#include <string>

using namespace fresco;

TEST_CASE("every type that is written is read back")
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "t.safetensors";
    SafeTensors contents;
    for (const auto type :
         {at::kFloat, at::kDouble, at::kHalf, at::kBFloat16, at::kInt, at::kLong, at::kShort, at::kByte, at::kChar, at::kBool})
        contents.tensors.emplace(std::string("t.") + at::toString(type),
                                 at::arange(0, 6, at::kLong).remainder(2).reshape({2, 3}).to(type));
    contents.tensors.emplace("scalar", at::full({}, 2.5, at::kFloat));
    contents.tensors.emplace("empty", at::zeros({0, 3}, at::kFloat));
    contents.tensors.emplace("strided", at::arange(0, 12, at::kFloat).reshape({3, 4}).t());
    contents.metadata = {{"step", "7"}, {"quote", "\"\n"}};
    write_safetensors(file, contents);
    const auto read = read_safetensors(file);
    CHECK(read.metadata == contents.metadata);
    REQUIRE(read.tensors.size() == contents.tensors.size());
    for (const auto& [name, tensor] : contents.tensors)
    {
        CAPTURE(name);
        REQUIRE(read.tensors.count(name) == 1);
        CHECK(read.tensors.at(name).scalar_type() == tensor.scalar_type());
        CHECK(at::equal(read.tensors.at(name), tensor));
    }
    const auto first = read_file(file);
    write_safetensors(file, read);
    CHECK((read_file(file) == first));
    contents.tensors.emplace("complex", at::zeros({1}, at::kComplexFloat));
    CHECK_THROWS_AS(write_safetensors(file, contents), std::invalid_argument);
    CHECK((read_file(file) == first));
    // Every kind of damage is tested where the bytes are read: sdk/weights.
    write_file(file, std::span(first).first(first.size() - 1));
    CHECK_THROWS_WITH(read_safetensors(file), Contains("t.safetensors: "));
}
