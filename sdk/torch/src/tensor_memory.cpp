#include <fresco/torch/tensor_memory.h>

#if defined(__linux__)

#include <c10/core/CPUAllocator.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <unordered_map>

#include <sys/mman.h>

namespace fresco
{
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
        std::byte* place = nullptr;
        if (const auto fitting = waiting_.lower_bound(count); fitting != waiting_.end())
            place = cut(fitting, count);
        else
            place = gathered(count);
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
    static const bool done = []
    {
        c10::SetCPUAllocator(new Allocator);
        return true;
    }();
    static_cast<void>(done);
}

std::size_t reused_tensor_bytes()
{
    return chunks().held();
}

}  // namespace fresco

#else

void fresco::reuse_tensor_memory() {}

std::size_t fresco::reused_tensor_bytes()
{
    return 0;
}

#endif
