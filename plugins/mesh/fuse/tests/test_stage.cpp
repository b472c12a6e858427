#include "catch.h"
#include "plugin_under_test.h"
#include "raw_images.h"
#include "recordings.h"
#include "room.h"

#include <fresco/frames.h>
#include <fresco/geometry/topology.h>
#include <fresco/hole_closer.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/random.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

using namespace fresco;

namespace
{

/// Depth pictures and gray pictures of a room of `size`, with relative noise of `noise` times the depth.
std::shared_ptr<Frames> recorded(
    const std::filesystem::path& folder, const std::vector<Camera>& cameras, Vec3d size = test_room::size,
    const std::function<double(double)>& noise = [](double) { return 0.0; })
{
    auto frames = std::make_shared<Frames>();
    Random random(5);
    for (const Camera& camera : cameras)
    {
        Frame frame = testing::frame("frame-" + std::to_string(frames->frames.size()), camera);
        RasterF depth = test_room::depth_of(camera, size);
        for (float& value : depth.values)
            value *= static_cast<float>(1 + random.normal() * noise(static_cast<double>(value)));
        testing::set_depth_picture(frame, folder, depth);
        testing::set_color_picture(frame, folder, Raster8(depth.width, depth.height, 3, 90));
        frames->frames.push_back(frame);
    }
    return frames;
}

/// Cameras in the room's middle, each turned by `step` more than the one before.
std::vector<Camera> turning(int count, double step, int width)
{
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i)
        cameras.push_back(test_room::camera_at(i * step, width));
    return cameras;
}

/// Six frames around.
std::shared_ptr<Frames> room_frames(const std::filesystem::path& folder)
{
    return recorded(folder, turning(6, std::numbers::pi / 3, 160));
}

std::shared_ptr<Mesh> fuse_frames(const std::shared_ptr<Frames>& frames, const Value& options, testing::TestRun& run,
                                  const std::shared_ptr<Mesh>& given = nullptr, const std::shared_ptr<ImageIo>& images = nullptr,
                                  const std::shared_ptr<HoleCloser>& holes = nullptr)
{
    testing::Inputs inputs{{"frames", frames}};
    if (given)
        inputs["mesh"] = given;
    std::map<std::string, std::shared_ptr<Component>> components;
    if (images)
        components["image_io"] = images;
    if (holes)
        components["holes"] = holes;
    return testing::output_of<Mesh>("mesh.fuse", "mesh", options, inputs, run, components);
}

/// Looks at every frame's depth, and adds a face.
class OneMoreFace final : public HoleCloser
{
  public:
    Mesh closed(const Mesh& mesh, const std::vector<const Frame*>& measured, const std::function<RasterF(const Frame&)>& depth,
                RunContext&) const override
    {
        for (const Frame* frame : measured)
            CHECK(depth(*frame).width == frame->depth.intrinsics.width);
        Mesh more = mesh;
        more.triangles.push_back({2, 1, 0});
        more.texcoords.clear();
        return more;
    }
};

double inward_share(const Mesh& mesh)
{
    double area = 0;
    double inward = 0;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const Vec3d normal = geometry::area_vector(mesh, face);
        area += length(normal);
        inward +=
            dot(normal, test_room::middle - vec_cast<double>(mesh.positions[mesh.triangles[face][0]])) > 0 ? length(normal) : 0;
    }
    return inward / area;
}

struct FuseTest : testing::StageTest
{
    std::shared_ptr<Frames> frames = room_frames(folder.path());
};

}  // namespace

TEST_CASE_METHOD(FuseTest, "a room is fused from what was recorded in its middle, alike for any number of threads")
{
    const auto mesh = fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, run);
    CHECK(run.reported.at("fused").as_bool());
    CHECK(run.reported.at("frames").as_int() == 6);
    CHECK(run.reported.at("faces").as_int() == static_cast<std::int64_t>(mesh->triangles.size()));
    std::size_t close = 0;
    for (const Vec3f p : mesh->positions)
        close += test_room::distance_to_walls(p) < 0.003 ? 1 : 0;
    CHECK(static_cast<double>(close) > 0.95 * static_cast<double>(mesh->positions.size()));
    // Four walls without their upper and lower parts, and the floor and ceiling around: less than the whole 36 m2.
    const geometry::SurfaceCounts counts = geometry::count_surface(*mesh);
    CHECK(counts.area_m2 > 18);
    CHECK(counts.area_m2 < 36);
    CHECK(counts.complex_edges == 0);
    CHECK(inward_share(*mesh) > 0.999);
    for (const int threads : {1, 3})
    {
        testing::TestRun again(threads);
        const auto same = fuse_frames(frames, Value::Map{{"voxel_m", 0.03}}, again);
        CHECK(to_ply(*same) == to_ply(*mesh));
    }
}

