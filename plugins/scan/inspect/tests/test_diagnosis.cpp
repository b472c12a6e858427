#include "catch.h"
#include "mistakes.h"
#include "recordings.h"

#include <fresco/inspection/diagnosis.h>
#include <fresco/inspection/wording.h>

#include <optional>

using namespace fresco;
using namespace fresco::inspect;
using namespace mistakes;

namespace
{

/// The recording as it is, `count` frames of it.
Looked look_at(const recordings::Recording& recording, std::size_t count)
{
    Looked right{*recording.mesh, {}, recording.mesh.get()};
    const auto& frames = recording.frames->frames;
    count = std::min(count, frames.size());
    for (std::size_t i = 0; i < count; ++i)
        right.views.push_back(
            view_of(*recording.frames, {(2 * i + 1) * frames.size() / (2 * count)}, recording.depth, recording.images.get()));
    return right;
}

std::vector<std::string> causes_of(const Diagnosis& found)
{
    std::vector<std::string> causes;
    for (const Finding& finding : found.findings)
        causes.push_back(finding.cause);
    return causes;
}

std::string told(const Diagnosis& found)
{
    std::string text = summary(found, true) + "; explained " + number(found.explained.agreement) + ", edges " +
                       number(found.recorded.edge_response) + " -> " + number(found.explained.edge_response);
    for (const Finding& finding : found.findings)
        text += "\n    " + finding.cause + ": " + finding.text;
    return text;
}

Diagnosis diagnose_after(Looked looked, const Change& change)
{
    change(looked);
    std::optional<raycast::Scene> scene;
    if (!looked.mesh.triangles.empty())
        scene.emplace(looked.mesh);
    return diagnose(scene ? &*scene : nullptr, looked.views, testing::TestRun(2));
}

/// Share of the cases that are found by their causes, and nothing else; without a mesh, mistakes by a cause of the family.
double share_named(const Looked& right, const std::vector<Case>& cases)
{
    double named = 0;
    for (const Case& made : cases)
    {
        const Diagnosis found = diagnose_after(right, made.change);
        const auto causes = causes_of(found);
        const auto is_related = [&](const std::string& cause) { return family(cause) == family(made.causes.front()); };
        const bool is_named = right.mesh.triangles.empty() && !made.causes.empty() ? std::ranges::any_of(causes, is_related)
                                                                                   : causes == made.causes;
        named += is_named;
        if (!is_named)
            UNSCOPED_INFO(made.name << ": " << told(found));
    }
    return named / static_cast<double>(cases.size());
}

}  // namespace

TEST_CASE("mistakes made on purpose in a generated room are named", "[scan.inspect]")
{
    if (recordings::room() == nullptr)
        return;
    const Looked room = look_at(*recordings::room(), 12);
    CHECK(share_named(room, named()) >= 0.95);
    CHECK(share_named(room, named_by_edges()) == 1);
    CHECK(share_named(room, of_color()) == 1);
    CHECK(share_named(room, right()) == 1);
}

TEST_CASE("other mistakes are not passed over, and no name is guessed", "[scan.inspect]")
{
    if (recordings::room() == nullptr)
        return;
    const Looked room = look_at(*recordings::room(), 12);
    for (const Change& change : {on_poses(
                                     [](RigidTransform& pose) {
                                         pose.translation += Vec3d{0.9, 2.4, -0.9};
                                     }),
                                 on_poses([](RigidTransform& pose) { pose.translation = pose.translation * -1; }),
                                 on_views([](View& view) { view.depth.depth.cy += 0.12 * view.depth.depth.height; }),
                                 on_views([](View& view) { view.depth.depth.fy *= 1.35; })})
    {
        const Diagnosis found = diagnose_after(room, change);
        INFO(told(found));
        CHECK(found.assumption == Assumption{});
        CHECK_FALSE(found.findings.empty());
        // Agreement in part ends no run.
        for (const Finding& finding : found.findings)
            CHECK(finding.certain == (finding.cause == "unexplained"));
    }
}

