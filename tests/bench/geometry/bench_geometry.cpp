// Decimation and uv maps: time, memory and quality of every implementation on the same meshes.
#include "bench.h"
#include "decimate.h"
#include "furnish.h"
#include "recording.h"
#include "scan_mesh.h"
#include "surface_figures.h"

#include <fresco/camera.h>
#include <fresco/geometry/repair.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/raycast/ray_finder.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#ifdef FRESCO_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#ifdef FRESCO_HAS_OPENMESH
#include "decimate_openmesh.h"
#endif

namespace bench
{
namespace
{

/// A progress that allows so many threads.
class Threads final : public fresco::Progress
{
  public:
    explicit Threads(int count) : count_(count) {}
    int threads() const override { return count_; }

  private:
    int count_;
};

/// What the suite runs over.
struct GeometryInput
{
    std::string name;
    fresco::Mesh mesh;
    std::vector<fresco::Camera> cameras;  ///< 640 x 480, inside the scanned room.
};

struct GeometrySettings
{
    std::vector<int> heights_px{256, 432, 608, 784};
    double keep = 0.1;               ///< Share of the faces that decimation leaves.
    std::vector<std::size_t> faces;  ///< Decimates to these numbers of faces in place of `keep`, where there are more.
    int repeats = 1;                 ///< Of a decimation; the fastest counts.
    std::size_t samples = 50'000;    ///< Points per surface for distances.
    int threads = 1;
};

constexpr std::uint32_t seed = 1;
constexpr float noise_m = 0.003F;
/// So that the views together have seen most of the room.
constexpr int scanning_views = 32;

fresco::Vec3d box_center(const fresco::Mesh& mesh)
{
    fresco::Vec3f low = mesh.positions.front();
    fresco::Vec3f high = low;
    for (const auto& p : mesh.positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return fresco::vec_cast<double>((low + high) * 0.5F);
}

/// The room of scan.synthetic_room with seed 1, 4.5 x 3.6 x 2.6 m, 3 mm of noise, as `views` depth pictures show it: about
/// 240 000 faces for edges of 3 cm.
GeometryInput synthetic_room(double edge_m, int views, fresco::Progress& progress)
{
    const auto edge = static_cast<float>(edge_m);
    const auto scene = room::furnish({4.5F, 3.6F, 2.6F}, seed);
    const room::Caster caster(scene);
    const room::LightMap light(caster, progress);
    const auto net = room::surface_net(scene, edge, progress);
    const auto whole = room::noisy_mesh(net, scene, light, edge, noise_m, seed, progress);
    room::SeenVertices seen(net.positions);
    const auto recorder = room::make_recorder(640, 480, 320, 240);
    GeometryInput input{"synthetic room", {}, {}};
    const auto path = room::camera_path(scene, scanning_views, seed);
    for (std::size_t i = 0; i < path.size(); ++i)
    {
        const fresco::Camera depth{recorder.depth, path[i]};
        seen.add_view(room::render_depth(caster, depth), depth);
        const auto every = static_cast<std::size_t>(std::max(scanning_views / views, 1));
        if (i % every == 0 && input.cameras.size() < static_cast<std::size_t>(views))
            input.cameras.push_back({recorder.color, path[i] * recorder.color_from_depth.inverse()});
    }
    auto parts = room::parts_of_faces(net, scene);
    input.mesh = room::seen_part(whole, seen, parts);
    return input;
}

/// Any mesh; the cameras stand in the middle of its box and look around.
GeometryInput mesh_file(const std::filesystem::path& file, int views)
{
    GeometryInput input{file.filename().string(), fresco::read_mesh(file), {}};
    const auto center = box_center(input.mesh);
    for (int i = 0; i < views; ++i)
    {
        const double turn = 2 * std::numbers::pi * i / views;
        fresco::Camera camera;
        camera.intrinsics = {640, 480, 520, 520, 320, 240};
        // Columns: right, down (-z) and forward in the world, whose z points up.
        camera.world_from_camera.rotation.m = {std::sin(turn), 0, std::cos(turn), -std::cos(turn), 0, std::sin(turn), 0, -1, 0};
        camera.world_from_camera.translation = center;
        input.cameras.push_back(camera);
    }
    return input;
}

/// A way to simplify a manifold mesh to about so many faces, with the threads of the progress.
struct Decimation
{
    std::string name;
    std::function<fresco::Mesh(const fresco::Mesh&, std::size_t, fresco::Progress&)> run;
};

#ifdef FRESCO_HAS_MESHOPTIMIZER
fresco::Mesh meshoptimized(const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
{
    std::vector<unsigned int> indices;
    indices.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        indices.insert(indices.end(), t.begin(), t.end());
    std::vector<unsigned int> left(indices.size());
    // A number for the error's limit that is never reached: only the count ends it.
    const std::size_t count =
        meshopt_simplify(left.data(), indices.data(), indices.size(), &mesh.positions[0].x, mesh.positions.size(),
                         sizeof(fresco::Vec3f), 3 * target, std::numeric_limits<float>::max(), 0U, nullptr);
    fresco::Mesh result;
    result.positions = mesh.positions;
    for (std::size_t i = 0; i < count; i += 3)
        result.triangles.push_back({left[i], left[i + 1], left[i + 2]});
    return result;
}
#endif

/// mesh.decimate first, then what the machine has.
const std::vector<Decimation>& decimations()
{
    static const std::vector<Decimation> all = []
    {
        std::vector<Decimation> found{{"mesh.decimate",
                                       [](const fresco::Mesh& mesh, std::size_t target, fresco::Progress& progress)
                                       { return decimated(mesh, {.max_faces = target}, progress); }}};
#ifdef FRESCO_HAS_MESHOPTIMIZER
        found.push_back({"meshoptimizer " + std::to_string(MESHOPTIMIZER_VERSION / 1000) + "." +
                             std::to_string(MESHOPTIMIZER_VERSION / 10 % 100),
                         meshoptimized});
#endif
#ifdef FRESCO_HAS_OPENMESH
        found.push_back({"mesh.decimate_openmesh", decimated_openmesh});
#endif
        return found;
    }();
    return all;
}

std::size_t target_of(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    if (!settings.faces.empty())
        return settings.faces.back();
    return std::max<std::size_t>(static_cast<std::size_t>(static_cast<double>(mesh.triangles.size()) * settings.keep), 4);
}

fresco::Mesh repaired_alone(const fresco::Mesh& mesh, fresco::Progress& progress)
{
    fresco::geometry::RepairReport report;
    return fresco::geometry::repaired(mesh, report, progress);
}

fresco::Value measured_decimation(const Decimation& decimation, const GeometryInput& input, std::size_t target,
                                  const GeometrySettings& settings, Measure& measure)
{
    // All begin from the same manifold. Only mesh.decimate's own time includes making it: the stage does it.
    Threads progress(settings.threads);
    const fresco::Mesh manifold = repaired_alone(input.mesh, progress);
    const bool ours = &decimation == decimations().data();
    fresco::Mesh result;
    const auto times = measure.times(settings.repeats,
                                     [&]
                                     {
                                         result = ours ? decimation.run(repaired_alone(input.mesh, progress), target, progress)
                                                       : decimation.run(manifold, target, progress);
                                     });
    const auto distance = surface_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto border = border_distance(result, input.mesh, settings.samples, seed, settings.threads).both();
    const auto faults = face_faults(result, input.mesh, settings.threads);
    return fresco::Value::Map{{"seconds", times.wall},
                              {"processor_seconds", times.processor},
                              {"faces_after", result.triangles.size()},
                              {"distance_mean_mm", figure(1e3 * distance.mean)},
                              {"distance_p99_mm", figure(1e3 * distance.p99)},
                              {"distance_largest_mm", figure(1e3 * distance.largest)},
                              {"border_mean_mm", figure(1e3 * border.mean)},
                              {"border_p99_mm", figure(1e3 * border.p99)},
                              {"flipped_faces", faults.flipped},
                              {"degenerate_faces", faults.degenerate},
                              {"non_manifold_edges_created", faults.non_manifold_edges_created}};
}

fresco::Mesh simplified(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    Threads progress(settings.threads);
    return decimated(repaired_alone(mesh, progress), {.max_faces = target_of(mesh, settings)}, progress);
}

Table decimation_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("decimation", "simplified to a share of the faces; how near the result is to its input",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"faces_after", "left"},
                 {"seconds", "s"},
                 {"processor_seconds", "cpu s"},
                 {"times_as_long", "x first", 2},
                 {"peak_mb", "peak MB", 0},
                 {"distance_mean_mm", "mean mm", 3},
                 {"distance_p99_mm", "p99 mm", 3},
                 {"border_mean_mm", "border mean mm", 3},
                 {"border_p99_mm", "border p99 mm", 3},
                 {"flipped_faces", "flipped"},
                 {"degenerate_faces", "flat"},
                 {"non_manifold_edges_created", "non-manifold"}});
    for (const auto& input : inputs)
        for (const std::size_t target : settings.faces.empty() ? std::vector{target_of(input.mesh, settings)} : settings.faces)
        {
            if (target >= input.mesh.triangles.size())
                continue;
            fresco::Value first;
            for (const auto& decimation : decimations())
            {
                auto row =
                    run_case([&](Measure& measure) { return measured_decimation(decimation, input, target, settings, measure); });
                row.set("input", input.name);
                row.set("implementation", decimation.name);
                row.set("faces", input.mesh.triangles.size());
                if (first.is_null())
                    first = entry(row, "seconds");
                row.set("times_as_long", ratio(entry(row, "seconds"), first));
                table.add(std::move(row));
            }
        }
    return table;
}

struct Implementation
{
    std::string name;
    std::function<std::unique_ptr<fresco::FaceFinder>(const fresco::Mesh&)> finder;
};

const std::vector<Implementation>& implementations()
{
    static const std::vector<Implementation> all{
        {"uvmaps.raster", [](const fresco::Mesh& mesh) { return std::make_unique<fresco::rendering::RasterFinder>(mesh); }},
        {"uvmaps.raycast", [](const fresco::Mesh& mesh) { return std::make_unique<fresco::raycast::RayFinder>(mesh); }}};
    return all;
}

/// Maps need texcoords; which ones costs nothing.
fresco::Mesh with_texcoords(const fresco::Mesh& mesh)
{
    fresco::Mesh result = mesh;
    result.texcoords.clear();
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            result.texcoords.push_back({mesh.positions[v].x, mesh.positions[v].y});
    return result;
}

std::string listed(const std::vector<int>& heights)
{
    std::string text;
    for (const int height : heights)
        text += (text.empty() ? "" : "+") + std::to_string(height);
    return text;
}

fresco::Value measured_maps(const fresco::Mesh& mesh, const std::vector<fresco::Camera>& cameras, const Implementation& made,
                            const std::vector<int>& heights, int threads, Measure& measure)
{
    std::unique_ptr<fresco::UvMapper> mapper;
    const auto build = measure.times(1, [&] { mapper = std::make_unique<fresco::UvMapper>(mesh, made.finder(mesh)); });
    fresco::PixelCounts all;
    const Threads progress(threads);
    const auto times = measure.times(2,
                                     [&]
                                     {
                                         all = {};
                                         for (const auto& camera : cameras)
                                             for (const auto& map : mapper->make(camera, heights, progress))
                                                 all += map.counts;
                                     });
    const auto pixels = static_cast<double>(all.valid + all.back_face + all.too_near + all.crack + all.nothing);
    return fresco::Value::Map{{"build_seconds", build.wall},
                              {"ms_per_frame", 1e3 * times.wall / static_cast<double>(cameras.size())},
                              {"processor_ms_per_frame", 1e3 * times.processor / static_cast<double>(cameras.size())},
                              {"million_pixels_per_second", pixels / times.wall / 1e6},
                              {"valid_share", static_cast<double>(all.valid) / pixels},
                              {"back_share", static_cast<double>(all.back_face) / pixels},
                              {"crack_pixels", all.crack}};
}

/// The mesh itself, and what decimation leaves of it where numbers of faces are asked for.
std::vector<fresco::Mesh> meshes_of(const fresco::Mesh& mesh, const GeometrySettings& settings)
{
    std::vector<fresco::Mesh> result{with_texcoords(mesh)};
    for (const std::size_t faces : settings.faces)
    {
        GeometrySettings one = settings;
        one.faces = {faces};
        if (faces < mesh.triangles.size())
            result.push_back(with_texcoords(simplified(mesh, one)));
    }
    return result;
}

Table uv_map_table(const std::vector<GeometryInput>& inputs, const GeometrySettings& settings)
{
    Table table("uv maps", "per frame, each height by itself and all together; the search structure is built once",
                {{"input", "input"},
                 {"implementation", "implementation"},
                 {"faces", "faces"},
                 {"build_seconds", "build s"},
                 {"peak_mb", "peak MB", 0},
                 {"height_px", "height px"},
                 {"threads", "threads"},
                 {"ms_per_frame", "ms/frame", 1},
                 {"processor_ms_per_frame", "cpu ms/frame", 1},
                 {"times_faster", "x one thread", 2},
                 {"million_pixels_per_second", "Mpixels/s"},
                 {"valid_share", "valid", 3},
                 {"crack_pixels", "cracks"}});
    std::vector<std::vector<int>> sizes;
    for (const int height : settings.heights_px)
        sizes.push_back({height});
    if (sizes.size() > 1)
        sizes.push_back(settings.heights_px);
    const auto add =
        [&](const GeometryInput& input, const fresco::Mesh& mesh, const Implementation& made, const std::vector<int>& heights)
    {
        fresco::Value one;
        for (int threads = 1; threads <= settings.threads; threads = threads < settings.threads ? settings.threads : threads + 1)
        {
            auto row =
                run_case([&](Measure& measure) { return measured_maps(mesh, input.cameras, made, heights, threads, measure); });
            row.set("input", input.name);
            row.set("implementation", made.name);
            row.set("faces", mesh.triangles.size());
            row.set("height_px", listed(heights));
            row.set("threads", threads);
            if (one.is_null())
                one = entry(row, "ms_per_frame");
            row.set("times_faster", ratio(one, entry(row, "ms_per_frame")));
            table.add(std::move(row));
        }
    };
    for (const auto& input : inputs)
        for (const auto& mesh : meshes_of(input.mesh, settings))
            for (const auto& made : implementations())
                for (const auto& heights : sizes)
                    add(input, mesh, made, heights);
    return table;
}

constexpr int views = 4;

struct Options
{
    std::vector<std::string> meshes;
    std::string json;
    double edge_m = 0.03;
    bool room = true;
    std::vector<std::string> only{"decimation", "uv-maps"};
    GeometrySettings settings;
};

void add_options(CLI::App& app, Options& options)
{
    auto& settings = options.settings;
    settings.threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
    app.add_option("--mesh", options.meshes, "PLY or OBJ meshes to run over in addition to the room")->check(CLI::ExistingFile);
    app.add_option("--json", options.json, "File for the same figures as JSON");
    app.add_option("--edge-m", options.edge_m, "Edges of the generated room's mesh, meters")
        ->check(CLI::Range(0.01, 0.2))
        ->capture_default_str();
    app.add_option("--keep", settings.keep, "Share of the faces that decimation leaves")
        ->check(CLI::Range(0.001, 1.0))
        ->capture_default_str();
    app.add_option("--faces", settings.faces, "Numbers of faces that decimation leaves, in place of --keep")->delimiter(',');
    app.add_option("--repeats", settings.repeats, "Times that each decimation runs; the fastest counts")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("--only", options.only, "Tables to print")->check(CLI::IsMember({"decimation", "uv-maps"}))->delimiter(',');
    app.add_flag("!--no-room", options.room, "Leave the generated room out");
    app.add_option("--samples", settings.samples, "Points per surface for distances")
        ->check(CLI::Range(100, 10'000'000))
        ->capture_default_str();
    app.add_option("--heights", settings.heights_px, "Heights of the uv maps")
        ->check(CLI::Range(16, 4096))
        ->delimiter(',')
        ->capture_default_str();
    app.add_option("--threads", settings.threads, "Threads")->check(CLI::Range(1, 1024))->capture_default_str();
}

void run(const Options& options)
{
    const auto& settings = options.settings;
    Report report("geometry", fresco::Value::Map{{"threads", settings.threads},
                                                 {"edge_m", options.edge_m},
                                                 {"keep", settings.keep},
                                                 {"samples", settings.samples}});
    std::vector<GeometryInput> inputs;
    Threads progress(settings.threads);
    if (options.room)
        inputs.push_back(synthetic_room(options.edge_m, views, progress));
    for (const auto& file : options.meshes)
        inputs.push_back(mesh_file(file, views));
    for (const auto& name : options.only)
        report.add((name == "decimation" ? decimation_table : uv_map_table)(inputs, settings));
    if (!options.json.empty())
        report.write(options.json);
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv)
{
    CLI::App app{"Times decimation and uv maps on a generated room and measures their quality"};
    bench::Options options;
    bench::add_options(app, options);
    return bench::run_program(app, argc, argv, [&] { bench::run(options); });
}
