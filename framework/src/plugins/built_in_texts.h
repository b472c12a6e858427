#pragma once

#include <vector>

namespace fresco::host
{

/// A file below sdk/templates.
struct BuiltInText
{
    const char* folder;
    const char* path;
    const char* text;
};
extern const std::vector<BuiltInText> built_in_texts;

}  // namespace fresco::host
