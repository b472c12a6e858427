#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/parallel.h>
#include <fresco/recordings/panorama.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/value.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <utility>

namespace fresco::recordings
{
namespace
{

namespace fs = std::filesystem;

/// "640x480"
std::string size_text(int width, int height)
{
    return fmt::format("{}x{}", width, height);
}

/// Throws Error naming `source` if the principal point is outside of `picture`, for which `k` is: then the intrinsics are for
/// pictures of another size.
void check_center(const Intrinsics& k, const std::string& source, const fs::path& picture)
{
    if (k.cx <= 0 || k.cy <= 0 || k.cx >= k.width || k.cy >= k.height)
        throw Error(source + ": the principal point (" + to_json(k.cx) + ", " + to_json(k.cy) + ") is outside " +
                    picture.string() + ", which is " + size_text(k.width, k.height) +
                    "; use intrinsics for pictures of this size");
}

/// Throws Error naming `file` unless ImageIo::check found 16-bit gray in it, or did not look.
void check_depth_kind(const fs::path& file, const ImageHeader& header)
{
    if (header.bits > 0 && (header.bits != 16 || !header.gray))
        throw Error(fmt::format("{}: expected a depth picture (PNG, one channel of 16 bits), found {} bits{}", file.string(),
                                header.bits, header.gray ? "" : " and colors"));
}

}  // namespace

void check_not_turned(const fs::path& file, const ImageHeader& header, const std::string& source)
{
    if (header.orientation != 1)
        throw Error(fmt::format("{}: its EXIF data rotates it (orientation {}), but {} is for the pixels as stored; remove the "
                                "tag (exiftool -Orientation= FILE)",
                                file.string(), header.orientation, source));
}

std::string renamed(std::string error, const fs::path& hidden, const std::string& name)
{
    const std::string path = hidden.string();
    const auto at = error.find(path);
    if (at != std::string::npos)
        return error.replace(at, path.size(), name);
    return name.empty() ? error : name + ": " + error;
}

Intrinsics intrinsics_for(const CameraMatrix& matrix, PixelCenter center, const ImageHeader& size, const fs::path& picture)
{
    const auto k = intrinsics_from_matrix(matrix.values, center, size.width, size.height, matrix.source);
    check_center(k, matrix.source, picture);
    return k;
}

void RecorderCameras::place(RecordedView& view, const RigidTransform& world_from_depth) const
{
    view.camera = color;
    view.world_from_camera = world_from_depth * depth_from_color;
    view.depth_camera = Camera{depth, world_from_depth};
}

std::optional<RigidTransform> tracked_pose(const std::vector<double>& matrix, const std::string& source)
{
    if (!std::ranges::all_of(matrix, [](double entry) { return std::isfinite(entry); }))
        return std::nullopt;
    return rigid_transform(matrix, source);
}

RigidTransform opencv_pose(std::vector<double> matrix, const std::string& source)
{
    for (std::size_t entry = 0; entry + 4 < matrix.size(); ++entry)
        if (entry % 4 == 1 || entry % 4 == 2)
            matrix[entry] = -matrix[entry];
    return rigid_transform(matrix, source);
}

namespace
{

constexpr int jpeg_quality = 95;
/// Recorders round the size of depth pictures.
constexpr double shape_tolerance = 0.02;

std::string file_name_safe(std::string text)
{
    for (char& c : text)
        if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.'))
            c = '_';
    if (text.starts_with('.'))
        text.front() = '_';
    return text;
}

/// Sequences of the frames that a view gives.
std::vector<std::string> frame_sequences(const RecordedView& view)
{
    if (!view.is_panorama)
        return {view.sequence};
    std::vector<std::string> sequences;
    for (const char* face : {"front", "right", "back", "left", "up", "down"})
        sequences.push_back(view.sequence + "_" + face);
    return sequences;
}

void refuse_doubles(const std::vector<RecordedView>& views)
{
    std::map<std::pair<std::string, std::string>, const RecordedView*> seen;
    for (const auto& view : views)
        for (const auto& sequence : frame_sequences(view))
            if (const auto [other, is_new] = seen.try_emplace({sequence, view.name}, &view); !is_new)
                throw Error(view.source + ": the view " + sequence + "/" + view.name + " appears twice, first at " +
                            other->second->source + "; remove one");
}

void check_size(const fs::path& file, const ImageHeader& header, const Intrinsics& camera, const std::string& source)
{
    if (header.width != camera.width || header.height != camera.height)
        throw Error(file.string() + ": the picture is " + size_text(header.width, header.height) + "; its camera (" + source +
                    ") is for pictures of " + size_text(camera.width, camera.height) +
                    "; all pictures of a camera must have the size of its intrinsics");
}

/// Throws unless a depth picture can show what the color picture shows: it has the same shape, within a pixel.
void check_shape(const fs::path& file, const ImageHeader& depth, const Intrinsics& color, const std::string& source)
{
    const double wide = static_cast<double>(depth.width) * color.height, high = static_cast<double>(color.width) * depth.height;
    if (std::abs(wide - high) > shape_tolerance * high + std::max(color.width, color.height))
        throw Error(file.string() + ": the depth picture is " + size_text(depth.width, depth.height) +
                    " and the color picture of " + source + " is " + size_text(color.width, color.height) +
                    ": they must have one aspect ratio; was one of them rotated or cropped?");
}

class FrameMaker
{
  public:
    FrameMaker(const ImageIo& images, const fs::path& folder, const UnpackView& unpack, std::atomic<std::size_t>& transparent)
        : images_(images), folder_(folder), unpack_(unpack), transparent_(transparent)
    {
    }

