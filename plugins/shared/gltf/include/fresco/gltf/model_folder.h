#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace fresco::gltf
{

/// Extension of a picture with these bytes: ".png", ".jpg", ".webp" or ".heic" (AVIF too); empty for anything else.
std::string_view suffix_of(std::span<const std::byte> picture);

/// The folder of a model, for finding the files that the model names. Never leads outside of the folder.
class ModelFolder
{
  public:
    explicit ModelFolder(const std::filesystem::path& model);

    /// The file of this name in the folder or below; backslashes also separate folders. `place` is the position of the name
    /// ("room.obj:3: mtllib") and begins each message; `way_out` ends the one about a missing file. Throws MissingInput if there
    /// is no such file; Error for an address, an absolute path, "..", and links that lead outside.
    std::filesystem::path find(std::string_view name, std::string_view place, std::string_view way_out = {}) const;

    /// Whether find() would succeed.
    bool has(std::string_view name) const;

  private:
    std::filesystem::path folder_;
};

}  // namespace fresco::gltf
