#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <string>
#include <vector>

/// \file How files of one format are told from others, as data. `fresco check` holds every file that a pipeline names to it, so
/// that a wrong or a cut one is found in a second and not after an hour. Readers and options of files declare the formats that
/// they read; whether a file is sound is theirs to find out.

namespace fresco
{

struct FileFormat
{
    std::string name{};                     ///< "a PLY mesh"
    std::vector<std::string> extensions{};  ///< Lower case, with the dot: ".ply".
    bool is_text = false;                   ///< White space does not count before `begins` and behind `ends`.
    std::vector<std::string> begins{};      ///< The file has one of these at `begins_at`; empty: `holds` tells the format.
    std::size_t begins_at = 0;
    std::vector<std::string> holds{};  ///< It has one of these in its first MiB; "\n" also stands for the beginning.
    std::vector<std::string> ends{};   ///< It has one of these at the end of a text, behind the last header of other files.
    std::size_t length_at = 0;         ///< Where it says how long it is, in a little-endian number of …
    std::size_t length_bytes = 0;      ///< … so many bytes (0: nowhere), …
    std::size_t length_from = 0;       ///< … counted from here.

    static FileFormat from(const Value& description);
    Value describe() const;
};

/// Of all of them, each once.
std::vector<std::string> all_extensions(const std::vector<FileFormat>& formats);

FileFormat json_format();

}  // namespace fresco