TEST_CASE_METHOD(testing::StageTest,
                 "a depth picture is decoded once, unless too little memory is left to keep it, with the same mesh")
{
    const auto frames = recorded(folder.path(), turning(3, 0.3, 960));
    for (Frame& frame : frames->frames)
    {
        const auto npy = std::exchange(frame.depth_picture.path, folder.path() / (frame.name + ".png"));
        std::filesystem::rename(npy, frame.depth_picture.path);
    }
    constexpr std::int64_t picture_bytes = std::int64_t{2} * 960 * 720;
    const auto images = std::make_shared<testing::RawImages>();
    const auto mesh = fuse_frames(frames, Value::Map{{"voxel_m", 0.1}}, run, nullptr, images);
    CHECK(images->depths == 3);
    images->depths = 0;
    const auto closed = fuse_frames(frames, Value::Map{{"voxel_m", 0.1}}, run, nullptr, images, std::make_shared<OneMoreFace>());
    CHECK(images->depths == 3);
    CHECK(closed->triangles.size() == mesh->triangles.size() + 1);
    CHECK(run.reported.at("depth_bytes").as_int() == 3 * picture_bytes);

    // A quarter holds one picture. The others are decoded by each pass.
    images->depths = 0;
    const auto same = fuse_frames(frames, Value::Map{{"voxel_m", 0.1}, {"max_memory_gb", 0.01}}, run, nullptr, images);
    CHECK(run.reported.at("depth_bytes").as_int() == picture_bytes);
    CHECK(images->depths >= 1 + 2 * 3);
    CHECK(to_ply(*same) == to_ply(*mesh));
}

TEST_CASE_METHOD(FuseTest, "voxels are two pixels wide where none are asked for")
{
    std::vector<double> widths;
    for (const Frame& frame : frames->frames)
        for (const float depth : load_depth(frame, nullptr).values)
            if (depth > 0)
                widths.push_back(static_cast<double>(depth) / frame.depth.intrinsics.fx);
    std::ranges::sort(widths);
    const auto mesh = fuse_frames(frames, Value::Map{{"voxel_m", 0.0}}, run);
    const double voxel = run.reported.at("voxel_m").as_double();
    CHECK(voxel == Approx(2 * widths[widths.size() / 2]).epsilon(0.03));
    testing::TestRun same;
    CHECK(to_ply(*mesh) == to_ply(*fuse_frames(frames, Value::Map{{"voxel_m", voxel}}, same)));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"voxel_m", 0.00005}}, run),
                      Contains("option \"voxel_m\" is 5e-05; expected 0 or at least 0.0001"));
}

TEST_CASE_METHOD(FuseTest, "a mesh that is given is passed on as it is")
{
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    const auto given = std::make_shared<Mesh>(testing::wall());
    given->colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
    const auto passed = fuse_frames(frames, Value::Map{}, run, given);
    CHECK(to_json(run.reported) == R"({"fused":false})");
    CHECK(to_ply(*passed) == to_ply(*given));
    CHECK(fuse_frames(frames, Value::Map{}, run, given, nullptr, std::make_shared<OneMoreFace>())->triangles.size() == 3);
}

