#include "lzfse.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <string>
#include <utility>

/// \file The names are those of Apple's published format (lzfse_internal.h): a match copies M bytes from the distance D back,
/// after L literals. L, M, D and the literals are coded by finite state entropy (Duda, "Asymmetric numeral systems", 2013).

namespace record3d
{
namespace
{

using fresco::Error;
using fresco::recordings::ByteCursor;
using Bytes = std::span<const std::byte>;

constexpr std::size_t literals_of_block = 40000;
constexpr std::size_t matches_of_block = 10000;

/// The bytes that were unpacked so far.
class Unpacked
{
  public:
    Unpacked(std::size_t size, std::string_view source) : size_(size), source_(source) { bytes_.reserve(size); }

    [[noreturn]] void fail(std::size_t offset, std::string_view what) const
    {
        throw Error(fmt::format("{}: byte offset {}: {}: the file is damaged; copy it again", source_, offset, what));
    }
    void append(Bytes literals, std::size_t offset)
    {
        check_room(literals.size(), offset);
        bytes_.insert(bytes_.end(), literals.begin(), literals.end());
    }
    void repeat(std::size_t distance, std::size_t count, std::size_t offset)
    {
        check_room(count, offset);
        if (count > 0 && (distance == 0 || distance > bytes_.size()))
            fail(offset, "a repetition of what is before the beginning");
        for (std::size_t i = 0; i < count; ++i)
            bytes_.push_back(bytes_[bytes_.size() - distance]);
    }
    std::size_t count() const { return bytes_.size(); }
    std::size_t size() const { return size_; }
    std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    void check_room(std::size_t count, std::size_t offset) const
    {
        if (count > size_ - bytes_.size())
            fail(offset, fmt::format("more than the {} bytes that were expected", size_));
    }

    std::size_t size_;
    std::string source_;
    std::vector<std::byte> bytes_;
};

std::uint64_t bits_of(std::uint64_t word, unsigned first, unsigned count)
{
    return word >> first & ((std::uint64_t{1} << count) - 1);
}

/// Bits of a payload from its last one down; `unused` of them lie above the first.
class BitsFromEnd
{
  public:
    BitsFromEnd(Bytes payload, unsigned unused) : payload_(payload), left_(8 * payload.size())
    {
        is_short_ = unused > left_;
        left_ -= is_short_ ? 0 : unused;
    }
    std::uint32_t pull(unsigned count)
    {
        if (count > left_)
        {
            is_short_ = true;
            return 0;
        }
        left_ -= count;
        std::uint64_t word = 0;
        const std::size_t first = left_ / 8;
        for (std::size_t i = 0; i < 5 && first + i < payload_.size(); ++i)
            word |= std::to_integer<std::uint64_t>(payload_[first + i]) << (8 * i);
        return static_cast<std::uint32_t>(bits_of(word, left_ % 8, count));
    }
    void end() { is_short_ = true; }
    bool is_short() const { return is_short_; }  ///< More bits were pulled than are there.

  private:
    Bytes payload_;
    std::size_t left_;
    bool is_short_ = false;
};

/// A symbol stands for its base plus extra bits.
struct SymbolValue
{
    unsigned extra_bits = 0;
    std::uint32_t base = 0;
};

/// The values of symbols whose extra bits are `extra_bits`: they follow each other without a gap.
template <std::size_t N>
std::array<SymbolValue, N> values_of(const std::array<unsigned, N>& extra_bits)
{
    std::array<SymbolValue, N> values;
    std::uint32_t base = 0;
    for (std::size_t i = 0; i < N; ++i)
    {
        values[i] = {extra_bits[i], base};
        base += 1U << extra_bits[i];
    }
    return values;
}

const auto literal_lengths = values_of<20>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 3, 5, 8});
const auto match_lengths = values_of<20>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 5, 8, 11});
const auto distances = []
{
    std::array<unsigned, 64> extra_bits{};
    for (unsigned i = 0; i < 64; ++i)
        extra_bits[i] = i / 4;
    return values_of(extra_bits);
}();
const auto literal_values = values_of(std::array<unsigned, 256>{});

