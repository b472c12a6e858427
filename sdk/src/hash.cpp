#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fresco/error.h>
#include <fresco/hash.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

namespace fresco
{
namespace
{

std::string hex(XXH128_hash_t hash)
{
    static constexpr char digits[] = "0123456789abcdef";
    XXH128_canonical_t bytes;
    XXH128_canonicalFromHash(&bytes, hash);
    std::string text;
    for (const unsigned char byte : bytes.digest)
    {
        text += digits[byte >> 4U];
        text += digits[byte & 15U];
    }
    return text;
}

}  // namespace

std::string content_hash(std::span<const std::byte> bytes)
{
    return hex(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string content_hash(std::string_view text)
{
    return content_hash(std::as_bytes(std::span(text.data(), text.size())));
}

std::string file_hash(const std::filesystem::path& file)
{
    // Opening a FIFO would wait for its writer.
    std::error_code unknown;
    if (const auto status = std::filesystem::status(file, unknown);
        std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw Error(file.string() + ": is not a regular file");
    std::FILE* opened = nullptr;
    do
        opened = std::fopen(file.c_str(), "rb");
    while (opened == nullptr && errno == EINTR);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(opened, &std::fclose);
    if (!stream)
        throw MissingInput(file.string() + ": cannot be read: " + std::generic_category().message(errno));
    const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), &XXH3_freeState);
    XXH3_128bits_reset(state.get());
    std::vector<std::byte> buffer(std::size_t{1} << 20U);
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), stream.get()))
        XXH3_128bits_update(state.get(), buffer.data(), count);
    if (std::ferror(stream.get()) != 0)
        throw MissingInput(file.string() + ": reading failed: " + std::generic_category().message(errno));
    return hex(XXH3_128bits_digest(state.get()));
}

}  // namespace fresco
