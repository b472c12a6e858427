#pragma once

#include <filesystem>
#include <functional>

namespace fresco
{

/// Copies the bytes of `from` to `to` as write_durable_file does. `written` is called once they are on the disk under the
/// temporary name. Throws Error naming the file that cannot be read or written, and what `written` throws.
void copy_file(const std::filesystem::path& from, const std::filesystem::path& to, const std::function<void()>& written = {});

}  // namespace fresco
