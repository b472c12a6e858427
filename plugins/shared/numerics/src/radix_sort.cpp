#include <fresco/numerics/radix_sort.h>

#include <array>
#include <cstddef>

namespace fresco::numerics
{

void sort_by_upper_half(std::vector<std::uint64_t>& entries, std::uint32_t largest)
{
    constexpr unsigned digit_bits = 11;
    constexpr std::size_t buckets = std::size_t{1} << digit_bits;
    std::vector<std::uint64_t> sorted(entries.size());
    for (unsigned shift = 0; shift < 32 && (largest >> shift) != 0; shift += digit_bits)
    {
        const auto digit = [shift](std::uint64_t entry)
        { return static_cast<std::size_t>(entry >> (32 + shift)) & (buckets - 1); };
        std::array<std::size_t, buckets + 1> starts{};
        for (const auto entry : entries)
            ++starts[digit(entry) + 1];
        for (std::size_t i = 1; i <= buckets; ++i)
            starts[i] += starts[i - 1];
        for (const auto entry : entries)
            sorted[starts[digit(entry)]++] = entry;
        entries.swap(sorted);
    }
}

}  // namespace fresco::numerics
