#pragma once

#include "plugins/catalog.h"
#include "store/store.h"
#include <fresco/image_io.h>
#include <fresco/value.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

/// \file Pages with pictures are written by a process of their own: what opens a picture may crash, and the host opens no plugin.

namespace fresco::host
{

/// The component that reads and writes pictures, as {type, library, hash}; null: there is none.
Value image_component(const Catalog& catalog);

/// In the child: the component itself. Throws Error if it cannot be had.
std::shared_ptr<ImageIo> image_codec(const Value& component);

/// Runs this program's `command` with the file that holds `request`. What it said where it failed; empty: it did its work.
/// The host must be single-threaded.
std::string run_page_child(const std::string& command, const Value& request, const Store& store);

/// The child's side: hands the request over. The exit code.
int serve_page(const std::filesystem::path& request_file, const std::function<void(const Value&)>& write);

}  // namespace fresco::host
