#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace fresco::weights
{

/// A file of the web, known by its SHA-256.
struct Download
{
    std::string url;            ///< http:// or https://
    std::string sha256_prefix;  ///< 8 to 64 hexadecimal digits that the file's SHA-256 begins with.
    std::filesystem::path to;
    std::uint64_t most_bytes;  ///< A server that sends more is refused, before the disk is full.
};

/// Fetches it with the system's `curl` program into `to`.fresco-part, going on where an earlier call was interrupted, and renames
/// that to `to` when the SHA-256 is right. A file that is at `to` and right is kept; returns false then. Progress goes to
/// standard error. An https:// address is not redirected to http://. One call at a time per file: a second is refused. Throws
/// Error for a wrong address or prefix, a server that refuses or sends too much, a file whose SHA-256 is wrong (it is removed,
/// unless it is what was at `to` before), a curl that is missing.
bool download(const Download& what);

}  // namespace fresco::weights
