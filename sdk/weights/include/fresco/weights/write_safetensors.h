#pragma once

#include <fresco/weights/state_dict.h>

#include <filesystem>
#include <map>
#include <span>
#include <string>

namespace fresco::weights
{

/// Writes what to_safetensors() gives, from where the tensors lie: no copy of them is made. Whole or not at all, as write_file.
void write_safetensors(const std::filesystem::path& file, std::span<const TensorView> tensors,
                       const std::map<std::string, std::string>& metadata);

}  // namespace fresco::weights
