#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/value.h>
#include <fresco/viewer.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

/// \file What pages that fetch nothing embed: pictures, videos and a room to walk through. For viewers of artifacts, which make
/// entries of the report (sdk/docs/report.md), and for stages that write pages of their own.

namespace fresco::page
{

/// "data:image/jpeg;base64,…" (RFC 4648, section 4, padded, in one line)
std::string data_uri(std::string_view media_type, std::span<const std::byte> bytes);

/// Adds a copy of at most `entry.longest_px` as JPEG. `more` are further entries of the picture.
void add_picture(PageEntry& entry, const ImageIo& images, const std::string& name, const Raster8& pixels, Value::Map more = {});
/// Adds a video file as it is. Throws Error where it is too large for the page.
void add_video(PageEntry& entry, const std::string& name, const std::filesystem::path& file);

/// A copy whose longer side is at most `longest_px`, of 1 or 3 channels: alpha is composited on white.
Raster8 small_copy(const Raster8& pixels, int longest_px);

/// Scripts that show a room (viewer/): showRoom(element, room, {mixture, relief, cameras, up}), for an element with the id "room"
/// and the entries below. Its library is three.js with OrbitControls; empty: it was not found when this was built.
const PageScripts& room_scripts();

/// {position, forward, up} of a camera, in the world.
Value::Map pose(const Camera& camera);

/// The entry "cameras", of at least one frame: the first, the upward direction of all, and their mean direction.
Value cameras(const Frames& frames);

/// The entry "room", of a mesh that has texcoords and passed check_mesh; `texture` is its picture, a JPEG.
Value room(const Mesh& mesh, std::span<const std::byte> texture);

/// The entry "relief", of JPEGs that texturing::world_maps makes.
Value relief(const std::string& atlas, std::span<const std::byte> normals, std::span<const std::byte> roughness);

}  // namespace fresco::page