TEST_CASE("an object in a hall gives no alarm, and its mistakes are named", "[scan.inspect]")
{
    if (recordings::hall() == nullptr)
        return;
    const auto object = crop({0.3F, 0.3F, 0.02F}, {0.7F, 0.7F, 0.4F}), near = crop({0, 0, 0}, {0.4F, 0.4F, 0.6F});
    const auto one_camera = one_camera_recording(), alone = both(one_camera, object);
    CHECK(share_named(look_at(*recordings::hall(), 12), {{"an object", object},
                                                         {"an object, one camera", alone},
                                                         {"the near part", near},
                                                         {"the near part, one camera", both(one_camera, near)}}) == 1);
}

namespace
{

void check_without_mesh(const recordings::Recording* recording, const std::vector<Case>& cases, double least = 0.9)
{
    if (recording == nullptr)
        return;
    Looked right;
    for (const Chosen& chosen : chosen_frames(*recording->frames, 12, false, recording->depth))
        right.views.push_back(view_of(*recording->frames, chosen, recording->depth, recording->images.get()));
    CHECK(share_named(right, cases) >= least);
    CHECK(share_named(right, right_frames()) == 1);
}

}  // namespace

TEST_CASE("without a mesh, mistakes are named by how frames agree with each other", "[scan.inspect]")
{
    // Shifts in time show only where the motion changes.
    check_without_mesh(recordings::walk(), named_without_mesh(), 0.8);
}

TEST_CASE("without a mesh, depths that no room has tell whose unit is wrong, and empty ones are named", "[scan.inspect]")
{
    const auto* walk = recordings::walk();
    if (walk == nullptr)
        return;
    Looked right;
    for (const Chosen& chosen : chosen_frames(*walk->frames, 12, false, walk->depth))
        right.views.push_back(view_of(*walk->frames, chosen, walk->depth, nullptr, false));
    const auto first_after = [&](const Change& change)
    {
        const Diagnosis found = diagnose_after(right, change);
        INFO(told(found));
        REQUIRE_FALSE(found.findings.empty());
        CHECK(found.findings.front().certain);
        return found.findings.front().cause + ": " + found.findings.front().text + "; " + summary(found, false);
    };
    CHECK_THAT(first_after(scaled_depths(5)),
               Catch::StartsWith("depth_unit: ") && Catch::Contains("depth_unit_m by 0.2 (0.0002"));
    CHECK_THAT(first_after(scaled_poses(4)), Catch::StartsWith("pose_unit: ") && Catch::Contains("the positions by 0.25 ("));
    Frames empty = *walk->frames;
    right.views = {view_of(
        empty, {0}, [](const Frame& frame) { return RasterF(frame.depth.intrinsics.width, 8); }, nullptr, false)};
    CHECK_THAT(first_after([](Looked&) {}), Catch::StartsWith("empty_depth: the depth pictures are empty") &&
                                                Catch::Contains("nothing to compare: the frames have empty depth pictures"));
}

TEST_CASE("mistakes made on purpose in real recordings are named, and right ones give no alarm", "[.real]")
{
    check_without_mesh(recordings::hololens(), named_without_mesh());
    check_without_mesh(recordings::teddy(), named_without_mesh());
    if (recordings::kitchen() == nullptr)
        return;
    const Looked kitchen = look_at(*recordings::kitchen(), 12);
    CHECK(share_named(kitchen, named()) >= 0.95);
    CHECK(share_named(kitchen, named_by_edges()) >= 0.8);
    CHECK(share_named(kitchen, of_color()) == 1);
    CHECK(share_named(kitchen, right()) == 1);
}

TEST_CASE("the mesh of another room fails", "[scan.inspect]")
{
    if (recordings::room() == nullptr || recordings::hall() == nullptr)
        return;
    const auto& room = *recordings::room();
    const auto& hall = *recordings::hall();
    for (const auto& [frames, mesh] : {std::pair{&room, hall.mesh.get()}, {&hall, room.mesh.get()}})
    {
        const Looked other = look_at(*frames, 8);
        Mesh apart = *mesh;  // Worlds have nothing in common, not even the floor.
        for (Vec3f& p : apart.positions)
            p += {1.3F, 0.9F, -0.45F};
        const raycast::Scene scene(apart);
        const Diagnosis found = diagnose(&scene, other.views, testing::TestRun(2));
        INFO(told(found));
        CHECK(std::ranges::any_of(found.findings, &Finding::certain));
    }
}