    std::vector<Frame> make(RecordedView view) const
    {
        if (view.is_panorama)
            return frames_of_panorama(view);
        check_camera({view.camera, view.world_from_camera}, view.source);
        if (view.depth_camera)
            check_camera(*view.depth_camera, view.source);
        if (!unpack_ || !unpack_(view, folder_))
            return {frame_of(view, original)};
        try
        {
            // Files that were not written stay where they are.
            return {
                frame_of(view,
                         [this](const fs::path& file) {
                             return file.string().starts_with((folder_ / "").string()) ? PictureFile{file, ""} : original(file);
                         })};
        }
        catch (const Error& error)
        {
            throw Error(view.source + ": a picture in it cannot be used (" + renamed(error.what(), folder_ / "", "") + ")");
        }
    }

  private:
    /// As ImageIo::check, also of NPY files, which need no codec.
    ImageHeader checked(const fs::path& file, bool is_color) const
    {
        if (file.extension() != ".npy")
            return images_.check(file);
        const NpyArray array = read_npy(file);
        const auto& shape = array.shape;
        if (is_color ? shape.size() != 3 || shape[2] != 3 || array.type != NpyType::uint8
                     : shape.size() != 2 || array.type != NpyType::uint16)
            throw Error(file.string() + (is_color ? ": expected a picture, uint8 of height x width x 3"
                                                  : ": expected a depth picture, uint16 of height x width"));
        return {static_cast<int>(shape[1]), static_cast<int>(shape[0]), is_color ? 8 : 16, !is_color};
    }
    std::vector<Frame> frames_of_panorama(const RecordedView& view) const
    {
        const auto sequences = frame_sequences(view);
        const auto faces = panorama_faces(view.camera.width);
        std::vector<Frame> frames(faces.size());
        for (std::size_t i = 0; i < faces.size(); ++i)
        {
            auto& frame = frames[i];
            frame.sequence = sequences[i];
            frame.name = view.name;
            frame.number = view.number;
            frame.color = {faces[i].camera, view.world_from_camera * RigidTransform{faces[i].panorama_from_face, {}}};
            frame.depth = frame.color;
            frame.depth_unit_m = view.depth_unit_m;
            check_camera(frame.color, view.source);
        }
        const auto header = checked(view.color, true);
        check_size(view.color, header, view.camera, view.source);
        check_not_turned(view.color, header, view.source);
        check_panorama(view.color, header);
        auto picture = images_.read_rgb(view.color);
        widen_at_poles(picture);
        auto mask = mask_of(view, header.alpha);
        widen_at_poles(mask);
        Raster16 depth;
        if (!view.depth.empty())
        {
            const auto depth_header = checked(view.depth, false);
            check_depth_kind(view.depth, depth_header);
            check_panorama(view.depth, depth_header);
            depth = images_.read_depth(view.depth);
        }
        const auto depth_faces = panorama_faces(depth.width);
        for (std::size_t i = 0; i < faces.size(); ++i)
        {
            auto& frame = frames[i];
            frame.color_picture = write(frame, ".color.jpg", images_.encode_jpeg(face_of(picture, faces[i]), jpeg_quality));
            const auto ignored = mask.empty() ? Raster8{} : ignoring(face_of(mask, faces[i]));
            if (!ignored.empty())
                frame.mask = write_mask(frame, ignored);
            if (depth.empty())
                continue;
            frame.depth.intrinsics = depth_faces[i].camera;
            auto steps = depth_face_of(depth, depth_faces[i]);
            if (!ignored.empty())
                remove_masked(ignored, frame, steps);
            frame.depth_picture = write(frame, ".depth.png", images_.encode_png(steps));
        }
        return frames;
    }
    template <class Reference>
    Frame frame_of(const RecordedView& view, const Reference& reference) const
    {
        const auto color = checked(view.color, true);
        check_size(view.color, color, view.camera, view.source);
        check_not_turned(view.color, color, view.source);
        check_center(view.camera, view.source, view.color);
        Frame frame;
        frame.sequence = view.sequence;
        frame.name = view.name;
        frame.number = view.number;
        frame.color = {pinhole_without(view.lens, view.camera, view.source), view.world_from_camera};
        frame.depth = view.depth_camera.value_or(frame.color);
        frame.depth_unit_m = view.depth_unit_m;
        frame.color_picture = view.lens.distorts() ? undistort_color(view, frame) : reference(view.color);
        Raster8 mask = mask_of(view, color.alpha);
        if (view.lens.distorts() && !mask.empty())
            mask = undistorted(mask, view.camera, view.lens, frame.color.intrinsics);
        mask = ignoring(std::move(mask));
        if (!mask.empty())
            frame.mask = write_mask(frame, mask);
        if (view.depth.empty())
            return frame;
        const auto depth = checked(view.depth, false);
        check_depth_kind(view.depth, depth);
        if (view.depth_camera)
            check_size(view.depth, depth, frame.depth.intrinsics, view.source);
        else
        {
            check_shape(view.depth, depth, view.camera, view.source);
            frame.depth.intrinsics = frame.color.intrinsics.scaled_to(depth.width, depth.height);
        }
        frame.depth_picture = reference(view.depth);
        const bool has_lens = view.lens.distorts() && !view.depth_camera;
        if (!has_lens && mask.empty())
            return frame;
        auto steps = load_depth_steps(frame, &images_);
        if (has_lens)
            steps = undistorted_depth(steps, view.camera, view.lens, frame.color.intrinsics);
        if (!mask.empty())
            remove_masked(mask, frame, steps);
        frame.depth_picture = write(frame, ".depth.png", images_.encode_png(steps));
        return frame;
    }
    static PictureFile original(const fs::path& file) { return {fs::absolute(file), file_hash(file)}; }
    PictureFile write(const Frame& frame, const std::string& ending, const std::vector<std::byte>& bytes) const
    {
        const auto file = folder_ / frame.sequence / (frame.name + ending);
        fs::create_directories(file.parent_path());
        write_file(file, bytes);
        return {file, ""};
    }
    PictureFile undistort_color(const RecordedView& view, const Frame& frame) const
    {
        const auto picture = undistorted(images_.read_rgb(view.color), view.camera, view.lens, frame.color.intrinsics);
        return write(frame, ".color.jpg", images_.encode_jpeg(picture, jpeg_quality));
    }
    Raster8 read_mask(const fs::path& file) const
    {
        if (file.extension() != ".npy")
        {
            Raster8 mask = read_picture(images_, file);
            if (mask.channels == 4)
                throw Error(file.string() + ": the mask has transparent pixels; save it without transparency, black where to "
                                            "ignore the picture and white elsewhere");
            return mask;
        }
        const NpyArray array = read_npy(file);
        if (array.shape.size() != 2 || array.type != NpyType::uint8)
            throw Error(file.string() + ": expected a mask, uint8 of height x width");
        return to_raster<std::uint8_t>(array, file.string());
    }
    /// 0 and 255, of the color picture: 0 where the view's mask is black or the picture transparent. Empty without either.
    Raster8 mask_of(const RecordedView& view, bool has_alpha) const
    {
        Raster8 mask = view.mask.empty() ? Raster8{} : given_mask(view);
        if (!has_alpha)
            return mask;
        const Raster8 picture = read_picture(images_, view.color);
        if (picture.channels != 4)
            return mask;
        if (mask.empty())
            mask = Raster8(picture.width, picture.height, 1, 255);
        bool is_opaque_anywhere = false;
        for (std::size_t i = 0; i < mask.values.size(); ++i)
            if (picture.values[4 * i + 3] < least_opaque_alpha)
                mask.values[i] = 0;
            else
                is_opaque_anywhere = true;
        if (!is_opaque_anywhere)
            throw Error(view.color.string() + ": is transparent everywhere; save it without an alpha channel");
        ++transparent_;
        return mask;
    }
    Raster8 given_mask(const RecordedView& view) const
    {
        const auto picture = read_mask(view.mask);
        if (picture.width != view.camera.width || picture.height != view.camera.height)
            throw Error(view.mask.string() + ": the mask is " + size_text(picture.width, picture.height) + "; the picture of " +
                        view.source + " is " + size_text(view.camera.width, view.camera.height));
        Raster8 mask(picture.width, picture.height);
        for (std::size_t i = 0; i < mask.values.size(); ++i)
        {
            const auto* const channels = &picture.values[i * static_cast<std::size_t>(picture.channels)];
            mask.values[i] = std::any_of(channels, channels + picture.channels, [](auto value) { return value > 0; }) ? 255 : 0;
        }
        return mask;
    }
    /// A resampled mask with 0 for all that ignored pixels are part of; empty if nothing is ignored.
    static Raster8 ignoring(Raster8 mask)
    {
        for (auto& value : mask.values)
            value = value == 255 ? 255 : 0;
        return std::ranges::find(mask.values, 0) != mask.values.end() ? mask : Raster8{};
    }
    PictureFile write_mask(const Frame& frame, const Raster8& mask) const
    {
        const auto file = folder_ / frame.sequence / (frame.name + ".mask.npy");
        fs::create_directories(file.parent_path());
        write_npy(file, mask);
        return {file, ""};
    }
    /// Takes out the depth of points that the color camera sees at ignored pixels.
    static void remove_masked(const Raster8& mask, const Frame& frame, Raster16& steps)
    {
        for (int y = 0; y < steps.height; ++y)
            for (int x = 0; x < steps.width; ++x)
            {
                auto& step = steps.at(x, y);
                const Vec3d ray = frame.depth.ray(x + 0.5, y + 0.5) * (step * frame.depth_unit_m);
                const Vec3d seen = frame.color.project(frame.depth.world_from_camera.translation + ray);
                const double column = std::floor(seen.x), row = std::floor(seen.y);
                if (seen.z > 0 && column >= 0 && row >= 0 && column < mask.width && row < mask.height &&
                    mask.at(static_cast<int>(column), static_cast<int>(row)) == 0)
                    step = 0;
            }
    }

