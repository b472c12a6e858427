#pragma once

#include <fresco/camera.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/image.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/texture.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

/// \file Measures how well two pictures of a recording agree on the surface that both show. frame_pairs() chooses the pairs;
/// judge_pair() finds the co-visible pixels of a pair and compares its difference with that of a perfect rendering (the
/// resampling floor); summary() averages over pairs. The stage does this for a short and a long gap; the steps are declared for
/// tests.

/// The part of a mesh that a camera sees at its pixel centers.
struct ViewSurface
{
    fresco::Camera camera;
    fresco::RasterF depth;                    ///< H x W, meters along the optical axis; 0 = no face seen from its front.
    fresco::Raster8 inner;                    ///< H x W, 1 if the pixel and its neighbors within the picture have depth.
    fresco::Raster<std::uint32_t> triangles;  ///< H x W; Hit::none where depth is 0.

    /// World point at a pixel center. \pre depth.at(x, y) > 0
    fresco::Vec3d point(int x, int y) const
    {
        return camera.world_from_camera.translation + camera.ray(x + 0.5, y + 0.5) * double{depth.at(x, y)};
    }
};

/// Casts the camera's rays by the rules of uvmaps.raster. Equal for any progress.threads(). Throws Canceled.
ViewSurface view_surface(const fresco::raycast::Scene& scene, const fresco::Camera& camera, const fresco::Progress& progress);

/// Fills `inner` from `depth`.
void find_inner_pixels(ViewSurface& view);

/// A bilinear lookup: at most four pixels and the shares of the second column and row.
struct Lookup
{
    fresco::numerics::Between<double> x, y;
};

/// A pixel of the source picture and the place of the same surface point in the target picture.
struct Match
{
    int x = 0;
    int y = 0;
    Lookup target;
};

/// The source's pixels whose surface point both cameras see, row by row. The point lies between the target's pixel centers, and
/// at every target pixel that contributes to the bilinear value |z - depth| <= 2 % of z + 1 cm. Pixels beside one without surface
/// are left out in both pictures: renders are antialiased there.
std::vector<Match> covisible(const ViewSurface& source, const ViewSurface& target);

/// The printed figure of a pair of RGB pictures: the mean over matches and channels of |source - target| on the scale 0..1.
/// NaN without matches.
double reprojection_difference(const fresco::Raster8& source, const fresco::Raster8& target, const std::vector<Match>& matches);

/// Difference of the source picture to itself moved by one pixel: the mean over matches, channels and the two forward
/// differences (to the right, downwards) that exist. 0 for a picture without detail. NaN without matches.
double forward_difference(const fresco::Raster8& source, const std::vector<Match>& matches);

/// Variance of the 4-neighbor Laplacian of the gray picture (0.299 R + 0.587 G + 0.114 B, 0..255) over the matches that are not
/// at the picture's border. NaN without matches.
double sharpness(const fresco::Raster8& source, const std::vector<Match>& matches);

/// A mesh's colors, looked up so coarsely that none of two cameras undersamples them: RGB in 0..255 at a point of a triangle's
/// plane, the same for cameras (a, b) as for (b, a). Thread-safe.
using SurfacePaint =
    std::function<fresco::Vec3d(std::uint32_t triangle, fresco::Vec3d point, const fresco::Camera& a, const fresco::Camera& b)>;

/// The picture of a textured mesh, which must have texcoords and outlive the paint. `lights` as the judged pictures have them.
/// Throws Error unless the picture is RGB.
SurfacePaint texture_paint(const fresco::TexturedMesh& textured, const fresco::rendering::Lights& lights = {});

/// The position of a frame in its recording.
struct FramePlace
{
    std::string sequence;
    long number = 0;  ///< The recorder's frame number.
};

struct FramePair
{
    std::size_t source = 0;
    std::size_t target = 0;
    friend bool operator==(const FramePair&, const FramePair&) = default;
};

/// Pairs within a sequence, in the order of their sources: the target's recorded number is the source's plus `gap`, and sources
/// without a target are left out. Indices into `frames`. \pre gap > 0
std::vector<FramePair> frame_pairs(const std::vector<FramePlace>& frames, long gap);

/// The smallest difference of recorded numbers within a sequence; 0 if there is none.
long smallest_gap(const std::vector<FramePlace>& frames);

/// A picture and the surface that it shows.
struct JudgedView
{
    ViewSurface surface;
    fresco::Raster8 picture;  ///< RGB, of the camera's size.
};

/// The figures of one pair. If `dropped`, only `covisible` is measured.
struct PairFigures
{
    FramePair pair;
    double covisible = 0;  ///< Share of the source's pixels, 0..1.
    bool dropped = false;
    bool flat = false;     ///< The source has no detail over these pixels: the value is meaningless, there is no headline.
    double value = 0;      ///< reprojection_difference
    double floor = 0;      ///< The difference for pictures of a low-passed surface: the resampling floor.
    double detail = 0;     ///< forward_difference
    double sharpness = 0;  ///< Variance of the Laplacian.
    double headline = 0;   ///< (value - floor) / detail; NaN if flat.
};

/// The figures of a pair by their names in the file, where they are measured.
inline constexpr std::array<std::pair<const char*, double PairFigures::*>, 5> named_figures{
    {{"value", &PairFigures::value},
     {"floor", &PairFigures::floor},
     {"sharpness", &PairFigures::sharpness},
     {"detail", &PairFigures::detail},
     {"headline", &PairFigures::headline}}};

/// Measures a pair, or drops it where a smaller share of the source's pixels than `min_covisible` is co-visible. Without a paint,
/// the floor is that of the source's projected picture. Throws Canceled.
PairFigures judge_pair(const FramePair& pair, const JudgedView& source, const JudgedView& target, const fresco::Mesh& mesh,
                       const SurfacePaint& paint, double min_covisible, const fresco::Progress& progress);

struct Figure
{
    double value = 0;
    fresco::evaluation::Interval interval;
};

/// Means over the pairs that were not dropped, with intervals over their source frames; the headline over those that are not
/// flat.
struct GapFigures
{
    std::size_t kept = 0;
    std::size_t dropped = 0;
    std::size_t flat = 0;
    bool invalid = false;  ///< No pair was kept, or at least half of these are flat.
    std::array<Figure, named_figures.size()> figures;
};

GapFigures summary(const std::vector<PairFigures>& pairs, const fresco::evaluation::Bootstrap& bootstrap);
