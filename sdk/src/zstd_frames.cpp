#include "zstd_frames.h"

#include <fresco/error.h>

#include <fmt/format.h>
#include <memory>
#include <new>
#include <zstd.h>

namespace fresco::detail
{
namespace
{

// Residuals hardly repeat: what counts is how often each byte occurs. Short repetitions, and long searches for them, cost more
// than they save.
constexpr int level = 1;
constexpr int shortest_repetition = 7;
constexpr int searched_log = 10;

/// The thread's own: making one costs more than a small frame.
ZSTD_CCtx* compressor()
{
    struct Free
    {
        void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
    if (!context)
        throw std::bad_alloc();
    return context.get();
}

ZSTD_DCtx* decompressor()
{
    struct Free
    {
        void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
    if (!context)
        throw std::bad_alloc();
    return context.get();
}

}  // namespace

std::uint32_t FrameWriter::append(std::span<const std::uint8_t> contents)
{
    if (contents.empty())
        return 0;
    const std::size_t bound = ZSTD_compressBound(contents.size());
    if (bound > scratch_bytes_)
    {
        scratch_ = std::make_unique_for_overwrite<std::byte[]>(bound);
        scratch_bytes_ = bound;
    }
    ZSTD_CCtx* context = compressor();
    ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
    ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(context, ZSTD_c_minMatch, shortest_repetition);
    ZSTD_CCtx_setParameter(context, ZSTD_c_hashLog, searched_log);
    ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
    const std::size_t size = ZSTD_compress2(context, scratch_.get(), bound, contents.data(), contents.size());
    if (ZSTD_isError(size) != 0)
        throw Error(std::string("a uv map cannot be packed: ") + ZSTD_getErrorName(size));
    bytes_.insert(bytes_.end(), scratch_.get(), scratch_.get() + size);
    return static_cast<std::uint32_t>(size);
}

std::string read_frame(std::span<const std::byte> frame, std::span<std::uint8_t> bytes)
{
    if (bytes.empty())
        return frame.empty() ? "" : "expected no bytes";
    const auto says = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (says == ZSTD_CONTENTSIZE_ERROR || says == ZSTD_CONTENTSIZE_UNKNOWN)
        return "expected a Zstandard frame with its size";
    if (says != bytes.size())
        return fmt::format("expected a frame of {} bytes, got {}", bytes.size(), says);
    const std::size_t size = ZSTD_decompressDCtx(decompressor(), bytes.data(), bytes.size(), frame.data(), frame.size());
    return ZSTD_isError(size) != 0 ? ZSTD_getErrorName(size) : "";
}

}  // namespace fresco::detail