    const ImageIo& images_;
    const fs::path& folder_;
    const UnpackView& unpack_;
    std::atomic<std::size_t>& transparent_;
};

}  // namespace

void name_by_picture(RecordedView& view, const fs::path& listed)
{
    const auto parent = listed.lexically_normal().parent_path().generic_string();
    view.sequence = parent.empty() ? "scan" : file_name_safe(parent);
    view.name = file_name_safe(listed.stem().string());
}

void order_by_name(std::vector<RecordedView>& views)
{
    std::stable_sort(views.begin(), views.end(),
                     [](const RecordedView& a, const RecordedView& b)
                     { return a.sequence != b.sequence ? natural_less(a.sequence, b.sequence) : natural_less(a.name, b.name); });
    std::set<std::pair<std::string, long>> numbers;
    for (auto& view : views)
        if (const auto number = last_number(view.name))
            numbers.emplace(view.sequence, *number);
    const bool all_differ = numbers.size() == views.size();
    for (std::size_t i = 0; i < views.size(); ++i)
        views[i].number = all_differ ? *last_number(views[i].name) : static_cast<long>(i);
}

Vec3d offset_beside(Vec3d frames_offset_m, std::span<const Vec3d> mesh, const std::string& source)
{
    constexpr double most_apart_m = 1e5;  // A room in millimeters is not that far off, maps are.
    const Vec3d own = offset_for(mesh);
    const double apart_m = length(own - frames_offset_m);
    if (apart_m > most_apart_m)
        throw Error(
            fmt::format("{}: the mesh is {:.0f} km from the cameras, around ({}, {}, {}) and ({}, {}, {}) m: one of them "
                        "is in a map's coordinates, such as UTM, and the other is not; move the mesh to the poses' world, "
                        "as scan.mesh does by its option transform",
                        source, apart_m / 1000, own.x, own.y, own.z, frames_offset_m.x, frames_offset_m.y, frames_offset_m.z));
    return frames_offset_m;
}

Frames recorded_frames(const std::vector<RecordedView>& views, const ImageIo& images, const fs::path& folder, Progress& progress,
                       const UnpackView& unpack, std::size_t* transparent_count)
{
    refuse_doubles(views);
    std::atomic<std::size_t> transparent = 0;
    const FrameMaker maker(images, folder, unpack, transparent);
    std::vector<std::vector<Frame>> made(views.size());
    parallel_for_each(views.size(), "frames", progress, [&](std::size_t i) { made[i] = maker.make(views[i]); });
    if (transparent_count != nullptr)
        *transparent_count = transparent;
    Frames result;
    for (std::size_t face = 0; face < panorama_faces_count; ++face)
        for (auto& frames : made)
            if (face < frames.size())
                result.frames.push_back(std::move(frames[face]));
    return result;
}

}  // namespace fresco::recordings
