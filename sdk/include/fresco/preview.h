#pragma once

#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace fresco
{

class Frames;

/// What the page of a run shows of one artifact; Artifact::preview fills it in. Used by one thread.
class Preview
{
  public:
    /// `codec` reads and encodes pictures; it must outlive the preview.
    explicit Preview(const ImageIo& codec) : images(codec) {}

    const ImageIo& images;
    /// Show what belongs to these: names of pictures that stages made of this artifact and the page shows ("views/s_7.png").
    /// Files show exactly those of their own. Empty: the artifact chooses.
    std::vector<std::string> names;
    bool last = true;                         ///< No later stage makes this type of artifact; show large things only then.
    std::size_t most_pictures = 12;           ///< At most so many.
    int longest_px = 720;                     ///< Longer side of a picture on the page.
    std::uintmax_t video_bytes = 24'000'000;  ///< What videos may still take of the page.

    /// Adds a copy of at most `longest_px` as JPEG. `more` are further entries of the picture (sdk/docs/report.md).
    void picture(const std::string& name, const Raster8& pixels, Value::Map more = {});
    /// Adds a video file as it is. Throws Error where it is too large for the page.
    void video(const std::string& name, const std::filesystem::path& file);
    /// Says what the page lacks.
    void note(const std::string& text);
    /// Sets an entry that the page draws: "room", "cameras" (sdk/docs/report.md).
    void set(std::string_view name, Value value) { value_.set(name, std::move(value)); }
    /// {pictures: [{name, uri, …}], notes: [text], …}; entries without content are absent.
    const Value& value() const { return value_; }

  private:
    void append(std::string_view list, Value entry);

    Value value_{Value::Map{}};
};

/// The entry "cameras" of a page, of at least one frame: the first, the upward direction of all, and their mean direction.
Value page_cameras(const Frames& frames);

/// The entry "room" of a page for a mesh that has texcoords and passed check_mesh; `texture` is its picture, a JPEG.
Value page_room(const Mesh& mesh, std::span<const std::byte> texture);

/// A copy whose longer side is at most `longest_px`, of 1 or 3 channels: alpha is composited on white.
Raster8 small_copy(const Raster8& pixels, int longest_px);

/// `count` numbers below `size`, evenly spread, ascending; all where there are no more.
std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count);

/// Whether the name ends as a picture's that every codec reads: .png, .jpg, .jpeg.
bool is_picture(const std::filesystem::path& file);

}  // namespace fresco
