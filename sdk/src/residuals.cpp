#include "residuals.h"

#include <algorithm>
#include <cstring>

namespace fresco::detail
{
namespace
{

constexpr std::uint8_t is_large = 255;

// The loops below run over one row and touch no memory but their arguments', so that the compiler may vectorize them.

/// The differences of the steps from the row above to this one, along the row. A step goes on as it was over invalid pixels,
/// whose difference so becomes 0; `above` becomes this row.
void differences(const std::uint32_t* __restrict values, const std::uint8_t* __restrict valid, std::size_t width,
                 std::uint32_t* __restrict above, std::uint32_t* __restrict out)
{
    std::uint32_t step = 0;
    for (std::size_t x = 0; x < width; ++x)
    {
        const std::uint32_t before = step;
        const std::uint32_t own = values[x] - above[x];
        step = valid[x] != 0 ? own : step;
        above[x] += step;
        out[x] = step - before;
    }
}

/// 0, -1, 1, -2, 2 … as 0, 1, 2, 3, 4 …, of differences that count modulo 2^bits.
void fold(std::uint32_t* __restrict numbers, std::size_t width, int bits)
{
    const int unused = 32 - bits;
    for (std::size_t x = 0; x < width; ++x)
    {
        const auto difference = static_cast<std::int32_t>(numbers[x] << unused) >> unused;
        numbers[x] = (static_cast<std::uint32_t>(difference) << 1U) ^ static_cast<std::uint32_t>(difference >> 31);
    }
}

void unfold(std::uint32_t* __restrict numbers, std::size_t width)
{
    for (std::size_t x = 0; x < width; ++x)
        numbers[x] = (numbers[x] >> 1U) ^ (0U - (numbers[x] & 1U));
}

/// Takes the lowest bits off.
void split(std::uint32_t* __restrict numbers, std::size_t width, int extra, std::uint8_t* __restrict out)
{
    const std::uint32_t mask = (1U << extra) - 1;
    for (std::size_t x = 0; x < width; ++x)
    {
        out[x] = static_cast<std::uint8_t>(numbers[x] & mask);
        numbers[x] >>= extra;
    }
}

void join(std::uint32_t* __restrict numbers, std::size_t width, int extra, const std::uint8_t* __restrict bits)
{
    for (std::size_t x = 0; x < width; ++x)
        numbers[x] = numbers[x] << extra | bits[x];
}

void to_bytes(const std::uint32_t* __restrict numbers, std::size_t width, std::uint8_t* __restrict out)
{
    for (std::size_t x = 0; x < width; ++x)
    {
        const auto number = static_cast<std::int32_t>(numbers[x]);
        out[x] = static_cast<std::uint8_t>(number < is_large ? number : is_large);
    }
}

void from_bytes(const std::uint8_t* __restrict bytes, std::size_t width, std::uint32_t* __restrict out)
{
    for (std::size_t x = 0; x < width; ++x)
        out[x] = bytes[x];
}

/// Sums along the row are the steps from the row above; `above` becomes this row.
void add_up(std::uint32_t* __restrict differences, std::size_t width, std::uint32_t* __restrict above, std::uint32_t mask,
            std::uint32_t* __restrict out)
{
    std::uint32_t step = 0;
    for (std::size_t x = 0; x < width; ++x)
    {
        step += differences[x];
        differences[x] = step;
    }
    for (std::size_t x = 0; x < width; ++x)
    {
        above[x] += differences[x];
        out[x] = above[x] & mask;
    }
}

/// Calls visit(x) for every byte that says that its number is elsewhere.
template <class Visit>
void for_each_large(const std::uint8_t* low, std::size_t width, const Visit& visit)
{
    const std::uint8_t* const end = low + width;
    const std::uint8_t* at = low;
    while (at != end && (at = static_cast<const std::uint8_t*>(std::memchr(at, is_large, static_cast<std::size_t>(end - at)))))
        visit(static_cast<std::size_t>(at++ - low));
}

}  // namespace

ResidualEncoder::ResidualEncoder(int width, int height, int bits)
    : width_(static_cast<std::size_t>(width)), bits_(bits), above_(width_), numbers_(width_)
{
    const std::size_t pixels = width_ * static_cast<std::size_t>(height);
    planes_.low.resize(pixels);
    if (extra_bits(bits) > 0)
        planes_.extra.resize(pixels);
}

void ResidualEncoder::row(const std::uint32_t* values, const std::uint8_t* valid)
{
    differences(values, valid, width_, above_.data(), numbers_.data());
    fold(numbers_.data(), width_, bits_);
    if (const int extra = extra_bits(bits_); extra > 0)
        split(numbers_.data(), width_, extra, planes_.extra.data() + next_);
    std::uint8_t* low = planes_.low.data() + next_;
    to_bytes(numbers_.data(), width_, low);
    next_ += width_;
    if (bits_ > 8)
        for_each_large(low, width_, [&](std::size_t x) { large_.push_back(static_cast<std::uint16_t>(numbers_[x])); });
}

ResidualPlanes ResidualEncoder::planes() &&
{
    for (const std::uint16_t number : large_)
        planes_.large.push_back(static_cast<std::uint8_t>(number & 255U));
    for (const std::uint16_t number : large_)
        planes_.large.push_back(static_cast<std::uint8_t>(number >> 8U));
    return std::move(planes_);
}

std::size_t count_large(std::span<const std::uint8_t> low, int bits)
{
    std::size_t count = 0;
    if (bits > 8)
        for (std::size_t begin = 0; begin < low.size(); begin += 255)
        {
            // Short enough for a sum in a byte, which compilers add sixteen at a time.
            std::uint8_t found = 0;
            for (const std::uint8_t byte : low.subspan(begin, std::min<std::size_t>(255, low.size() - begin)))
                found = static_cast<std::uint8_t>(found + (byte == is_large));
            count += found;
        }
    return count;
}

ResidualDecoder::ResidualDecoder(int width, int bits, const std::uint8_t* low, const std::uint8_t* extra,
                                 std::span<const std::uint8_t> large)
    : width_(static_cast<std::size_t>(width)), bits_(bits), low_(low), extra_(extra), large_low_(large.data()),
      large_high_(large.data() + large.size() / 2), above_(width_), numbers_(width_), values_(width_)
{
}

const std::uint32_t* ResidualDecoder::row()
{
    from_bytes(low_, width_, numbers_.data());
    if (bits_ > 8)
        for_each_large(low_, width_,
                       [&](std::size_t x) { numbers_[x] = *large_low_++ | static_cast<unsigned>(*large_high_++) << 8U; });
    low_ += width_;
    if (const int extra = extra_bits(bits_); extra > 0)
    {
        join(numbers_.data(), width_, extra, extra_);
        extra_ += width_;
    }
    unfold(numbers_.data(), width_);
    add_up(numbers_.data(), width_, above_.data(), (1U << bits_) - 1, values_.data());
    return values_.data();
}

}  // namespace fresco::detail
