// libFuzzer's entry. FRESCO_FUZZ_PARSER in the environment names the parser; without it, all are listed.
#include "parsers.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace
{

void (*read)(fresco::fuzz::Bytes) = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/)
{
    const char* const name = std::getenv("FRESCO_FUZZ_PARSER");
    for (const auto& parser : fresco::fuzz::parsers())
    {
        if (name != nullptr && parser.name == name)
            read = parser.read;
        if (name == nullptr)
            std::printf("%s\t%s\n", std::string(parser.name).c_str(), std::string(parser.sources).c_str());
    }
    if (read == nullptr)
        std::exit(name == nullptr ? 0 : 2);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    // A copy of exactly this size, so that a read beyond it is seen.
    const std::vector<std::uint8_t> copy(data, data + size);
    fresco::fuzz::refused([&] { read(std::as_bytes(std::span(copy))); });
    return 0;
}
