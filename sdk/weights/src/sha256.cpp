#include <fresco/weights/sha256.h>

#include <fresco/error.h>

#include <sha2.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>

namespace fresco::weights
{
namespace
{

using Digits = std::array<char, SHA256_DIGEST_STRING_LENGTH>;

char lower(char c)
{
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

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
           std::ranges::all_of(digits, [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; });
}

bool has_sha256_prefix(std::string_view hash, std::string_view prefix)
{
    return hash.size() >= prefix.size() &&
           std::ranges::equal(hash.substr(0, prefix.size()), prefix, [](char a, char b) { return a == lower(b); });
}

}  // namespace fresco::weights
