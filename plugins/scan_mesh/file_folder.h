#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace scan_mesh
{

/// The way out for a missing material or picture.
inline constexpr std::string_view shape_only = ", or set materials: skip for the shape only";

/// The folder of a model, for the files that the model names. Nothing outside of it is opened.
class FileFolder
{
  public:
    explicit FileFolder(const std::filesystem::path& model);

    /// The file of this name in the folder or below; backslashes separate folders too. `place` says where the name stands
    /// ("room.obj:3: mtllib") and begins each message; `way_out` ends the one about a missing file. Throws MissingInput if there
    /// is no such file; Error for an address, an absolute path, "..", and links that lead outside.
    std::filesystem::path find(std::string_view name, std::string_view place, std::string_view way_out = {}) const;

    /// find() would return it.
    bool has(std::string_view name) const;

  private:
    std::filesystem::path folder_;
};

}  // namespace scan_mesh
