#pragma once

#include <fresco/error.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file The parsers of files that come from elsewhere, as functions of bytes: for the fuzzer and for the replay of its corpus.

namespace fresco::fuzz
{

using Bytes = std::span<const std::byte>;

/// `read` throws Error for bytes that it refuses. Anything else that leaves it is a fault, and so is a result that does not hold
/// what the parser promises.
struct Parser
{
    std::string_view name;     ///< Also of its folder in corpus/.
    std::string_view sources;  ///< Regular expression of the files whose coverage counts, from the repository's root.
    void (*read)(Bytes bytes);
};

/// By name.
std::vector<Parser>& parsers();

/// Puts parsers into the list before main().
struct Registered
{
    Registered(std::initializer_list<Parser> more);
};

/// Name of the files in errors.
inline constexpr std::string_view source = "input";

inline std::string_view text_of(Bytes bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Throws std::logic_error, which no parser does.
void require(bool holds, const std::string& what);

/// Whether it throws an Error.
template <class Use>
bool refused(const Use& use)
{
    try
    {
        use();
    }
    catch (const Error&)
    {
        return true;
    }
    return false;
}

/// A GLB or glTF file; what is read can be used.
void read_gltf(Bytes bytes);

/// A file with these bytes, for parsers that open one; the same file each time. `name` is one per parser.
std::filesystem::path file_with(Bytes bytes, const std::string& name);

}  // namespace fresco::fuzz
