#pragma once

#include "mesh_text.h"
#include "ply_header.h"

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <string>
#include <string_view>

/// \file Two sources of PLY values with one interface: rows begin and end, numbers are read by their declared type, lists are
/// checked against what is left of the file before anyone allocates for them.

namespace fresco::detail
{

constexpr std::int64_t least_value(PlyType type)
{
    constexpr std::int64_t least[] = {INT8_MIN, 0, INT16_MIN, 0, INT32_MIN, 0};
    return least[static_cast<std::size_t>(type)];
}
constexpr std::int64_t greatest_value(PlyType type)
{
    constexpr std::int64_t greatest[] = {INT8_MAX, UINT8_MAX, INT16_MAX, UINT16_MAX, INT32_MAX, UINT32_MAX};
    return greatest[static_cast<std::size_t>(type)];
}

/// Values of the binary formats; `Swapped`: the file's byte order is not this machine's.
template <bool Swapped>
class BinaryCursor
{
  public:
    BinaryCursor(std::span<const std::byte> bytes, const PlyHeader& header, std::string_view source)
        : bytes_(bytes), source_(source), offset_(header.body_offset), last_(offset_)
    {
    }

    void begin_row() {}
    void end_row() {}
    void end()
    {
        last_ = offset_;
        if (offset_ != bytes_.size())
            fail(fmt::format("{} bytes after the last element; expected the end of the file", bytes_.size() - offset_));
    }

    std::int64_t integer(PlyType type)
    {
        switch (type)
        {
        case PlyType::int8:
            return take<std::int8_t>();
        case PlyType::uint8:
            return take<std::uint8_t>();
        case PlyType::int16:
            return take<std::int16_t>();
        case PlyType::uint16:
            return take<std::uint16_t>();
        case PlyType::int32:
            return take<std::int32_t>();
        default:
            return take<std::uint32_t>();
        }
    }

    double real(PlyType type)
    {
        if (type == PlyType::float32)
            return static_cast<double>(take<float>());
        if (type == PlyType::float64)
            return take<double>();
        return static_cast<double>(integer(type));
    }

    /// A list's length, which the rest of the file can hold.
    std::size_t list_size(const PlyProperty& list)
    {
        const std::int64_t count = integer(list.count_type);
        if (count < 0)
            fail("the list " + in_quotes(list.name) + " has a negative length");
        const auto size = static_cast<std::size_t>(count);
        if (size > (bytes_.size() - offset_) / size_of(list.type))
            fail(fmt::format("the list {} of {} items goes beyond the end of the file: it is cut or damaged",
                             in_quotes(list.name), size));
        return size;
    }

    void skip(const PlyProperty& property)
    {
        const std::size_t items = property.is_list ? list_size(property) : 1;
        reach(items * size_of(property.type));
        offset_ += items * size_of(property.type);
    }

    /// A whole element; at once where its rows have one size.
    void skip_rows(const PlyElement& element)
    {
        std::size_t row = 0;
        bool fixed = true;
        for (const auto& property : element.properties)
        {
            fixed = fixed && !property.is_list;
            row += size_of(property.type);
        }
        if (fixed)
        {
            // The header's check has shown that the product fits the file.
            reach(element.count * row);
            offset_ += element.count * row;
            return;
        }
        for (std::size_t i = 0; i < element.count; ++i)
            for (const auto& property : element.properties)
                skip(property);
    }

    /// About the value read last.
    [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}: byte {}: {}", source_, last_, what)); }

  private:
    void reach(std::size_t size)
    {
        last_ = offset_;
        if (size > bytes_.size() - offset_)
            fail("the file ends here: it is cut; copy or export it again");
    }

    template <class T>
    T take()
    {
        reach(sizeof(T));
        std::array<std::byte, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes_.data() + offset_, sizeof(T));
        if constexpr (Swapped)
            std::reverse(raw.begin(), raw.end());
        offset_ += sizeof(T);
        return std::bit_cast<T>(raw);
    }

    std::span<const std::byte> bytes_;
    std::string_view source_;
    std::size_t offset_;
    std::size_t last_;
};

/// Values of the text format: one row per line.
class AsciiCursor
{
  public:
    AsciiCursor(std::span<const std::byte> bytes, const PlyHeader& header, std::string_view source)
        : lines_(as_text(bytes).substr(header.body_offset), source, header.lines)
    {
    }

    void begin_row()
    {
        std::string_view line;
        if (!lines_.next(line))
            fail("the file ends after this line: it is cut; copy or export it again");
        words_ = Words(line);
    }
    void end_row()
    {
        if (const auto word = words_.next(); !word.empty())
            fail("unexpected " + in_quotes(word) + " after the last value of the line");
    }
    void end()
    {
        std::string_view line;
        while (lines_.next(line))
            if (const auto word = Words(line).next(); !word.empty())
                fail("unexpected " + in_quotes(word) + " after the last element; expected the end of the file");
    }

    std::int64_t integer(PlyType type)
    {
        std::int64_t value = 0;
        const auto word = next(type);
        if (!parse_number(word, value) || value < least_value(type) || value > greatest_value(type))
            wrong(type, word);
        return value;
    }

    double real(PlyType type)
    {
        if (is_integer(type))
            return static_cast<double>(integer(type));
        const auto word = next(type);
        float narrow = 0;
        double value = 0;
        // Straight to float: by way of double some values would be rounded twice.
        const bool good = type == PlyType::float32 ? parse_number(word, narrow) : parse_number(word, value);
        if (!good)
            wrong(type, word);
        return type == PlyType::float32 ? static_cast<double>(narrow) : value;
    }

    std::size_t list_size(const PlyProperty& list)
    {
        const std::int64_t count = integer(list.count_type);
        if (count < 0)
            fail("the list " + in_quotes(list.name) + " has a negative length");
        const auto size = static_cast<std::size_t>(count);
        // Each item takes a separator and a digit.
        if (size > words_.characters_left() / 2)
            fail(fmt::format("the list {} of {} items is longer than its line", in_quotes(list.name), size));
        return size;
    }

    void skip(const PlyProperty& property)
    {
        const std::size_t items = property.is_list ? list_size(property) : 1;
        for (std::size_t i = 0; i < items; ++i)
            real(property.type);
    }

    void skip_rows(const PlyElement& element)
    {
        for (std::size_t i = 0; i < element.count; ++i)
        {
            begin_row();
            for (const auto& property : element.properties)
                skip(property);
            end_row();
        }
    }

    [[noreturn]] void fail(const std::string& what) const { lines_.fail(what); }

  private:
    std::string_view next(PlyType type)
    {
        const auto word = words_.next();
        if (word.empty())
            fail("the line ends; expected a value of type " + std::string(name_of(type)));
        return word;
    }
    [[noreturn]] void wrong(PlyType type, std::string_view word) const
    {
        fail("expected a value of type " + std::string(name_of(type)) + " instead of " + in_quotes(word));
    }

    Lines lines_;
    Words words_;
};

}  // namespace fresco::detail
