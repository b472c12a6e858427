#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/parallel.h>
#include <fresco/uv_mapping/into_camera.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/// \file Measures the blur of pictures by comparison with other pictures of the same surface: a plain wall and a blurred picture
/// both have little detail, but only the blurred one has less than other pictures of its surface. The stage measures all frames
/// and drops the blurred ones (selection.h).

namespace fresco::sharpest
{

/// Directions along which pictures are compared with themselves: right, down, and the two diagonals.
inline constexpr std::size_t directions_count = 4;

/// Distances, in steps along a direction.
inline constexpr std::array<int, 4> lags{1, 2, 4, 8};

inline constexpr int block_px = 16;

/// The detail of one block: the mean squared difference of gray levels (0..255) between pixels a lag apart, and the mean gray
/// level.
///
/// The change at lag n, divided by n², is the change at lag 1 that the picture would have if it were blurred along the direction
/// by n steps: the difference of neighbors in the mean of n pixels is that of its ends, divided by n.
struct BlockDetail
{
    std::array<std::array<float, lags.size()>, directions_count> change{};
    float gray = 0;
};

/// The fine detail of a picture, block by block.
struct Detail
{
    int columns = 0;
    int rows = 0;
    int width = 0;  ///< Width of the picture at the measured size.
    int height = 0;
    std::vector<BlockDetail> blocks;  ///< Row by row; pixels beyond the last whole block are left out.
};

/// `rgb`: 3 channels. Thread-safe.
Detail detail_of(const Raster8& rgb);

/// The surface that a picture shows, one point per block, by the frame's depth picture.
class SeenSurface
{
  public:
    /// Without a depth picture: sees no surface.
    SeenSurface() = default;
    /// `depth`: meters, of the depth camera. `color`: the camera of the picture of `blocks`. Both cameras must
    /// have passed check_camera.
    SeenSurface(const RasterF& depth, const Camera& depth_camera, const Camera& color, const Detail& blocks);

    struct Point
    {
        Vec3f world;
        Vec2f pixel;        ///< Its place in this picture.
        float depth_m = 0;  ///< 0: unknown.
    };
    /// One per block; empty if the frame has no depth picture.
    const std::vector<Point>& points() const { return points_; }

    struct Place
    {
        std::size_t block;
        Vec2f pixel;
    };
    /// The place of a world point in this picture; nullopt if it is outside or occluded.
    std::optional<Place> place_of(Vec3f world) const;

  private:
    Vec2d pixel_of(Vec3d in_camera) const;
    std::optional<std::size_t> block_at(Vec2d pixel) const;

    Intrinsics color_;
    std::optional<IntoCamera> camera_from_world_;
    int columns_ = 0;
    int rows_ = 0;
    std::vector<Point> points_;
};

/// The data of a frame for measuring its blur.
struct BlurView
{
    std::string sequence;
    Detail detail;
    SeenSurface surface;
};

/// The blur of each picture relative to sharper neighbors in the recording that see the same surface: the length in pixels (of a
/// picture 480 px high) of the line that would blur those as much, along the direction of its maximum. 0 for the
/// sharpest picture, and for pictures without detail in common with a neighbor; at most about 11. Views without a surface are
/// compared as a whole with the two before and the two after. Deterministic. Throws Canceled.
///
/// Crete et al., "The blur effect" (2007), compare the detail of a picture with that of the same picture, blurred further. This
/// compares frames instead, so that the picture's content cancels.
std::vector<double> blur_px(const std::vector<BlurView>& views, Progress& progress);

/// The views among the dropped ones that must stay, least blurred first: each shows a piece of surface, of two by two blocks,
/// that neither a kept view nor an earlier view of the list shows. Throws Canceled.
std::vector<std::size_t> needed_views(const std::vector<BlurView>& views, const std::vector<double>& blur,
                                      const std::vector<bool>& is_kept, const Progress& progress);

}  // namespace fresco::sharpest
