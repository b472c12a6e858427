#pragma once

#include <fresco/artifact.h>
#include <fresco/camera.h>
#include <fresco/image.h>

#include <filesystem>
#include <string>
#include <vector>

namespace fresco
{

class ImageIo;
class JsonPlace;
class Value;
struct Mesh;

/// A picture on disk: a user's file, or a file of the frames' own folder. Its content hash is taken when it is first listed and
/// compared when it is read.
struct PictureFile
{
    std::filesystem::path path;  ///< Absolute.
    std::string hash;            ///< file_hash; empty = not checked (a file of the store, which is verified anyway).
    bool empty() const { return path.empty(); }
};

/// One recorded view: two cameras, two pictures.
struct Frame
{
    std::string sequence;  ///< "seq-01"; file-name safe.
    std::string name;      ///< "frame-000008"; file-name safe, unique in its sequence.
    long number = 0;       ///< The recorder's frame number.
    Camera color;
    Camera depth;
    PictureFile color_picture;    ///< 8-bit picture of color.intrinsics' size; NPY (uint8 H x W x 3), PNG or JPEG.
    PictureFile depth_picture;    ///< 16-bit picture of depth.intrinsics' size; NPY (uint16 H x W) or PNG; may be empty.
    PictureFile mask;             ///< NPY (uint8 H x W) of color.intrinsics' size: 0 = ignore the pixel. Empty: ignore none.
    double depth_unit_m = 0.001;  ///< Meters per step of the depth picture; 0 and 65535 mean none.
};

/// Posed RGB-D frames in recorded order; pictures stay on disk.
/// On disk: `frames.json` (cameras, names, references; sdk/docs/your-recording.md), and pictures beside it where a stage made
/// them.
class Frames : public Artifact
{
  public:
    static constexpr std::string_view artifact_name = "frames";
    static constexpr int artifact_version = 2;

    std::vector<Frame> frames;
    Vec3d offset_m{};  ///< As Mesh::offset_m: to be added to the cameras' positions.

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Frames> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    /// With plain paths.
    void write_exchange(const Exchange& to) const override;
    /// Pictures of the user are read files of the run, those of the store and of the folder are referred to as such.
    static std::shared_ptr<Frames> from_exchange(const Exchange& from);
};

/// The color picture as RGB (3 channels), of exactly color.intrinsics' size. NPY needs no codec; other formats use `images`,
/// which may be null only then. Thread-safe. Throws Error naming the file if it changed, is damaged or of another size.
Raster8 load_color(const Frame& frame, const ImageIo* images);
/// The depth picture's values as stored. Throws as load_color; Error if the frame has no depth picture.
Raster16 load_depth_steps(const Frame& frame, const ImageIo* images);
/// Such values in meters along the optical axis, 0 = none. `unit_m`: Frame::depth_unit_m.
RasterF depth_in_meters(const Raster16& steps, double unit_m);
/// Both in one. Throws as load_depth_steps.
RasterF load_depth(const Frame& frame, const ImageIo* images);

/// The mask, of exactly color.intrinsics' size; empty (0 x 0) if the frame has none. Throws as load_color.
Raster8 load_mask(const Frame& frame);
/// A mask at another size: 0 where a pixel covers an ignored one in whole or in part, else 255. Empty for an empty mask.
Raster8 mask_at(const Raster8& mask, int width, int height);

/// Throws Error naming `source` unless the camera is usable: positive size, focal lengths from a hundredth to 10 000 times the
/// longer side (from 178 degrees to 20 arc seconds), the center no more than 10 000 times the longer side away, finite entries, a
/// pose that turns (rotation_error <= 1e-2, determinant positive) and stays within 1e7 m of the world's origin along each axis.
void check_camera(const Camera& camera, std::string_view source);

/// Throws Error unless both have one offset: otherwise the cameras are elsewhere than the mesh says.
void check_offset(const Frames& frames, const Mesh& mesh);

/// A camera in JSON: `width`, `height`, `fx`, `fy`, `cx`, `cy` in pixels, `world_from_camera` as 3 x 4 numbers, row by row.
Value to_value(const Camera& camera);
/// Reads one. Throws Error naming the place of what is missing, or of a camera that is not usable.
Camera camera_from(const JsonPlace& place);

}  // namespace fresco
