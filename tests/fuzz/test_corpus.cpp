#include "catch.h"
#include "parsers.h"

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <random>
#include <sys/resource.h>

namespace fs = std::filesystem;
using fresco::fuzz::Parser;

namespace
{

constexpr double most_seconds = 5;  ///< Processor time: the machine may be busy.

/// As for a fuzzed input: an allocation beyond it fails, as no Error does. The sanitizers' own memory is beyond any limit.
[[maybe_unused]] const bool is_limited = []
{
#ifndef FRESCO_SANITIZED
    const rlimit limit{rlim_t{4} << 30U, rlim_t{4} << 30U};
    return ::setrlimit(RLIMIT_AS, &limit) == 0;
#else
    return false;
#endif
}();

const fs::path corpus = fs::path(FRESCO_SOURCE_FOLDER) / "tests/fuzz/corpus";

std::vector<fs::path> files_of(const Parser& parser)
{
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(corpus / parser.name))
        files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

bool is_good(const fs::path& file)
{
    return file.filename().string().starts_with("good");
}

/// Whether the parser takes the bytes; what it refuses must be refused by an Error, and in time.
bool is_read(const Parser& parser, const std::vector<std::byte>& bytes)
{
    const std::clock_t begin = std::clock();
    std::string refusal;
    try
    {
        // A copy of exactly this size, so that a sanitizer sees a read beyond it.
        const std::vector<std::byte> copy(bytes.begin(), bytes.end());
        parser.read(copy);
    }
    catch (const fresco::Error& error)
    {
        refusal = error.what();
        CHECK(!refusal.empty());
    }
    catch (const std::exception& error)
    {
        FAIL_CHECK("not an Error: " << error.what());
    }
    CHECK(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC < most_seconds);
    UNSCOPED_INFO(refusal);
    return refusal.empty();
}

void change(std::vector<std::byte>& bytes, std::mt19937& random)
{
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (bytes.empty() ? 2 : random() % 5)
    {
    case 0:
        *place ^= std::byte{1} << random() % 8;
        return;
    case 1:
        // Lengths and counts at their limits.
        std::fill_n(place, std::min<std::size_t>(bytes.size() - at, std::size_t{1} << random() % 4),
                    random() % 2 == 0 ? std::byte{0xFF} : std::byte{0});
        return;
    case 2:
        bytes.insert(place, static_cast<std::byte>(random() % 256));
        return;
    case 3:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size() - at, 1 + random() % 4)));
        return;
    default:
    {
        const std::vector<std::byte> piece(place,
                                           place + static_cast<std::ptrdiff_t>(std::min<std::size_t>(bytes.size() - at, 32)));
        bytes.insert(place, piece.begin(), piece.end());
    }
    }
}

}  // namespace

TEST_CASE("Every file of the corpus is read or refused, as its name says")
{
    CHECK(fresco::fuzz::parsers().size() >= 5);
    for (const Parser& parser : fresco::fuzz::parsers())
    {
        std::map<bool, int> count;
        for (const fs::path& file : files_of(parser))
        {
            CAPTURE(file.string());
            const bool expected = is_good(file);
            CHECK((expected || file.filename().string().starts_with("bad")));
            CHECK(is_read(parser, fresco::read_file(file)) == expected);
            ++count[expected];
        }
        CAPTURE(std::string(parser.name));
        CHECK(count[true] > 0);
    }
}

TEST_CASE("Good files that are cut or changed are read or refused in time")
{
    for (const Parser& parser : fresco::fuzz::parsers())
        for (const fs::path& file : files_of(parser))
        {
            if (!is_good(file))
                continue;
            const auto whole = fresco::read_file(file);
            std::mt19937 random(7);
            for (std::size_t cut = 0; cut < 40; ++cut)
            {
                CAPTURE(file.string(), cut);
                is_read(parser, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() * cut / 40)});
            }
            for (int trial = 0; trial < 120; ++trial)
            {
                CAPTURE(file.string(), trial);
                auto bytes = whole;
                for (std::size_t i = 0; i <= random() % 4; ++i)
                    change(bytes, random);
                is_read(parser, bytes);
            }
        }
}
