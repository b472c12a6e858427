#include <fresco/weights/sha256.h>

#include <fresco/error.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <fstream>
#include <vector>

namespace fresco::weights
{
namespace
{

/// The first 32 bits of the fractional parts of the cube roots of the first 64 primes.
constexpr std::array<std::uint32_t, 64> constants{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01,
    0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc,
    0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147,
    0x06ca6351, 0x14292967, 0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08,
    0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208,
    0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

char lower(char c)
{
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

}  // namespace

Sha256::Sha256() : state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19} {}

void Sha256::block(const std::byte* bytes)
{
    std::array<std::uint32_t, 64> words;
    for (std::size_t i = 0; i < 16; ++i)
    {
        words[i] = 0;
        for (std::size_t j = 0; j < 4; ++j)
            words[i] = (words[i] << 8U) | std::to_integer<std::uint32_t>(bytes[i * 4 + j]);
    }
    for (std::size_t i = 16; i < 64; ++i)
    {
        const std::uint32_t a = words[i - 15];
        const std::uint32_t b = words[i - 2];
        const std::uint32_t s0 = std::rotr(a, 7) ^ std::rotr(a, 18) ^ (a >> 3U);
        const std::uint32_t s1 = std::rotr(b, 17) ^ std::rotr(b, 19) ^ (b >> 10U);
        words[i] = words[i - 16] + s0 + words[i - 7] + s1;
    }
    auto [a, b, c, d, e, f, g, h] = state_;
    for (std::size_t i = 0; i < 64; ++i)
    {
        const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
        const std::uint32_t first = h + s1 + ((e & f) ^ (~e & g)) + constants[i] + words[i];
        const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
        const std::uint32_t second = s0 + ((a & b) ^ (a & c) ^ (b & c));
        h = g;
        g = f;
        f = e;
        e = d + first;
        d = c;
        c = b;
        b = a;
        a = first + second;
    }
    const std::array<std::uint32_t, 8> mixed{a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < 8; ++i)
        state_[i] += mixed[i];
}

void Sha256::add(std::span<const std::byte> bytes)
{
    total_ += bytes.size();
    while (!bytes.empty())
    {
        if (pending_count_ == 0 && bytes.size() >= pending_.size())
        {
            block(bytes.data());
            bytes = bytes.subspan(pending_.size());
            continue;
        }
        const std::size_t count = std::min(bytes.size(), pending_.size() - pending_count_);
        std::memcpy(pending_.data() + pending_count_, bytes.data(), count);
        pending_count_ += count;
        bytes = bytes.subspan(count);
        if (pending_count_ == pending_.size())
        {
            block(pending_.data());
            pending_count_ = 0;
        }
    }
}

std::string Sha256::hexadecimal()
{
    const std::uint64_t bits = total_ * 8;
    const std::byte end{0x80};
    add({&end, 1});
    const std::byte zero{0};
    while (pending_count_ != pending_.size() - 8)
        add({&zero, 1});
    std::array<std::byte, 8> length;
    for (std::size_t i = 0; i < 8; ++i)
        length[i] = static_cast<std::byte>(bits >> (56 - 8 * i));
    add(length);
    std::string text;
    for (const std::uint32_t word : state_)
        for (int shift = 28; shift >= 0; shift -= 4)
            text += "0123456789abcdef"[(word >> static_cast<unsigned>(shift)) & 15U];
    return text;
}

std::string sha256(std::span<const std::byte> bytes)
{
    Sha256 sum;
    sum.add(bytes);
    return sum.hexadecimal();
}

std::string sha256_of_file(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw MissingInput(file.string() + ": cannot be opened");
    Sha256 sum;
    std::vector<char> piece(std::size_t{1} << 20U);
    while (stream)
    {
        stream.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        sum.add(std::as_bytes(std::span(piece).first(static_cast<std::size_t>(stream.gcount()))));
    }
    if (stream.bad())
        throw MissingInput(file.string() + ": reading failed");
    return sum.hexadecimal();
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
