#include <fresco/torch/tensor_memory.h>

#include <fresco/parallel.h>

#include <ATen/Parallel.h>
#include <ATen/ops/from_blob.h>
#include <c10/core/CPUAllocator.h>
#include <c10/util/accumulate.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <stdexcept>
#include <unordered_map>

#include <sys/mman.h>

namespace fresco
{
namespace
{

/// Size of the usual page; with larger pages, more is read for each page that is written.
constexpr std::size_t run = 4096;

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
    const std::size_t size =
        std::max<std::size_t>(c10::elementSize(type) * static_cast<std::size_t>(c10::multiply_integers(shape)), 1);
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED)
        throw std::bad_alloc();
    // Else one value that is written could take 2 MB. Only advice: what comes back does not matter.
    ::madvise(memory, size, MADV_NOHUGEPAGE);
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

namespace
{

/// A huge page: such pages are moved and cleared much faster.
constexpr std::size_t chunk = std::size_t{1} << 21U;

/// `count` chunks of new memory, aligned to one. Null if memory is used up.
std::byte* new_chunks(std::size_t count)
{
    const std::size_t size = (count + 1) * chunk;
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED)
        return nullptr;
    auto* begin = static_cast<std::byte*>(memory);
    const std::size_t before = (chunk - reinterpret_cast<std::uintptr_t>(begin) % chunk) % chunk;
    if (before > 0)
        ::munmap(begin, before);
    ::munmap(begin + before + count * chunk, chunk - before);
    ::madvise(begin + before, count * chunk, MADV_HUGEPAGE);
    return begin + before;
}

/// Whole chunks of memory. What is given back is kept; where no piece of it is large enough, a new place in the address space
/// gets the pages of several. Thread-safe.
class Chunks
{
  public:
    std::byte* take(std::size_t count)
    {
        const std::lock_guard lock(mutex_);
        const auto fitting = waiting_.lower_bound(count);
        std::byte* const place = fitting != waiting_.end() ? cut(fitting, count) : gathered(count);
        if (place != nullptr)
            taken_.emplace(place, count);
        return place;
    }

    /// False where `place` is not of take().
    bool give_back(std::byte* place)
    {
        const std::lock_guard lock(mutex_);
        const auto found = taken_.find(place);
        if (found == taken_.end())
            return false;
        waiting_.emplace(found->second, place);
        taken_.erase(found);
        return true;
    }

    std::size_t held() const
    {
        const std::lock_guard lock(mutex_);
        return held_;
    }

  private:
    using Waiting = std::multimap<std::size_t, std::byte*>;

    /// The first `count` chunks of a piece.
    std::byte* cut(Waiting::iterator piece, std::size_t count)
    {
        const auto [size, place] = *piece;
        waiting_.erase(piece);
        if (size > count)
            waiting_.emplace(size - count, place + count * chunk);
        return place;
    }

    std::byte* gathered(std::size_t count)
    {
        std::byte* place = new_chunks(count);
        if (place == nullptr)
            return nullptr;
        std::size_t filled = 0;
        for (; filled < count && !waiting_.empty(); ++filled)
        {
            // The smallest piece: large ones may serve whole another time.
            const auto piece = waiting_.begin();
            const std::size_t last = piece->first - 1;
            // One by one: what was gathered itself can be moved in no other way.
            std::byte* from = piece->second + last * chunk;
            if (::mremap(from, chunk, chunk, MREMAP_MAYMOVE | MREMAP_FIXED, place + filled * chunk) == MAP_FAILED)
                break;
            const auto rest = piece->second;
            waiting_.erase(piece);
            if (last > 0)
                waiting_.emplace(last, rest);
        }
        held_ += (count - filled) * chunk;
        return place;
    }

    mutable std::mutex mutex_;
    Waiting waiting_;  ///< By size.
    std::unordered_map<std::byte*, std::size_t> taken_;
    std::size_t held_ = 0;
};

/// Never destroyed: tensors may outlive everything else.
Chunks& chunks()
{
    static auto& all = *new Chunks;
    return all;
}

void release(void* memory)
{
    if (!chunks().give_back(static_cast<std::byte*>(memory)))
        std::free(memory);
}

/// libtorch 2.3 dropped a const and added a function: what this version's base does not have is only one more function.
class Allocator final : public c10::Allocator
{
  public:
    c10::DataPtr allocate(std::size_t size) const { return allocated(size); }
    c10::DataPtr allocate(std::size_t size) { return allocated(size); }
    void copy_data(void* to, const void* from, std::size_t size) const { std::memcpy(to, from, size); }
    c10::DeleterFnPtr raw_deleter() const { return &release; }

  private:
    static c10::DataPtr allocated(std::size_t size)
    {
        constexpr std::size_t alignment = 64;
        void* memory = nullptr;
        if (size >= chunk)
            memory = chunks().take((size + chunk - 1) / chunk);
        else if (size > 0)
            memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
        if (memory == nullptr && size > 0)
            throw std::bad_alloc();
        return {memory, memory, &release, c10::Device(c10::kCPU)};
    }
};

}  // namespace

void reuse_tensor_memory()
{
    static std::once_flag once;
    std::call_once(once, [] { c10::SetCPUAllocator(new Allocator); });
}

std::size_t reused_tensor_bytes()
{
    return chunks().held();
}

}  // namespace fresco
