#pragma once

#include <filesystem>
#include <functional>
#include <span>

namespace fresco
{

struct FileCopy
{
    std::filesystem::path from;
    std::filesystem::path to;
};

/// Copies files as write_durable_file writes them, but flushes all of them at once: many small files take a fraction of the
/// time. None appears under its name before the data of all are on the disk; `written` is called then. Opens a descriptor per
/// file. Throws Error naming the file that cannot be read or written, and what `written` throws.
void copy_files(std::span<const FileCopy> copies, const std::function<void()>& written = {});

}  // namespace fresco