/// A decoder of symbols by finite state entropy.
class Decoder
{
  public:
    /// False if the frequencies exceed the number of states, a power of 2.
    bool prepare(std::span<const std::uint32_t> frequencies, std::span<const SymbolValue> values, std::uint32_t states_count)
    {
        states_.clear();
        for (std::size_t symbol = 0; symbol < frequencies.size(); ++symbol)
        {
            const std::uint32_t frequency = frequencies[symbol];
            if (frequency == 0)
                continue;
            if (states_.size() + frequency > states_count)
                return false;
            const auto bits = static_cast<unsigned>(std::countl_zero(frequency) - std::countl_zero(states_count));
            const std::uint32_t longer = (2 * states_count >> bits) - frequency;
            for (std::uint32_t i = 0; i < frequency; ++i)
                states_.push_back(i < longer ? State{bits, ((frequency + i) << bits) - states_count, values[symbol]}
                                             : State{bits - 1, (i - longer) << (bits - 1), values[symbol]});
        }
        return true;
    }
    /// The next value; moves `state`. Nothing comes of a state that no symbol has.
    std::uint32_t next(std::uint32_t& state, BitsFromEnd& bits) const
    {
        if (state >= states_.size())
        {
            bits.end();
            return 0;
        }
        const State& at = states_[state];
        state = at.next + bits.pull(at.bits);
        return at.value.base + bits.pull(at.value.extra_bits);
    }

  private:
    struct State
    {
        unsigned bits = 0;       ///< To pull for the next state …
        std::uint32_t next = 0;  ///< … beyond this one.
        SymbolValue value;
    };
    std::vector<State> states_;
};

/// Reads the frequencies of a block's header: prefix codes of 2 to 14 bits, from each byte's lowest bit up.
bool read_frequencies(Bytes codes, std::span<std::uint32_t> frequencies)
{
    constexpr std::array<unsigned, 8> short_bits{2, 3, 2, 5, 2, 3, 2, 0};
    constexpr std::array<std::uint32_t, 32> short_values{0, 2, 1, 4, 0, 3, 1, 0, 0, 2, 1, 5, 0, 3, 1, 0,
                                                         0, 2, 1, 6, 0, 3, 1, 0, 0, 2, 1, 7, 0, 3, 1, 0};
    std::uint64_t word = 0;
    unsigned available = 0;
    std::size_t place = 0;
    for (auto& frequency : frequencies)
    {
        for (; available < 14 && place < codes.size(); available += 8)
            word |= std::to_integer<std::uint64_t>(codes[place++]) << available;
        const bool is_long = bits_of(word, 0, 4) == 15, is_medium = bits_of(word, 0, 4) == 7;
        const unsigned bits = is_long ? 14 : is_medium ? 8 : short_bits[bits_of(word, 0, 3)];
        frequency = static_cast<std::uint32_t>(is_long     ? 24 + bits_of(word, 4, 10)
                                               : is_medium ? 8 + bits_of(word, 4, 4)
                                                           : short_values[bits_of(word, 0, 5)]);
        if (bits > available)
            return false;
        word >>= bits;
        available -= bits;
    }
    return place == codes.size() && available < 8;
}

/// A block bvx2: literals, and then matches, each with its own payload, which is read from its end.
void unpack_entropy_block(ByteCursor& from, Unpacked& to)
{
    const std::size_t begin = from.offset() - 4;
    const auto raw_bytes = from.read<std::uint32_t>("a block's size");
    std::array<std::uint64_t, 3> fields{};
    for (auto& field : fields)
        field = from.read<std::uint64_t>("a block's header");
    const auto [literals_count, literal_bytes, matches_count] =
        std::array{bits_of(fields[0], 0, 20), bits_of(fields[0], 20, 20), bits_of(fields[0], 40, 20)};
    const auto header_bytes = bits_of(fields[2], 0, 32);
    if (literals_count > literals_of_block || literals_count % 4 != 0 || literals_count > raw_bytes + 3U ||
        matches_count > matches_of_block || header_bytes < 32)
        to.fail(begin, "a block's header is out of range");
    std::array<std::uint32_t, 20 + 20 + 64 + 256> frequencies{};
    if (const auto codes = from.take(header_bytes - 32, "a block's frequencies");
        !codes.empty() && !read_frequencies(codes, frequencies))
        to.fail(begin, "a block's frequencies do not end with its header");
    const std::span all(frequencies);
    Decoder lengths, repeats, backs, literal;
    if (!lengths.prepare(all.subspan(0, 20), literal_lengths, 64) || !repeats.prepare(all.subspan(20, 20), match_lengths, 64) ||
        !backs.prepare(all.subspan(40, 64), distances, 256) || !literal.prepare(all.subspan(104), literal_values, 1024))
        to.fail(begin, "a block's frequencies exceed its states");

    BitsFromEnd literal_bits(from.take(literal_bytes, "a block's literals"),
                             7 - static_cast<unsigned>(bits_of(fields[0], 60, 3)));
    std::array<std::uint32_t, 4> states{};
    for (unsigned i = 0; i < 4; ++i)
        states[i] = static_cast<std::uint32_t>(bits_of(fields[1], 10 * i, 10));
    std::vector<std::byte> literals;
    for (std::size_t i = 0; i < literals_count && !literal_bits.is_short(); ++i)
        literals.push_back(static_cast<std::byte>(literal.next(states[i % 4], literal_bits)));

    BitsFromEnd match_bits(from.take(bits_of(fields[1], 40, 20), "a block's matches"),
                           7 - static_cast<unsigned>(bits_of(fields[1], 60, 3)));
    auto length_state = static_cast<std::uint32_t>(bits_of(fields[2], 32, 10));
    auto repeat_state = static_cast<std::uint32_t>(bits_of(fields[2], 42, 10));
    auto back_state = static_cast<std::uint32_t>(bits_of(fields[2], 52, 10));
    const std::size_t end = to.count() + raw_bytes;
    std::size_t used = 0, distance = 0;
    for (std::size_t i = 0; i < matches_count && !match_bits.is_short(); ++i)
    {
        const std::size_t length = lengths.next(length_state, match_bits);
        const std::size_t repeat = repeats.next(repeat_state, match_bits);
        if (const std::size_t back = backs.next(back_state, match_bits); back != 0)
            distance = back;
        if (length > literals.size() - used)
            to.fail(begin, "a block's matches need more literals than it has");
        to.append(Bytes(literals).subspan(used, length), begin);
        used += length;
        to.repeat(distance, repeat, begin);
    }
    if (literal_bits.is_short() || match_bits.is_short() || to.count() != end)
        to.fail(begin, "a block does not give the bytes that it claims");
}

