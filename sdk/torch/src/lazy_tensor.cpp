#include <fresco/torch/lazy_tensor.h>

#include <fresco/parallel.h>

#include <ATen/Parallel.h>
#include <ATen/ops/from_blob.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <new>
#include <stdexcept>

#include <sys/mman.h>

namespace fresco
{
namespace
{

/// Of the usual page; where pages are larger, more is read for each that is written.
constexpr std::size_t run = 4096;

std::size_t size_in_bytes(at::IntArrayRef shape, at::ScalarType type)
{
    std::size_t size = c10::elementSize(type);
    for (const auto extent : shape)
        size *= static_cast<std::size_t>(extent);
    return size;
}

void check(const torch::Tensor& tensor)
{
    if (!tensor.device().is_cpu() || !tensor.is_contiguous())
        throw std::invalid_argument("write_values, write_zeros and write_clamped take contiguous tensors on the CPU");
}

/// Writes the runs of `to` whose bytes are not those that `from` has at their offset.
template <class From>
void write_differences(torch::Tensor& to, const From& from)
{
    auto* bytes = static_cast<std::byte*>(to.data_ptr());
    const std::size_t size = to.nbytes();
    for (std::size_t begin = 0; begin < size; begin += run)
    {
        const std::size_t count = std::min(run, size - begin);
        if (std::memcmp(bytes + begin, from(begin), count) != 0)
            std::memcpy(bytes + begin, from(begin), count);
    }
}

}  // namespace

torch::Tensor lazy_zeros(at::IntArrayRef shape, at::ScalarType type)
{
    const std::size_t size = std::max<std::size_t>(size_in_bytes(shape, type), 1);
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED)
        throw std::bad_alloc();
#if defined(MADV_NOHUGEPAGE)
    // Else one value that is written could take 2 MB. Only advice: what comes back does not matter.
    ::madvise(memory, size, MADV_NOHUGEPAGE);
#endif
    return at::from_blob(
        memory, shape, [size](void* begin) { ::munmap(begin, size); }, at::TensorOptions(type));
}

void write_values(const torch::Tensor& from, torch::Tensor& to)
{
    check(from);
    if (from.sizes() != to.sizes() || from.scalar_type() != to.scalar_type())
        throw std::invalid_argument("write_values takes two tensors of one shape and type");
    if (!to.device().is_cpu())
    {
        to.copy_(from);
        return;
    }
    write_bytes({static_cast<const std::byte*>(from.data_ptr()), from.nbytes()}, to);
}

void write_bytes(std::span<const std::byte> from, torch::Tensor& to)
{
    check(to);
    if (from.size() != to.nbytes())
        throw std::invalid_argument("write_bytes takes as many bytes as the tensor has");
    write_differences(to, [from](std::size_t begin) { return from.data() + begin; });
}

void write_zeros(torch::Tensor& to)
{
    static constexpr std::array<std::byte, run> zeros{};
    if (!to.device().is_cpu())
    {
        to.zero_();
        return;
    }
    check(to);
    write_differences(to, [](std::size_t) { return zeros.data(); });
}

void write_clamped(torch::Tensor& to, float least, float most)
{
    constexpr std::size_t values_per_piece = 65536;
    if (!to.device().is_cpu())
    {
        to.clamp_(least, most);
        return;
    }
    check(to);
    float* values = to.data_ptr<float>();
    parallel_for(static_cast<std::size_t>(to.numel()), values_per_piece, at::get_num_threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         if (values[i] < least || values[i] > most)
                             values[i] = values[i] < least ? least : most;
                 });
}

}  // namespace fresco
