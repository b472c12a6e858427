#include <fresco/weights/sha256.h>

#include <fresco/error.h>
#include <fresco/wording.h>

#include <sha2.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace fresco::weights
{
namespace
{

using Digits = std::array<char, SHA256_DIGEST_STRING_LENGTH>;

}  // namespace

std::string sha256(std::span<const std::byte> bytes)
{
    Digits digits;
    return SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), digits.data());
}

std::string sha256_of_file(const std::filesystem::path& file)
{
    Digits digits;
    if (SHA256File(file.c_str(), digits.data()) == nullptr)
        throw MissingInput(file.string() + ": cannot be read: " + std::strerror(errno));
    return digits.data();
}

bool is_sha256_prefix(std::string_view digits)
{
    return digits.size() >= 8 && digits.size() <= 64 &&
           digits.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
}

bool has_sha256_prefix(std::string_view hash, std::string_view prefix)
{
    return hash.starts_with(lower_case(std::string(prefix)));
}

}  // namespace fresco::weights