TEST_CASE_METHOD(FuseTest,
                 "the share of depths that agree is what it is by hand, and decides between silence, a warning and an error")
{
    // All frames but the first see the walls at 0.7 times the distance, from one place. Of the four that are compared, each of
    // n depths meets three others: 6 n agree, 3 n are seen through, and 3 n lie behind, which counts half.
    frames->frames.assign(5, frames->frames[0]);
    testing::TestRun right;
    fuse_frames(frames, Value::Map{{"voxel_m", 0.05}}, right);
    CHECK(right.reported.at("agreement").as_double() == 1);
    CHECK(right.messages.empty());
    for (std::size_t i = 1; i < 5; ++i)
        frames->frames[i].depth_unit_m *= 0.7;
    testing::TestRun doubtful;
    fuse_frames(frames, Value::Map{{"voxel_m", 0.05}}, doubtful);
    CHECK(doubtful.reported.at("agreement").as_double() == Approx(4 / 7.0).margin(0.005));
    REQUIRE(doubtful.messages.size() == 1);
    CHECK_THAT(doubtful.messages[0], Contains("warning: ") && Contains("all inspected frames have the same pose"));
    // Three frames give 2 n that agree, 2 n that are seen through, and 2 n behind.
    frames->frames.resize(3);
    testing::TestRun wrong;
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"voxel_m", 0.05}}, wrong),
                      Contains("the same pose, but their depth pictures or edges contradict that") &&
                          Contains(". To continue anyway, set check_poses: false"));
    CHECK(wrong.reported.at("agreement").as_double() == Approx(0.4).margin(0.005));
    testing::TestRun unchecked;
    fuse_frames(frames, Value::Map{{"voxel_m", 0.05}, {"check_poses", false}}, unchecked);
    CHECK(unchecked.messages.empty());
}

namespace
{

/// The recording with OpenGL's axes of the depth cameras; the color cameras stay fixed to them.
std::shared_ptr<Frames> opengl(const Frames& recorded)
{
    auto frames = std::make_shared<Frames>(recorded);
    const RigidTransform turned{{1, 0, 0, 0, -1, 0, 0, 0, -1}, {}};
    for (Frame& frame : frames->frames)
    {
        const auto depth_from_color = frame.depth.world_from_camera.inverse() * frame.color.world_from_camera;
        frame.depth.world_from_camera = frame.depth.world_from_camera * turned;
        frame.color.world_from_camera = frame.depth.world_from_camera * depth_from_color;
    }
    return frames;
}

}  // namespace

TEST_CASE("wrong conventions of poses are refused by name, right poses pass silently")
{
    const auto* walk = recordings::walk();
    if (walk == nullptr)
        return;
    const Value options = Value::Map{{"voxel_m", 0.1}};
    const auto run_on = [&](const std::shared_ptr<Frames>& frames, const std::shared_ptr<Mesh>& mesh, testing::TestRun& run)
    { fuse_frames(frames, options, run, mesh, walk->images); };
    testing::TestRun wrong;
    CHECK_THROWS_WITH(run_on(opengl(*walk->frames), nullptr, wrong),
                      Contains("check_poses: false") && Contains("negate the second and third columns"));
    CHECK(wrong.reported.at("agreement").as_double() < 0.5);
    testing::TestRun right;
    run_on(walk->frames, nullptr, right);
    CHECK(right.messages.empty());
    CHECK(right.reported.at("agreement").as_double() > 0.8);

    // The recording's own mesh is the judge where there is one.
    testing::TestRun by_mesh;
    run_on(walk->frames, walk->mesh, by_mesh);
    CHECK(by_mesh.reported.at("agreement").as_double() > 0.8);
    CHECK(by_mesh.messages.size() == 1);
    CHECK_THROWS_WITH(run_on(opengl(*walk->frames), walk->mesh, by_mesh), Contains("negate the second and third columns"));
}

