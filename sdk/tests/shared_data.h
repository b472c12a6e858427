#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

/// The data that lies beside a development checkout (real scan, paintings, weights), or an empty path where it is missing; then
/// the skipped test's name is printed and appended to the file $FRESCO_SKIP_LOG.
inline std::filesystem::path shared_data(const std::string& relative, const std::string& test)
{
    const auto file = std::filesystem::path(FRESCO_SOURCE_FOLDER) / ".." / "shared" / "data" / relative;
    if (std::filesystem::exists(file))
        return std::filesystem::canonical(file);
    const std::string line = "SKIPPED " + test + ": " + relative + " is not at hand";
    std::cout << line << std::endl;
    if (const char* log = std::getenv("FRESCO_SKIP_LOG"))
        std::ofstream(log, std::ios::app) << line << '\n';
    return {};
}
