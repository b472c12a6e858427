#pragma once

#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/weights/state_dict.h>

#include <cstdlib>
#include <string>
#include <vector>

/// \file State dicts written by Python's own pickle and zipfile (make_weights.py).

/// Made once for all tests.
inline const std::filesystem::path& made_weights()
{
    static const fresco::testing::TemporaryFolder folder;
    static const bool made =
        std::system(("'" FRESCO_PYTHON "' '" FRESCO_MAKE_WEIGHTS "' '" + folder.path().string() + "'").c_str()) == 0;
    REQUIRE(made);
    return folder.path();
}

inline std::vector<std::byte> made_bytes(const std::string& name)
{
    return fresco::read_file(made_weights() / name);
}

/// Number that make_weights.py writes at place `i` of a storage.
inline float made_number(std::size_t i)
{
    return (static_cast<float>(i * 37 % 251) - 125) / 64;
}

inline std::vector<std::byte> bytes_of(const std::string& text)
{
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}
