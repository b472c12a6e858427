#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/inspection/agreement.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <cstddef>
#include <functional>
#include <vector>

/// \file Samples a frame for the diagnosis and finds out whether the edges of color pictures lie on the outlines of depth
/// pictures or of the mesh. That judges the color camera without mesh and poses and, in recordings without depth, the poses. The
/// stage draws the same outlines.

namespace fresco::inspect
{

/// Depth of the mesh at the pixel centers of a camera, along the optical axis; 0 where the ray misses it. Both sides of a face
/// count. The same for any number of threads. Throws Canceled.
RasterF mesh_depth(const raycast::Scene& scene, const Camera& camera, const Progress& progress);

/// Depth at a camera's pixels of what another camera measured, nearest first; 0 where it measured nothing.
RasterF seen_from(const Camera& camera, const Camera& other, const RasterF& measured);

/// Nearest neighbor, since depths on both sides of a step must not mix.
RasterF nearest_sampled(const RasterF& depth, int width, int height);

/// Pixels on the near side of depth steps: the next depth to the right, left, above or below is farther by more than 8 % plus 4 %
/// for each pixel without depth between, of which there may be two. With `ends`, also pixels beside three without depth, where a
/// mesh may be cut off. H x W, 1 = outline.
Raster8 outline(const RasterF& depth, bool ends);

/// At most 400 outline pixels of a depth picture.
std::vector<DepthSample> silhouette(const RasterF& depth);

/// How strongly a picture changes at each pixel: the length of the gradient of its log brightness, the largest of 3 x 3 pixels
/// (recorded poses are off by a pixel or two), divided by its mean around the pixel and over the picture, at most 4. H x W.
RasterF edge_strength(const Raster8& rgb);

/// A color picture's edges, and the outline that should lie on them.
struct EdgeView
{
    Intrinsics camera;               ///< At the size of `edges`.
    const RasterF* edges = nullptr;  ///< edge_strength.
    std::vector<Vec2d> outline;      ///< x / z and y / z in the color camera's axes.
};

/// Adds points in the color camera's axes to the view's outline; points behind the camera are left out.
void add_outline(EdgeView& view, const std::vector<Vec3d>& points);

/// Per view: mean strength of the edges at the outline, minus 1. About 0 if outline and picture are unrelated; 0 at points
/// outside the picture and for views with fewer than 20 points.
std::vector<double> edge_responses(const std::vector<EdgeView>& views);

/// Mean over the views with at least 20 points, divided by at least half the number of views; 0 without any.
double edge_response(const std::vector<EdgeView>& views);

/// A frame as the diagnosis sees it.
struct View
{
    std::size_t frame = 0;        ///< Index into Frames::frames.
    DepthView depth;              ///< Without samples if the frame has no depth picture; its camera is the color camera then.
    bool depth_is_empty = false;  ///< There is a depth picture, and all that was sampled of it means none.
    std::vector<DepthSample> silhouette;  ///< Silhouette of the depth picture, in its pixels.
    Intrinsics color;                     ///< At the size of `edges`.
    RasterF edges;                        ///< edge_strength; empty if the frame has no color picture.
    std::vector<Vec2f> pixels;            ///< A grid over the color picture, of the size of `edges`.
};

/// The camera for a picture of another height; the width follows.
Camera at_height(const Camera& camera, int height);

/// Reads a frame's depth picture. Throws as load_depth does.
using DepthReader = std::function<RasterF(const Frame&)>;

/// A frame to look at, see DepthView::group.
struct Chosen
{
    std::size_t frame = 0;
    std::size_t group = 0;
};

/// `count` frames, evenly spread. Without a mesh, half as many groups of up to four of one sequence: 0, 1, 2 and 4 spacings after
/// the first. The spacing is the least of 1, 2, 4, … frames after which depths have changed by more than 4 % at half of the
/// pixels, so that the views of a group differ, and overlap. Throws as `depth` does. \pre frames
std::vector<Chosen> chosen_frames(const Frames& frames, std::size_t count, bool with_mesh, const DepthReader& depth);

/// The frame: depths on a grid of 40 columns, silhouettes and edges at a height of 120 px, at which a tenth of a focal length
/// moves them by four pixels. Throws as check_camera, load_color and `depth` do. Thread-safe if `depth` is. `images`: decodes
/// color pictures.
View view_of(const Frames& frames, const Chosen& chosen, const DepthReader& depth, const ImageIo* images, bool with_color = true);

}  // namespace fresco::inspect
