#include "raw_images.h"
#include "recording_checks.h"

#include <fresco/mesh.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

namespace fs = std::filesystem;
using fresco::Value;
using fresco::testing::RawImages;

namespace
{

/// Runs a reader or the generator; gives the folder of its outputs.
fs::path run(const char* library, const char* type, Value options, const fs::path& out)
{
    fresco::testing::TestFactory factory;
    factory.add("image.raw", [] { return std::make_shared<RawImages>(); });
    options.set("images", Value::Map{{"type", "image.raw"}});
    fresco::testing::TestRun run;
    const auto made = fresco::testing::make_from_plugin(library, type);
    fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*made), options, {}, out, run, factory);
    return out;
}

fresco::Frames frames_in(const fs::path& out)
{
    return *fresco::Frames::load({out / "frames", out});
}

/// Two views of the generated room. Most layouts know one camera: the depth pictures are taken for the color camera's then.
struct Room
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames recorded;
    fresco::Frames frames;

    Room()
    {
        run(SCAN_SYNTHETIC_ROOM_PLUGIN, "scan.synthetic_room",
            Value::Map{{"frames_count", 2},
                       {"color_width_px", 64},
                       {"color_height_px", 48},
                       {"depth_width_px", 32},
                       {"depth_height_px", 24},
                       {"edge_m", 0.1}},
            path("room"));
        recorded = frames_in(path("room"));
        frames = recorded;
        for (auto& frame : frames.frames)
            frame.depth = {frame.color.intrinsics.scaled_to(32, 24), frame.color.world_from_camera};
    }
    fs::path path(const std::string& name) const { return folder.path() / name; }
    fs::path scan() const { return path("layout/scan"); }
    void check_read(const char* library, const char* type, Value options, double depth_step_m = 0.001) const
    {
        options.set("path", scan().string());
        const auto read = frames_in(run(library, type, options, path("out")));
        fresco::testing::check_same_recording(read, frames, images, depth_step_m);
    }
};

}  // namespace

TEST_CASE("the room comes back from nerfstudio's layout", "[recordings]")
{
    const Room room;
    fresco::testing::write_nerfstudio(room.frames, room.scan());
    room.check_read(SCAN_NERFSTUDIO_PLUGIN, "scan.nerfstudio", Value::Map{});
}

TEST_CASE("the room comes back from COLMAP's layouts", "[recordings]")
{
    for (const bool binary : {false, true})
    {
        const Room room;
        fresco::testing::write_colmap(room.frames, room.scan(), binary);
        room.check_read(SCAN_COLMAP_PLUGIN, "scan.colmap", Value::Map{{"depth", (room.scan() / "depth").string()}});
    }
}

TEST_CASE("the room comes back from the layout of TUM RGB-D", "[recordings]")
{
    const Room room;
    fresco::testing::write_tum(room.frames, room.scan());
    const auto& k = room.frames.frames[0].color.intrinsics;
    room.check_read(SCAN_TUM_PLUGIN, "scan.tum",
                    Value::Map{{"intrinsics", Value::List{k.fx, k.fy, k.cx - 0.5, k.cy - 0.5}}, {"depth_unit_m", 0.001}});
}

TEST_CASE("the room comes back from the layout of Replica", "[recordings]")
{
    const Room room;
    fresco::testing::write_replica(room.frames, room.scan());
    const auto mesh = fresco::Mesh::load({room.path("room") / "mesh", {}});
    fresco::write_file(room.path("layout/scan_mesh.ply"), fresco::to_ply(*mesh));
    room.check_read(SCAN_REPLICA_PLUGIN, "scan.replica", Value::Map{}, 1e-6);
    CHECK(fresco::Mesh::load({room.path("out") / "mesh", {}})->positions == mesh->positions);
}

TEST_CASE("the room comes back from the layout of Matterport3D", "[recordings]")
{
    const Room room;
    fresco::testing::write_matterport3d(room.frames, room.scan(), room.images);
    const auto mesh = fresco::Mesh::load({room.path("room") / "mesh", {}});
    fresco::write_file(room.scan() / "house_segmentations/tiny.ply", fresco::to_ply(*mesh));
    room.check_read(SCAN_MATTERPORT3D_PLUGIN, "scan.matterport3d", Value::Map{}, 1e-6);
}

TEST_CASE("the room comes back from Polycam's raw data", "[recordings]")
{
    const Room room;
    fresco::testing::write_polycam(room.frames, room.scan());
    room.check_read(SCAN_POLYCAM_PLUGIN, "scan.polycam", Value::Map{}, 1e-6);
}

#ifdef SCAN_SENS_PLUGIN
TEST_CASE("the room comes back from ScanNet's own recording, with its two cameras", "[recordings]")
{
    const Room room;
    const auto file = room.path("scene0000_00.sens");
    fresco::testing::write_sens(room.recorded, file, room.images);
    const auto read = frames_in(run(SCAN_SENS_PLUGIN, "scan.sens", Value::Map{{"path", file.string()}}, room.path("out")));
    fresco::testing::check_same_recording(read, room.recorded, room.images);
}
#endif
