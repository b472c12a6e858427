#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// \file Writes LZFSE as slowly as its definition reads, for the tests of its reader.

namespace record3d::testing
{

using Text = std::string;

inline Text little(std::uint64_t number, int bytes)
{
    Text text;
    for (int i = 0; i < bytes; ++i)
        text += static_cast<char>(number >> (8 * i) & 255U);
    return text;
}

/// A block that is stored as it is.
inline Text stored_block(const Text& raw)
{
    return "bvx-" + little(raw.size(), 4) + raw;
}

/// A block of LZVN operations that give `raw_bytes`.
inline Text byte_block(std::size_t raw_bytes, const Text& operations)
{
    const Text ended = operations + Text("\x06\0\0\0\0\0\0\0", 8);
    return "bvxn" + little(raw_bytes, 4) + little(ended.size(), 4) + ended;
}

struct Match
{
    std::uint32_t literals = 0;
    std::uint32_t repeat = 0;
    std::uint32_t distance = 0;  ///< 0: that of the match before.
};

/// Bits in the order in which they lie in a payload, from its first byte's lowest one.
struct Bits
{
    std::vector<bool> all;

    void add(std::uint64_t value, unsigned count)
    {
        for (unsigned i = 0; i < count; ++i)
            all.push_back((value >> i & 1U) != 0);
    }
    Text bytes() const
    {
        Text text((all.size() + 7) / 8, '\0');
        for (std::size_t i = 0; i < all.size(); ++i)
            text[i / 8] = static_cast<char>(static_cast<unsigned char>(text[i / 8]) | (all[i] ? 1U << i % 8 : 0U));
        return text;
    }
    unsigned unused() const { return static_cast<unsigned>((8 - all.size() % 8) % 8); }
};

/// A code of symbols by finite state entropy: of the states of a symbol, in order, each leads to a run of states, and the runs
/// cover all states.
struct Code
{
    std::vector<std::uint32_t> frequencies;
    std::uint32_t states = 0;

