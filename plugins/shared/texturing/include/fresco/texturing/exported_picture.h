#pragma once

#include <fresco/image_io.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file The picture of a textured mesh as a file: what exports share.

namespace fresco::texturing
{

/// Throws Error if a path below --out contains spaces, at which readers of text headers split names.
void check_path_for_names(const std::string& path);

/// The options of an export that encodes the picture of a textured mesh: declared in the stage as
/// `PictureEncoding encoding{this};`.
class PictureEncoding
{
  public:
    /// `max_texture_px`: the default of the option.
    explicit PictureEncoding(Configurable* owner, int max_texture_px = 0);

    struct Encoded
    {
        Raster8 smaller;  ///< Empty where the picture keeps its size: large ones are not copied.
        std::vector<std::byte> bytes;

        const Raster8& picture(const TexturedMesh& textured) const { return smaller.empty() ? textured.image.pixels : smaller; }
    };
    /// The picture, made smaller where that is asked for, as `extension` says: ".png", ".jpg" or ".jpeg", ".npy" (uint8 H x W
    /// x 3). Throws Error for any other; Canceled.
    Encoded encoded(const TexturedMesh& textured, std::string_view extension, RunContext& run) const;
    /// Reads a file again that holds such bytes. Throws Error naming it unless it is whole and holds the picture: every texel, or
    /// its size where it is JPEG.
    void check(const std::filesystem::path& file, const Raster8& picture) const;

  private:
    Option<int> jpeg_quality_;
    Option<int> max_texture_px_;
    Slot<ImageIo> images_;
};

/// The same where the format is an option too: declared in the stage as `PictureOptions picture{this};`.
class PictureOptions : public PictureEncoding
{
  public:
    explicit PictureOptions(Configurable* owner);

    /// ".png" or ".jpg".
    std::string extension() const;
    /// Writes the picture below `folder` under the name of `mesh_path` with another extension, reads it again and says so.
    /// Returns its name below the folder, which must exist. Throws Error, Canceled.
    std::string write(const TexturedMesh& textured, const std::filesystem::path& folder, const std::string& mesh_path,
                      RunContext& run) const;

  private:
    Option<std::string> image_format_;
};

}  // namespace fresco::texturing
