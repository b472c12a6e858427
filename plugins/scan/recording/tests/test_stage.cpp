#include "layout_checks.h"

#include <fresco/recordings/layout.h>

#include <filesystem>

using Catch::Contains;
using namespace fresco;
using namespace fresco::testing;

namespace
{

/// The tiny recording, in memory.
struct MemoryLayout final : recordings::Layout
{
    Frames frames;

    recordings::Recording list(RunContext& /*run*/) override
    {
        recordings::Recording recording{.meshes = {path() / "mesh.ply"}};
        for (const Frame& frame : frames.frames)
        {
            recordings::RecordedView view;
            recordings::name_by_picture(view, frame.name);
            view.color = frame.color_picture.path;
            view.depth = frame.depth_picture.path;
            view.camera = frame.color.intrinsics;
            view.world_from_camera = frame.color.world_from_camera;
            view.source = "memory";
            recording.views.push_back(std::move(view));
        }
        return recording;
    }
};

/// A scan of three views with a mesh.
struct Scan
{
    TemporaryFolder folder;
    RawImages images;
    Frames recorded = tiny_recording(folder.path(), images);

    Scan() { write_mesh(folder.path() / "mesh.ply"); }

    fs::path out() const { return folder.path() / "out"; }
    void read(const Value::Map& more, TestRun& run) const
    {
        auto layout = std::make_shared<MemoryLayout>();
        layout->frames = recorded;
        Value options = Value::Map{{"path", folder.path().string()}};
        for (const auto& [name, value] : more)
            options.set(name, value);
        run_stage(FRESCO_PLUGIN_FILE, "scan.recording", options, {}, out(), run,
                  {{"layout", layout}, {"image_io", std::make_shared<RawImages>()}});
    }
    std::vector<Frame> frames(const Value::Map& more = {}) const
    {
        TestRun run;
        read(more, run);
        return Frames::load({out() / "frames", out()})->frames;
    }
};

}  // namespace

TEST_CASE("a recording is read by its layout, and with what the stage is told of it", "[scan.recording]")
{
    const Scan scan;
    const auto frames = scan.frames();
    REQUIRE(frames.size() == 3);
    CHECK(Mesh::load({scan.out() / "mesh", scan.out()})->triangles.size() == 1);
    CHECK(scan.frames({{"every", 2}}).size() == 2);
    const auto scaled = scan.frames({{"unit_m", 0.5}, {"depth_unit_m", 0.002}});
    CHECK(scaled[1].color.world_from_camera.translation == frames[1].color.world_from_camera.translation * 0.5);
    CHECK(scaled[1].depth_unit_m == 0.002);
    write_mesh(scan.folder.path() / "other.ply", 2);
    scan.frames({{"mesh", (scan.folder.path() / "other.ply").string()}});
    CHECK(Mesh::load({scan.out() / "mesh", scan.out()})->triangles.size() == 2);
    CHECK_THAT(error_of([&] { scan.frames({{"every", 0}}); }), Contains("option \"every\": 0 is too small"));
    // In a map's coordinates, frames and mesh are stored less one offset.
    Scan far;
    for (Frame& frame : far.recorded.frames)
        frame.color.world_from_camera.translation += Vec3d{448'000, 5'411'000, 0};
    CHECK_THAT(error_of(
                   [&] {
                       far.frames({{"mesh", (far.folder.path() / "mesh.ply").string()}});
                   }),
               Contains("mesh.ply: the mesh is 5430 km from the cameras, around (0, 0, 0) and (448000, 5411000, 0) m"));
    write_file(far.folder.path() / "mesh.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
               "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
               "448001.25 5411002.1 0\n448101.5 5411000 0\n448101.5 5411001 0\n3 0 1 2\n");
    const auto near = far.frames();
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(length(near[i].color.world_from_camera.translation - frames[i].color.world_from_camera.translation) < 1e-8);
    const auto mesh = Mesh::load({far.out() / "mesh", far.out()});
    CHECK(mesh->offset_m == Vec3d{448'000, 5'411'000, 0});
    CHECK(Frames::load({far.out() / "frames", far.out()})->offset_m == mesh->offset_m);
    CHECK(mesh->positions[0] == Vec3f{1.25F, 2.1F, 0});
    TestRun large;
    write_mesh(scan.folder.path() / "mesh.ply", 2, 250);
    scan.read({}, large);
    CHECK_THAT(large.messages.front(),
               Contains("warning: the mesh is 250 x 250 x 0 m; set unit_m") && Contains("0.01 if it is in cent"));
    fs::remove(scan.folder.path() / "mesh.ply");
    fs::remove_all(scan.out());
    TestRun run;
    scan.read({}, run);
    CHECK_FALSE(fs::exists(scan.out() / "mesh"));
    CHECK_THAT(run.messages.front(), Contains("there is no mesh; expected") && Contains("mesh.ply, or set option \"mesh\""));
}
