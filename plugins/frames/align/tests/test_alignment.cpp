#include "alignment.h"
#include "catch.h"
#include "painted_corner.h"

#include <fresco/testing.h>

#include <set>

using namespace painted_corner;
using namespace fresco::align;

namespace
{

constexpr AlignmentRules usual{.rounds_count = 40, .likely_turn = 0.02, .likely_shift_m = 0.02};
const std::vector<Camera> true_cameras = cameras();
const std::vector<SurfacePoint> fine = surface_points(mesh_of(0.04), 10000);
const std::vector<SurfacePoint> coarse = surface_points(mesh_of(0.06), 10000);

/// Points are seen from where the recorder says that the cameras are; pictures are taken from where they are.
std::vector<AlignedView> views_of(const std::vector<Camera>& recorded, const std::vector<SurfacePoint>& points,
                                  const std::vector<double>& gains = {1, 1, 1, 1, 1, 1, 1})
{
    std::vector<AlignedView> views;
    for (std::size_t i = 0; i < true_cameras.size(); ++i)
        views.push_back({true_cameras[i].intrinsics, sightings(points, recorded[i], depth_of(recorded[i])),
                         brightness_levels(picture_of(true_cameras[i], gains[i]))});
    return views;
}

align::Alignment aligned(const std::vector<AlignedView>& views, std::size_t count = coarse.size(),
                         const AlignmentRules& rules = usual)
{
    testing::TestRun run;
    return align::align(views, count, rules, run);
}

Camera corrected(const Camera& recorded, const RigidTransform& motion)
{
    return {recorded.intrinsics, recorded.world_from_camera * motion.inverse()};
}

/// How far the cameras' places relative to each other are from the true ones, in pixels: the mean over the cameras, against each
/// one in turn. All of them may move together.
double relatively_apart_px(const std::vector<Camera>& now)
{
    double sum = 0;
    for (std::size_t i = 0; i < true_cameras.size(); ++i)
        for (std::size_t j = 0; j < true_cameras.size(); ++j)
        {
            const RigidTransform moved = now[j].world_from_camera * true_cameras[j].world_from_camera.inverse();
            sum += apart_px(true_cameras[i], {now[i].intrinsics, moved.inverse() * now[i].world_from_camera});
        }
    return sum / static_cast<double>(true_cameras.size() * (true_cameras.size() - 1));
}

std::vector<Camera> corrected(const std::vector<Camera>& recorded, const align::Alignment& found)
{
    std::vector<Camera> result;
    for (std::size_t i = 0; i < recorded.size(); ++i)
        result.push_back(corrected(recorded[i], found.corrected_from_recorded[i]));
    return result;
}

const std::vector<double> exposures{1, 1.2, 0.8, 0.9, 1.1, 1.3, 0.7};
}  // namespace

TEST_CASE("many small mistakes are corrected, whatever the exposures")
{
    std::vector<Camera> recorded;
    for (std::size_t i = 0; i < true_cameras.size(); ++i)
    {
        const double sign = i % 2 == 0 ? 1 : -1;
        const auto part = static_cast<double>(i);
        recorded.push_back(mistaken(true_cameras[i], sign * 0.004 * (part - 3), {0.003 * sign * part, 0.002 * (part - 3), 0}));
    }
    const auto found = aligned(views_of(recorded, fine, exposures), fine.size());
    CHECK(relatively_apart_px(recorded) > 2.5);
    CHECK(relatively_apart_px(corrected(recorded, found)) < 0.4);
    for (std::size_t i = 0; i < true_cameras.size(); ++i)
        CHECK(found.moved_px[i] ==
              Approx(apart_px(recorded[i], corrected(recorded[i], found.corrected_from_recorded[i]))).epsilon(0.15));
    CHECK(found.error_after < 0.4 * found.error_before);
}

TEST_CASE("right cameras stay, and one that shares nothing with others")
{
    auto views = views_of(true_cameras, coarse);
    views.push_back({true_cameras[0].intrinsics, {}, brightness_levels(picture_of(true_cameras[0]))});
    const auto found = aligned(views);
    for (std::size_t i = 0; i < true_cameras.size(); ++i)
        CHECK(found.moved_px[i] < 0.3);
    CHECK(found.corrected_from_recorded[7] == RigidTransform{});
    CHECK(found.moved_px[7] == 0);
    CHECK(aligned({}, 0).moved_px.empty());
    // Exposures are no error.
    CHECK(aligned(views_of(true_cameras, coarse, exposures)).error_before < 0.005);
}

