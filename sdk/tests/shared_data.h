#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

/// Prints what was not tested and why, "mixed precision: …", and appends it to the file $FRESCO_SKIP_LOG, which the whole check
/// ends with.
inline void skipped(const std::string& text)
{
    std::cout << "SKIPPED " << text << std::endl;
    if (const char* log = std::getenv("FRESCO_SKIP_LOG"))
        std::ofstream(log, std::ios::app) << text << '\n';
}

/// The data that lies beside a development checkout (real scan, paintings, weights), or an empty path where it is missing; then
/// `test` is skipped.
inline std::filesystem::path shared_data(const std::string& relative, const std::string& test)
{
    const auto file = std::filesystem::path(FRESCO_SOURCE_FOLDER) / ".." / "shared" / "data" / relative;
    if (std::filesystem::exists(file))
        return std::filesystem::canonical(file);
    skipped(test + ": " + relative + " is not here");
    return {};
}