/// A block bvxn (LZVN): each operation begins with a byte that says which one it is.
void unpack_byte_block(ByteCursor& from, Unpacked& to)
{
    const std::size_t begin = from.offset() - 4;
    const std::size_t end = to.count() + from.read<std::uint32_t>("a block's size");
    const auto packed_bytes = from.read<std::uint32_t>("a block's packed size");
    ByteCursor operations(from.take(packed_bytes, "a block"), "");
    const auto next = [&]() -> std::size_t
    {
        if (operations.left() == 0)
            to.fail(begin, "a block is cut short");
        return operations.read<std::uint8_t>("");
    };
    std::size_t distance = 0;
    for (std::size_t code = next(); code != 0x06; code = next())
    {
        std::size_t literals_count = 0, repeat = 0;
        if (code == 0x0E || code == 0x16)
            continue;
        if ((code & 0xF0U) == 0x70 || (code & 0xF0U) == 0xD0 || (code < 0x40 && (code & 7U) == 6))
            to.fail(begin, fmt::format("a block has the unknown operation {:#x}", code));
        if (code >= 0xF0)
            repeat = code > 0xF0 ? code & 15U : next() + 16;
        else if (code >= 0xE0)
            literals_count = code > 0xE0 ? code & 15U : next() + 16;
        else if (code >= 0xA0 && code < 0xC0)
        {
            const std::size_t low = next(), word = low | next() << 8U;
            literals_count = code >> 3U & 3U;
            repeat = ((code & 7U) << 2U | (word & 3U)) + 3;
            distance = word >> 2U;
        }
        else
        {
            literals_count = code >> 6U;
            repeat = (code >> 3U & 7U) + 3;
            if ((code & 7U) == 7)
            {
                const std::size_t low = next();
                distance = low | next() << 8U;
            }
            else if ((code & 7U) != 6)
                distance = (code & 7U) << 8U | next();
        }
        if (literals_count > operations.left())
            to.fail(begin, "a block is cut short");
        to.append(operations.take(literals_count, ""), begin);
        to.repeat(distance, repeat, begin);
    }
    if (to.count() != end)
        to.fail(begin, "a block does not give the bytes that it claims");
}

}  // namespace

std::vector<std::byte> unpack_lzfse(Bytes packed, std::size_t size, std::string_view source)
{
    Unpacked to(size, source);
    ByteCursor from(packed, source);
    while (true)
    {
        const std::size_t begin = from.offset();
        const auto name = from.take(4, "a block of LZFSE");
        const std::string_view magic(reinterpret_cast<const char*>(name.data()), name.size());
        if (magic == "bvx$")
            break;
        if (magic == "bvx2")
            unpack_entropy_block(from, to);
        else if (magic == "bvxn")
            unpack_byte_block(from, to);
        else if (magic == "bvx-")
        {
            const auto count = from.read<std::uint32_t>("a block's size");
            to.append(from.take(count, "a block"), begin);
        }
        else
            to.fail(begin, "expected a block of LZFSE, bvx2, bvxn, bvx- or bvx$");
    }
    from.expect_end();
    if (to.count() != size)
        to.fail(from.offset(), fmt::format("{} bytes; expected {}", to.count(), size));
    return to.take();
}

}  // namespace record3d
