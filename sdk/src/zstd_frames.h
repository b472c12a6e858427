#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fresco::detail
{

/// Puts Zstandard frames, each with its size and checksum, behind one another. Not thread-safe.
class FrameWriter
{
  public:
    /// Leaves so many bytes at the beginning for the caller to fill.
    explicit FrameWriter(std::size_t reserved_bytes) : bytes_(reserved_bytes) {}

    /// Of no bytes, none. Returns the frame's size. Throws Error.
    std::uint32_t append(std::span<const std::uint8_t> contents);
    std::vector<std::byte> bytes() && { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
    std::unique_ptr<std::byte[]> scratch_;
    std::size_t scratch_bytes_ = 0;
};

/// Fills `bytes` with the contents of one frame; nothing for no bytes. Returns what is wrong, empty if nothing is: another size,
/// damage, bytes behind the frame. Thread-safe.
std::string read_frame(std::span<const std::byte> frame, std::span<std::uint8_t> bytes);

}  // namespace fresco::detail
