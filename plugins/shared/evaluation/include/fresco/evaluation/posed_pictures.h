#pragma once

#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>
#include <fresco/texture.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::evaluation
{

/// A picture that shows what a frame's color camera sees.
struct PosedPicture
{
    std::size_t frame = 0;  ///< Index into the frames.
    std::filesystem::path file;
};

/// Extensions of picture files.
inline constexpr std::array<std::string_view, 3> picture_extensions{".png", ".jpg", ".jpeg"};
inline constexpr std::array<std::string_view, 4> picture_or_npy{".png", ".jpg", ".jpeg", ".npy"};

/// The pictures of frames, by file name (<sequence>_<frame>, ending in one of `extensions`), in the order of the frames: of
/// `views` (what render.views made) where it is not null, else of `folder`, which is then noted as read. Frames without a picture
/// are left out, files without a frame too. Throws Error if both or neither are given, two files or two frames share a name, or
/// nothing matches.
std::vector<PosedPicture> posed_pictures(const Frames& frames, const Files* views, const std::filesystem::path& folder,
                                         RunContext& run, std::span<const std::string_view> extensions = picture_extensions);

/// The one of the two that is not null, checked: what the pictures show. Throws Error if both or neither are given, or for what
/// check_mesh refuses.
const Mesh& shown_mesh(const TexturedMesh* textured, const Mesh* plain);

/// The frame's color camera at a picture's size. Throws Error naming `file` unless the aspect ratios agree within 1 % and the
/// camera is usable.
Camera camera_of_picture(const Frame& frame, int width, int height, const std::filesystem::path& file);

}  // namespace fresco::evaluation