namespace
{

/// Twelve places of a camera that moves without turning.
std::vector<Camera> on_slider(Vec3d from)
{
    std::vector<Camera> cameras;
    for (int i = 0; i < 12; ++i)
        cameras.push_back(testing::camera(64, 48, 68.6, from + Vec3d{0.05 * i, 0, 0}, 0.2));
    return cameras;
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "frames that overlap too little are neither refused nor warned of")
{
    std::vector<Camera> on_tripod;
    for (int i = 0; i < 5; ++i)
        on_tripod.push_back(testing::camera(64, 48, 68.6, test_room::middle, i * 2 * std::numbers::pi / 5));
    fuse_frames(recorded(folder.path(), on_tripod), Value::Map{{"voxel_m", 0.1}}, run);
    CHECK(run.messages == std::vector<std::string>{"depth pictures overlap too little to tell whether the poses are right"});
}

TEST_CASE_METHOD(testing::StageTest, "noise is not taken for wrong poses, and that of depths that are not fused is not told")
{
    testing::TestRun hall;
    // Most walls are far beyond max_depth_m, the noise is a Kinect's.
    const auto far = recorded(folder.path(), on_slider({10, 3, 10}), {20, 4.5, 20}, [](double depth) { return 0.0028 * depth; });
    fuse_frames(far, Value::Map{{"voxel_m", 0.1}}, hall);
    CHECK(hall.messages.empty());
    CHECK(hall.reported.at("agreement").as_double() > 0.7);
    const auto noisy = recorded(folder.path(), on_slider({1, 1, 0.5}), test_room::size, [](double) { return 0.05; });
    fuse_frames(noisy, Value::Map{{"voxel_m", 0.1}}, run);
    CHECK_THAT(run.messages.at(0), Contains("warning: the frames agree in part"));
}

TEST_CASE("a mesh that the frames contradict may have been edited")
{
    const testing::TemporaryFolder folder;
    const auto frames = recorded(folder.path(), on_slider({1, 1, 0.5}));
    const auto fuse = [&](Vec3f low, Vec3f size, bool check, testing::TestRun& run) {
        fuse_frames(frames, Value::Map{{"check_poses", check}}, run, std::make_shared<Mesh>(testing::box(low, size)));
    };
    testing::TestRun same;
    fuse({0, 0, 0}, vec_cast<float>(test_room::size), true, same);
    CHECK(same.reported.at("agreement").as_double() == Approx(1).margin(0.01));
    testing::TestRun larger;
    CHECK_THROWS_WITH(fuse({-1, -0.5F, -1}, {5, 3, 4.5F}, true, larger),
                      Contains("the frames contradict the mesh on port 'mesh': ") &&
                          Contains("; if the mesh was edited on purpose, set check_poses: false") &&
                          !Contains("the recording contradicts itself"));
    testing::TestRun unchecked;
    fuse({-1, -0.5F, -1}, {5, 3, 4.5F}, false, unchecked);
    CHECK(unchecked.messages.size() == 1);
}

TEST_CASE_METHOD(FuseTest, "what cannot be fused is refused with a way out")
{
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"max_memory_gb", 0.01}}, run),
                      Contains("of 6 frames, the volume needs more than max_memory_gb (0.01)") &&
                          Contains("raise max_memory_gb or voxel_m"));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"max_depth_m", 0.2}}, run), Contains("show no surface"));
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{{"voxel_m", 0.1}, {"min_component_m2", 100}}, run),
                      Contains("at least min_component_m2"));
    const auto empty = std::make_shared<Frames>(*frames);
    for (Frame& frame : empty->frames)
    {
        frame.name += "-empty";
        testing::set_depth_picture(frame, folder.path(), RasterF(frame.depth.intrinsics.width, frame.depth.intrinsics.height));
    }
    testing::TestRun warned;
    CHECK_THROWS_WITH(fuse_frames(empty, Value::Map{}, warned), Contains("show no surface"));
    CHECK_THAT(warned.messages.front(), Contains("warning: the depth pictures are empty"));
    warned.messages.clear();
    fuse_frames(empty, Value::Map{}, warned, std::make_shared<Mesh>(testing::box({0, 0, 0}, {1, 1, 1})));
    CHECK_THAT(warned.messages.front(), Contains("warning: the depth pictures are empty"));
    frames->frames[0].depth_picture = {};
    fuse_frames(frames, Value::Map{{"voxel_m", 0.1}}, run);
    CHECK(run.messages.back() == "warning: 1 of 6 frames have no depth picture and are left out");
    for (Frame& frame : frames->frames)
        frame.depth_picture = {};
    CHECK_THROWS_WITH(fuse_frames(frames, Value::Map{}, run),
                      Contains("has a depth picture: use a scan with depth, or wire a mesh"));
    for (const int checks : {1, 10, 20})
    {
        run.cancel_after(checks);
        CHECK_THROWS_AS(fuse_frames(room_frames(folder.path()), Value::Map{{"voxel_m", 0.1}}, run), Canceled);
    }
}