    /// Frequencies that add up to `states`, in proportion to `counts`, none of a used symbol 0.
    Code(const std::vector<std::size_t>& counts, std::uint32_t states_count) : frequencies(counts.size()), states(states_count)
    {
        std::size_t total = 0, used = 0;
        for (const auto count : counts)
            total += count;
        if (total == 0)
            return;
        for (std::size_t i = 0; i < counts.size(); ++i)
            frequencies[i] =
                counts[i] == 0 ? 0 : std::max<std::uint32_t>(1, static_cast<std::uint32_t>(counts[i] * states / total));
        for (const auto frequency : frequencies)
            used += frequency;
        for (; used > states; --used)
            --*std::ranges::max_element(frequencies);
        *std::ranges::max_element(frequencies) += static_cast<std::uint32_t>(states - used);
    }
    /// Writes the bits that lead from a state of `symbol` to `state`, and goes to that state.
    void back(std::size_t symbol, std::uint32_t& state, Bits& bits) const
    {
        std::uint32_t first = 0;
        for (std::size_t i = 0; i < symbol; ++i)
            first += frequencies[i];
        const std::uint32_t frequency = frequencies[symbol];
        for (std::uint32_t i = 0; i < frequency; ++i)
        {
            // The run of state i: the states of all symbols, counted from `states`, halved until they are one of the symbol's.
            unsigned count = 0;
            while ((states + state) >> count >= 2 * frequency)
                ++count;
            if ((states + state) >> count == frequency + i)
            {
                bits.add((states + state) & ((1U << count) - 1), count);
                state = first + i;
                return;
            }
        }
    }
};

/// The symbol of a value, and its extra bits.
struct Symbol
{
    std::size_t index = 0;
    std::uint32_t extra = 0;
    unsigned extra_bits = 0;
};

inline Symbol symbol_of(std::uint32_t value, std::span<const unsigned> extra_bits)
{
    std::uint32_t base = 0;
    for (std::size_t i = 0; i < extra_bits.size(); base += 1U << extra_bits[i++])
        if (value < base + (1U << extra_bits[i]))
            return {i, value - base, extra_bits[i]};
    return {};
}

/// A block of literals, whose count is a multiple of 4, and matches.
inline Text entropy_block(std::size_t raw_bytes, const Text& literals, const std::vector<Match>& matches)
{
    constexpr std::array<unsigned, 20> length_bits{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 3, 5, 8};
    constexpr std::array<unsigned, 20> repeat_bits{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 5, 8, 11};
    std::array<unsigned, 64> distance_bits{};
    for (unsigned i = 0; i < 64; ++i)
        distance_bits[i] = i / 4;
    std::vector<std::size_t> length_counts(20), repeat_counts(20), distance_counts(64), literal_counts(256);
    for (const auto& match : matches)
    {
        ++length_counts[symbol_of(match.literals, length_bits).index];
        ++repeat_counts[symbol_of(match.repeat, repeat_bits).index];
        ++distance_counts[symbol_of(match.distance, distance_bits).index];
    }
    for (const char c : literals)
        ++literal_counts[static_cast<unsigned char>(c)];
    const Code lengths(length_counts, 64), repeats(repeat_counts, 64), distances(distance_counts, 256),
        literal(literal_counts, 1024);

    Bits literal_payload, match_payload, frequencies;
    std::array<std::uint32_t, 4> states{};
    for (std::size_t i = literals.size(); i-- > 0;)
        literal.back(static_cast<unsigned char>(literals[i]), states[i % 4], literal_payload);
    std::uint32_t length_state = 0, repeat_state = 0, distance_state = 0;
    for (std::size_t i = matches.size(); i-- > 0;)
    {
        const auto put = [&](std::uint32_t value, std::span<const unsigned> extra_bits, const Code& code, std::uint32_t& state)
        {
            const Symbol symbol = symbol_of(value, extra_bits);
            match_payload.add(symbol.extra, symbol.extra_bits);
            code.back(symbol.index, state, match_payload);
        };
        put(matches[i].distance, distance_bits, distances, distance_state);
        put(matches[i].repeat, repeat_bits, repeats, repeat_state);
        put(matches[i].literals, length_bits, lengths, length_state);
    }
    constexpr std::array<std::pair<unsigned, unsigned>, 8> small{
        {{0, 2}, {2, 2}, {1, 3}, {5, 3}, {3, 5}, {11, 5}, {19, 5}, {27, 5}}};
    for (const auto* code : {&lengths, &repeats, &distances, &literal})
        for (const auto frequency : code->frequencies)
        {
            if (frequency < 8)
                frequencies.add(small[frequency].first, small[frequency].second);
            else if (frequency < 24)
                frequencies.add(7 | (frequency - 8) << 4U, 8);
            else
                frequencies.add(15 | (frequency - 24) << 4U, 14);
        }
    const Text codes = frequencies.bytes(), literal_bytes = literal_payload.bytes(), match_bytes = match_payload.bytes();
    const std::uint64_t first = literals.size() | std::uint64_t{literal_bytes.size()} << 20U |
                                std::uint64_t{matches.size()} << 40U | std::uint64_t{7 - literal_payload.unused()} << 60U;
    const std::uint64_t second = states[0] | states[1] << 10U | states[2] << 20U | std::uint64_t{states[3]} << 30U |
                                 std::uint64_t{match_bytes.size()} << 40U | std::uint64_t{7 - match_payload.unused()} << 60U;
    const std::uint64_t third = (32 + codes.size()) | std::uint64_t{length_state} << 32U | std::uint64_t{repeat_state} << 42U |
                                std::uint64_t{distance_state} << 52U;
    return "bvx2" + little(raw_bytes, 4) + little(first, 8) + little(second, 8) + little(third, 8) + codes + literal_bytes +
           match_bytes;
}

}  // namespace record3d::testing
