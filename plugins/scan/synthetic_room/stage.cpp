#include "furnish.h"
#include "noise.h"
#include "recording.h"
#include "scan_mesh.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/regions/regions.h>
#include <fresco/stage.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace
{

constexpr int jpeg_quality = 95;
/// In the order of room::Part.
const std::vector<std::string> part_names{"floor", "ceiling", "walls", "furniture"};

class ScanSyntheticRoom final : public fresco::Stage
{
    fresco::Option<int> seed{this, "seed", 1, fresco::range(0, 1'000'000'000),
                             "Another seed gives another room: books, textures and noise"};
    fresco::Option<std::vector<double>> size_m{this,
                                               "size_m",
                                               {4.5, 3.6, 2.6},
                                               fresco::range(2.3, 12),
                                               "Length (3.5 to 12), width (3 to 8) and height (2.3 to 4) of the room"};
    fresco::Option<int> frames_count{this, "frames_count", 48, fresco::range(1, 10'000), "Views to record"};
    fresco::Option<int> color_width_px{this, "color_width_px", 640, fresco::range(16, 4096), "Width of the color pictures"};
    fresco::Option<int> color_height_px{this, "color_height_px", 480, fresco::range(16, 4096), "Height of the color pictures"};
    fresco::Option<std::vector<int>> depth_px{
        this, "depth_px", {320, 240}, fresco::range(16, 4096), "Width and height of the depth pictures"};
    fresco::Option<double> noise_m{this, "noise_m", 0.003, fresco::range(0, 0.02), "Scanner error in mesh and depth; 0: none"};
    fresco::Option<double> edge_m{this, "edge_m", 0.03, fresco::range(0.008, 0.2), "Length of the mesh's edges"};
    fresco::Slot<fresco::ImageIo> images{this, "Reads and writes pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "Views of a color and a depth camera"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The room as scanned"};
    fresco::Output<fresco::Regions> regions{this, "regions", fresco::Parts{part_names},
                                            "What each face of the mesh shows, exactly; furniture: all else"};

    void check_sizes() const
    {
        if (depth_px->size() != 2)
            throw fresco::Error(fmt::format("option \"depth_px\" has {} numbers; expected [width, height]", depth_px->size()));
        const bool fits =
            size_m->size() == 3 && (*size_m)[0] >= 3.5 && (*size_m)[1] >= 3 && (*size_m)[1] <= 8 && (*size_m)[2] <= 4;
        if (!fits)
            throw fresco::Error(
                fmt::format("option \"size_m\" is [{}]; expected [length, width, height], a length from 3.5 to 12, a "
                            "width from 3 to 8 and a height from 2.3 to 4",
                            fmt::join(*size_m, ", ")));
    }

    void run(fresco::RunContext& run) override
    {
        const auto random = room::hash(static_cast<std::uint32_t>(*seed), 5u);
        const auto noise = static_cast<float>(*noise_m), edge = static_cast<float>(*edge_m);
        check_sizes();
        const auto meters = [&](std::size_t axis) { return static_cast<float>((*size_m)[axis]); };
        const fresco::Vec3f size{meters(0), meters(1), meters(2)};
        const auto scene = room::furnish(size, static_cast<std::uint32_t>(*seed));
        const room::Caster caster(scene);
        const room::LightMap light(caster, run);
        const auto net = room::surface_net(scene, edge, run);
        const auto whole = room::noisy_mesh(net, scene, light, edge, noise, random, run);
        room::SeenVertices seen(net.positions.size());

        frames = record(caster, light, random, net, seen, run);
        auto parts = room::parts_of_faces(net, scene);
        auto scanned = room::seen_part(whole, seen, parts);
        run.report("frames", *frames_count);
        run.report("solids", scene.solids.size());
        run.report("faces", scanned.triangles.size());
        run.report("unseen_share", 1 - static_cast<double>(scanned.triangles.size()) / static_cast<double>(net.triangles.size()));
        run.message(fmt::format("{} frames, {} faces", *frames_count, scanned.triangles.size()));
        fresco::Regions labels;
        labels.atlas = atlas_id(scanned);
        labels.names = part_names;
        for (const room::Part part : parts)
            labels.label_of_face.push_back(static_cast<std::uint16_t>(part));
        regions = std::move(labels);
        mesh = std::move(scanned);
    }

    fresco::Frames record(const room::Caster& caster, const room::LightMap& light, std::uint32_t random,
                          const room::SurfaceNet& net, room::SeenVertices& seen, fresco::RunContext& run) const
    {
        const auto recorder = room::make_recorder(*color_width_px, *color_height_px, (*depth_px)[0], (*depth_px)[1]);
        const auto path = room::camera_path(caster.scene(), *frames_count, random);
        fresco::Frames recorded;
        recorded.frames.resize(path.size());
        fresco::parallel_for_each(path.size(), "frames", run,
                                  [&](std::size_t i)
                                  {
                                      auto& frame = recorded.frames[i];
                                      frame.sequence = "seq-01";
                                      frame.name = fmt::format("frame-{:06}", i);
                                      frame.number = static_cast<long>(i);
                                      frame.depth = {recorder.depth, path[i]};
                                      frame.color = {recorder.color, path[i] * recorder.color_from_depth.inverse()};
                                      write_pictures(caster, light, room::hash(random, static_cast<std::uint32_t>(i)), net, seen,
                                                     frame);
                                  });
        return recorded;
    }

    void write_pictures(const room::Caster& caster, const room::LightMap& light, std::uint32_t random,
                        const room::SurfaceNet& net, room::SeenVertices& seen, fresco::Frame& frame) const
    {
        const auto exact = room::render_depth(caster, frame.depth);
        room::mark_seen(net.positions, exact, frame.depth, seen);
        const auto depth = room::sense_depth(exact, static_cast<float>(*noise_m), random + 1);
        frame.depth_picture.path = frames.folder().path / (frame.name + ".depth.png");
        fresco::write_file(frame.depth_picture.path, images->encode_png(depth));
        const auto color = room::render_color(caster, light, frame.color, random);
        frame.color_picture.path = frames.folder().path / (frame.name + ".color.jpg");
        fresco::write_file(frame.color_picture.path, images->encode_jpeg(color, jpeg_quality));
    }
};

}  // namespace

FRESCO_STAGE("scan.synthetic_room", ScanSyntheticRoom, "Generates a furnished, textured room and its recording from a seed")
