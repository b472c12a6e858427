#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/option.h>
#include <fresco/parallel.h>
#include <fresco/rendering/mip_maps.h>
#include <fresco/texture.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Pictures of a textured mesh as cameras see it, and the options of the stages that make them.

namespace fresco::rendering
{

/// The option `filter`.
Choice<TextureFilter> filter_option(Configurable* owner);

/// A distant lamp and light from everywhere: a color is multiplied by ambient + diffuse · max(0, normal · toward).
struct Lights
{
    double ambient = 1;
    double diffuse = 0;
    Vec3d toward{0, 0, 1};  ///< Unit, from the surface to the lamp, in the mesh's frame.
};

/// "none": colors as they are. "scannet", "matterport3d": the lamps of StyleMesh's published viewers for these data sets
/// (rgb.frag), under which the paper's pictures and tables were made.
Lights lights_of(std::string_view shading);

/// How much light a mesh's surface gets, by its vertex normals.
class Lighting
{
  public:
    /// The mesh must outlive this.
    Lighting(const Mesh& mesh, const Lights& lights);
    /// Brightness at a point of a face, a factor of the color: the sum of its corners times `weights`. Thread-safe.
    double at(std::uint32_t face, const std::array<double, 3>& weights) const;

  private:
    const Mesh& mesh_;
    Lights lights_;
    std::vector<Vec3f> normals_;  ///< V; empty where nothing is shaded.
};

struct RenderOptions
{
    int samples_per_side = 2;  ///< Samples per pixel: its square; one is not enough at edges and far away.
    TextureFilter filter;
    Lights lights = {};          ///< By the vertex normals, interpolated.
    bool through_backs = false;  ///< Faces seen from their back hide nothing.
};

class RasterFinder;

/// Draws a textured mesh as cameras see it, by rasterization (RasterFinder) of several samples per pixel.
class ViewRenderer
{
  public:
    /// The mesh must have passed check_mesh, have texcoords and outlive the renderer. Throws Error if the picture is not RGB.
    ViewRenderer(const TexturedMesh& mesh, const RenderOptions& options);
    ~ViewRenderer();
    ViewRenderer(const ViewRenderer&) = delete;
    ViewRenderer& operator=(const ViewRenderer&) = delete;

    /// RGBA, straight alpha: the share of the pixel's samples that see the front of a face (fresco::sight), and the mean color of
    /// these. Equal for any progress.threads(). Throws Canceled. Thread-safe.
    Raster8 render(const Camera& camera, const Progress& progress) const;

    /// Renders as many views at once as there are threads, and gives each to `take(i, picture)`, on any thread and in any order.
    void render_each(std::span<const Camera> cameras, Progress& progress,
                     const std::function<void(std::size_t, const Raster8&)>& take) const;
    /// Gives the pictures in order and one at a time; the next are rendered during `take`.
    void render_in_order(std::span<const Camera> cameras, Progress& progress,
                         const std::function<void(const Raster8&)>& take) const;

  private:
    struct Workspace;
    struct Idle;

    const Mesh& mesh_;
    RenderOptions options_;
    MipMaps texture_;
    Lighting lighting_;
    std::unique_ptr<const RasterFinder> finder_;  ///< Each workspace begins with a copy.
    std::unique_ptr<Idle> idle_;                  ///< Workspaces that no view uses now.
};

/// The option `shading`, which lights_of reads.
Option<std::string>
shading_option(Configurable* owner,
               const std::string& help = "Lamps: none, or those of StyleMesh's published viewer for a data set");

}  // namespace fresco::rendering