TEST_CASE("detail in only one picture hardly moves its camera")
{
    auto views = views_of(true_cameras, coarse);
    // Somebody stands before a quarter of the wall, and is brighter toward one side.
    for (auto& level : views[2].levels)
        for (int y = level.height / 4; y < 3 * level.height / 4; ++y)
            for (int x = level.width / 4; x < 3 * level.width / 4; ++x)
                level.at(x, y) += 4 * (static_cast<float>(x) / static_cast<float>(level.width) - 0.25F);
    CHECK(aligned(views).moved_px[2] < 2);  // 5, did every difference count alike.
}

TEST_CASE("the prior holds cameras where pictures say nothing")
{
    auto recorded = true_cameras;
    recorded[1] = mistaken(true_cameras[1], 0.02, {});
    const auto views = views_of(recorded, coarse);
    // It does not give way in the end.
    const AlignmentRules stiff{.rounds_count = 100, .likely_turn = 1e-3, .likely_shift_m = 1e-3};
    CHECK(aligned(views, coarse.size(), stiff).moved_px[1] < 0.1);
    CHECK(aligned(views).moved_px[1] > 3);
    auto blank = views;
    for (auto& view : blank)
        for (auto& level : view.levels)
            std::fill(level.values.begin(), level.values.end(), -1.0F);
    CHECK(aligned(blank).moved_px[1] == 0);
}

TEST_CASE("points add up to the same whichever are added together")
{
    REQUIRE(fine.size() > 2000);
    auto views = views_of(true_cameras, fine);
    const auto expected = aligned(views, fine.size());
    // Points that no view sees, before all others: no multiple of what is added together, but of the distances of points
    // compared.
    constexpr std::uint32_t more = 840;
    for (AlignedView& view : views)
        for (Sighting& sighting : view.sightings)
            sighting.point += more;
    const auto found = aligned(views, fine.size() + more);
    CHECK(found.error_before == expected.error_before);
    CHECK(found.error_after == expected.error_after);
    CHECK(found.corrected_from_recorded == expected.corrected_from_recorded);
}

TEST_CASE("a view sees the points that face it in the open")
{
    // f = 40 px, the plane z = 2 m fills the picture, but for a box 1 m away in columns 20 to 29.
    const Camera camera{{40, 30, 40, 40, 20, 15}, {}};
    RasterF depth(40, 30, 1, 2.0F);
    for (int y = 0; y < 30; ++y)
        for (int x = 20; x < 30; ++x)
            depth.at(x, y) = 1;
    const auto at = [](double column, double row, float z) {
        return Vec3f{static_cast<float>((column - 20) / 40) * z, static_cast<float>((row - 15) / 40) * z, z};
    };
    const Vec3f to_camera{0, 0, -1};
    const std::vector<SurfacePoint> beside_box{
        {at(10.5, 10.5, 2), to_camera},     // seen
        {at(10.5, 10.5, 2.1F), to_camera},  // not on the surface, but near it: 10 cm are more than 3 % + 2 cm
        {at(10.5, 10.5, 2.05F), to_camera}, {at(24.5, 10.5, 2), to_camera},  // behind the box
        {at(24.5, 10.5, 1), to_camera},     {at(18.5, 10.5, 2), to_camera},  // beside the box: two pixels
        {at(17.5, 10.5, 2), to_camera},     {at(1.5, 10.5, 2), to_camera},   // at the picture's border
        {at(-5, 10.5, 2), to_camera},       {at(10.5, 10.5, 2), {0, 0, 1}},  // from behind
        {at(10.5, 10.5, -2), to_camera},    {at(20, 15, 1), {0.99F, 0, -0.1F}},
    };
    std::set<std::uint32_t> seen;
    for (const auto& sighting : sightings(beside_box, camera, depth))
        seen.insert(sighting.point);
    CHECK(seen == std::set<std::uint32_t>{0, 2, 4, 6});
    const auto first = sightings(beside_box, camera, depth).front();
    CHECK(first.in_camera == beside_box[0].position);
    CHECK(first.weight == Approx(2 / length(vec_cast<double>(beside_box[0].position))));
}
