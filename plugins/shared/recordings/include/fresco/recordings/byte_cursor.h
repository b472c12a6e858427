#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace fresco::recordings
{

/// Reads little-endian numbers from a file's bytes, never beyond their end. The bytes must outlive it.
class ByteCursor
{
  public:
    ByteCursor(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    std::size_t offset() const { return offset_; }
    std::size_t left() const { return bytes_.size() - offset_; }
    /// "source: byte offset" of what comes next.
    std::string place() const;

    /// Throws Error naming place and `what` if the file ends before.
    template <class T>
    T read(std::string_view what)
    {
        static_assert(std::is_arithmetic_v<T> && std::endian::native == std::endian::little);
        T value;
        std::memcpy(&value, take(sizeof value, what).data(), sizeof value);
        return value;
    }
    std::span<const std::byte> take(std::uint64_t count, std::string_view what);
    /// Text up to a zero byte, which is passed.
    std::string_view text(std::string_view what);
    /// Throws Error if something is left.
    void expect_end() const;

  private:
    std::span<const std::byte> bytes_;
    std::string source_;
    std::size_t offset_ = 0;
};

}  // namespace fresco::recordings
