#pragma once

#include <fresco/artifact.h>
#include <fresco/camera.h>
#include <fresco/image.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Which point of a texture each pixel of a view shows: made once by uvmaps.* and read by everything that paints through
/// views; and the packed form in which the store holds a map.

namespace fresco
{

/// The mesh as one color camera sees it at one size, per pixel center.
struct UvMap
{
    RasterF uv;     ///< H x W x 2, in [0,1], origin lower left; 0 where invalid.
    RasterF depth;  ///< H x W, meters along the optical axis; 0 where invalid.
    RasterF
        cosine;  ///< H x W, cos of the angle between the interpolated normal and the direction to the camera, clamped to [0,1].
    Raster8 valid;  ///< H x W, 1 = the mesh's front is seen here.
};

/// The uv maps of many frames at several heights. Only the index is in memory; load() reads one map.
/// On disk: `uvmaps.json` (frame names, cameras, heights, counts, atlas, texture size, bits) and, for view i (six digits) and
/// height h,
/// `<i>_<h>.uvmap`, one packed map (pack_uv_map; sdk/docs/uv_maps.md says what each byte is, sdk/python/fresco/uv_maps.py reads
/// it with NumPy).
class UvMaps : public Artifact
{
  public:
    static constexpr std::string_view artifact_name = "uv_maps";
    static constexpr int artifact_version = 5;

    struct View
    {
        std::string sequence;                    ///< As in the frames they were made from, …
        std::string frame;                       ///< … matched by (sequence, frame).
        Camera camera;                           ///< The color camera at full size.
        std::vector<std::int64_t> valid_pixels;  ///< Per height.
    };

    std::string atlas;            ///< The mesh's atlas_id; empty: unknown.
    int texture_px = 0;           ///< The mesh's.
    int uv_bits = 16;             ///< Texcoords are within half a step of 1 / (2^uv_bits - 1) of the mesh's; 16 … 22.
    std::vector<int> heights_px;  ///< Ascending.
    std::vector<View> views;

    /// Writes one map while the stage runs, whole or not at all: what load_map gives is rounded as pack_uv_map says, so 16
    /// uv_bits serve textures up to 4096 texels a side; uv_bits_for_texture gives what larger ones need. Thread-safe for
    /// different (view, level). Throws Error as pack_uv_map and write_file do.
    static void write_map(const ArtifactFolder& folder, std::size_t view, int height_px, const UvMap& map, int uv_bits = 16);
    /// Reads one map. Thread-safe. Throws MissingInput if its file is missing, Error naming it if it is damaged or of the wrong
    /// size.
    UvMap load_map(std::size_t view, std::size_t level) const;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<UvMaps> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    /// Reads every map.
    static std::shared_ptr<UvMaps> from_exchange(const Exchange& from);

  private:
    std::filesystem::path folder_;
};

/// Throws Error naming `source` ("the uv maps on port 'uvmaps'") and what to do, unless the maps tell apart the places of a
/// texture of so many texels a side, within 0.032 texel.
void check_uv_bits(const UvMaps& maps, int size_px, std::string_view source);

// The packed form of one uv map, as the store holds it: values rounded to steps, their differences to the neighbors, and
// Zstandard. sdk/docs/uv_maps.md describes it byte by byte.

/// Texcoords in steps of 1 / (2^bits - 1).
constexpr int min_uv_bits = 16;
constexpr int max_uv_bits = 22;

/// The bits that keep a texcoord within 0.032 texel of a square texture of so many texels a side, 16 at least: 16 up to 4096, 18
/// for 16384. Throws std::invalid_argument outside 1 … 262144.
int uv_bits_for_texture(int size_px);

/// The fewest bits whose steps hold every valid pixel's texcoord exactly, as those of an unpacked map do; max_uv_bits if none do,
/// which are within 1.5e-7. Both rasters of one size.
int uv_bits_of(const UvMap& map);

/// The packed form. Errors are at most: texcoords 0.5 / (2^uv_bits - 1), which is 0.0313 texel of 4096 for 16 bits; cosines
/// 1/510; depth 0.5 mm up to 2 km and 5e-7 of the largest beyond, and none below 0.5 mm becomes 0. Packing what was unpacked
/// gives it again. The same map gives the same bytes with the same version of Zstandard. What invalid pixels hold is not looked
/// at. Throws Error naming `source` and the first valid pixel whose texcoord or cosine is not in [0,1] (1e-5 beyond is rounding)
/// or whose depth is negative or not finite; rasters that do not fit together; std::invalid_argument for uv_bits outside 16 … 22.
/// Thread-safe.
std::vector<std::byte> pack_uv_map(const UvMap& map, int uv_bits, std::string_view source);

/// The map of a packed form. Invalid pixels are 0 in every raster. Throws Error naming `source`, the offset, what was expected
/// and what to do, if the bytes are damaged or not of this size; memory stays within the map's and its packed planes'.
/// Thread-safe.
UvMap unpack_uv_map(std::span<const std::byte> bytes, int width, int height, std::string_view source);

}  // namespace fresco
