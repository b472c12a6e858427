#include <fresco/torch/tensor_memory.h>

#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <unistd.h>

// Last: libtorch's headers bring a macro CHECK of their own.
#include "catch.h"

using namespace fresco;

namespace
{

constexpr std::int64_t rows = 100000;

/// Pages that the mapping with `tensor`, which may hold others too, takes memory for; read ones that are zero take none.
std::size_t pages_with(const torch::Tensor& tensor)
{
    const auto place = reinterpret_cast<std::uintptr_t>(tensor.data_ptr());
    std::ifstream maps("/proc/self/smaps");
    bool here = false;
    for (std::string line; std::getline(maps, line);)
    {
        unsigned long begin = 0;
        unsigned long end = 0;
        unsigned long kilobytes = 0;
        if (std::sscanf(line.c_str(), "%lx-%lx ", &begin, &end) == 2)
            here = begin <= place && place < end;
        else if (here && std::sscanf(line.c_str(), "Anonymous: %lu kB", &kilobytes) == 1)
            return kilobytes * 1024 / static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    }
    return 0;
}

/// Whether this machine's kernel takes memory for pages that are only read, too, as some virtual machines' does.
bool reading_takes_memory()
{
    const auto tensor = lazy_zeros({rows, 3}, at::kFloat);
    const auto before = pages_with(tensor);
    return tensor.sum().item<float>() == 0 && pages_with(tensor) > before;
}

}  // namespace

TEST_CASE("lazy zeros take memory where they are written")
{
    const auto tensor = lazy_zeros({rows, 3}, at::kFloat);
    CHECK(tensor.sizes() == at::IntArrayRef{rows, 3});
    CHECK(tensor.is_contiguous());
    const auto before = pages_with(tensor);
    tensor[rows / 2][1] = 4.0F;
    CHECK(pages_with(tensor) == before + 1);
    CHECK(tensor.sum().item<float>() == 4.0F);
    CHECK(lazy_zeros({0, 3}, at::kInt).numel() == 0);
}

TEST_CASE("values are written where they differ, to the last bit")
{
    auto to = lazy_zeros({rows, 3}, at::kFloat);
    const auto from = at::zeros({rows, 3}, at::kFloat);
    from[7][0] = -0.0F;
    from[rows - 1][2] = 3.0F;
    const auto before = pages_with(to);
    write_values(from, to);
    CHECK((pages_with(to) == before + 2 || reading_takes_memory()));
    CHECK(std::signbit(to[7][0].item<float>()));
    CHECK(at::equal(from, to));

    write_zeros(to);
    CHECK(at::equal(to, at::zeros({rows, 3})));
    CHECK_FALSE(std::signbit(to[7][0].item<float>()));
    CHECK_THROWS_AS(write_values(at::zeros({rows, 2}), to), std::invalid_argument);
    CHECK_THROWS_AS(write_values(from.t(), to), std::invalid_argument);
}

TEST_CASE("values are clamped where they lie outside")
{
    auto values = lazy_zeros({rows, 3}, at::kFloat);
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    values.slice(0, 0, 2).copy_(at::tensor({5.0F, -5.0F, 0.5F, inf, nan, 1.0F}).view({2, 3}));
    const auto pages = pages_with(values);
    write_clamped(values, -2, 1);
    CHECK((pages_with(values) == pages || reading_takes_memory()));
    CHECK(at::equal(values[0], at::tensor({1.0F, -2.0F, 0.5F})));
    CHECK((values[1][0].item<float>() == 1 && std::isnan(values[1][1].item<float>())));
}

namespace
{

constexpr std::int64_t megabyte = 1 << 20;

torch::Tensor filled(std::int64_t megabytes, int value)
{
    return at::full({megabytes * megabyte}, value, at::kChar);
}

bool holds(const torch::Tensor& tensor, int value)
{
    return at::equal(tensor, at::full(tensor.sizes(), value, at::kChar));
}

}  // namespace

TEST_CASE("tensors of other sizes get the pages of those that are gone")
{
    reuse_tensor_memory();
    // The references of the checks take memory too, once.
    CHECK(holds(filled(64, 1), 1));
    const std::size_t before = reused_tensor_bytes();
    for (int round = 0; round < 3; ++round)
    {
        std::vector<torch::Tensor> kept;
        for (int i = 0; i < 8; ++i)
            kept.push_back(filled(4, i));
        // Holes between tensors that stay, none as large as what comes.
        for (const std::size_t i : {0U, 2U, 4U, 6U})
            kept[i] = torch::Tensor();
        const auto large = filled(16, 9);
        CHECK(reused_tensor_bytes() == before);
        CHECK(large.eq(9).all().item<bool>());
        for (const int i : {1, 3, 5, 7})
            CHECK(kept[static_cast<std::size_t>(i)].eq(i).all().item<bool>());
    }
    // Small and empty ones lie elsewhere.
    CHECK(holds(at::ones({10}, at::kChar), 1));
    CHECK(filled(0, 1).numel() == 0);
    CHECK(reused_tensor_bytes() == before);
}
