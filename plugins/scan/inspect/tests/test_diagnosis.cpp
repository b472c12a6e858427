#include "catch.h"
#include "mistakes.h"
#include "recordings.h"

#include <fresco/inspection/diagnosis.h>
#include <fresco/inspection/wording.h>

#include <cstdlib>
#include <iostream>
#include <optional>

using namespace fresco;
using namespace fresco::inspect;
using namespace mistakes;

namespace
{

/// A hand's motion: positions and directions change by this from frame to frame.
constexpr double hand_m = 0.05;
constexpr double hand_rad = 0.04;

/// Poses around a generated frame, whose own neighbors are too far apart to lie on one motion.
void move_by_hand(PoseTrack& track, Random& random)
{
    const RigidTransform own = track.poses[track.own];
    const Vec3d shift = Vec3d{random.normal(), random.normal(), random.normal()} * hand_m;
    const double turn = hand_rad * random.normal();
    track.poses.clear();
    for (int i = -5; i <= 5; ++i)
    {
        RigidTransform step;
        step.rotation.m = {std::cos(i * turn), 0, std::sin(i * turn), 0, 1, 0, -std::sin(i * turn), 0, std::cos(i * turn)};
        step.translation = shift * static_cast<double>(i);
        track.poses.push_back(own * step);
    }
    track.own = 5;
}

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

Looked look_at_generated(const recordings::Recording& recording)
{
    Looked right = look_at(recording, 12);
    Random random(1);
    for (View& view : right.views)
        move_by_hand(view.depth.track, random);
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

/// The scene is rebuilt only for a changed mesh.
Diagnosis diagnose_after(const Looked& right, const raycast::Scene* scene, const Change& change)
{
    Looked looked = right;
    change(looked);
    const bool same = looked.mesh.positions == right.mesh.positions && looked.mesh.triangles == right.mesh.triangles &&
                      looked.mesh.colors == right.mesh.colors;
    if (same)
        return diagnose(scene, looked.views, testing::TestRun(2));
    const raycast::Scene changed(looked.mesh);
    return diagnose(&changed, looked.views, testing::TestRun(2));
}

/// Passes on whether a diagnosis is right; shows those that are not, or all where TABLE is set.
bool shown(bool is_right, const std::string& name, const Diagnosis& found)
{
    if (std::getenv("TABLE") || !is_right)
        std::cout << (is_right ? "right " : "WRONG ") << name << ": " << told(found) << std::endl;
    return is_right;
}

/// A third of the cases: ctest has no time for all of them.
std::vector<Case> sample(const std::vector<Case>& cases)
{
    std::vector<Case> some;
    for (std::size_t i = 0; i < cases.size(); i += 3)
        some.push_back(cases[i]);
    return some;
}

/// The share of mistakes whose causes `is_named` accepts.
template <class Named>
double share_named(const Looked& right, const raycast::Scene* scene, const std::vector<Case>& cases, const std::string& where,
                   const Named& is_named)
{
    const auto found =
        std::ranges::count_if(cases,
                              [&](const Case& made)
                              {
                                  const Diagnosis diagnosis = diagnose_after(right, scene, made.change);
                                  return shown(is_named(made, causes_of(diagnosis)), where + ": " + made.name, diagnosis);
                              });
    return static_cast<double>(found) / static_cast<double>(cases.size());
}

/// Share of the cases that are found by their name, and nothing else.
double share_named(
    Looked right, const std::vector<Case>& cases, const std::string& where, const Change& part = [](Looked&) {})
{
    part(right);
    const raycast::Scene scene(right.mesh);
    return share_named(right, &scene, cases, where,
                       [](const Case& made, const std::vector<std::string>& causes) { return causes == made.causes; });
}

std::ptrdiff_t false_alarms(const Looked& right_one, const std::vector<std::pair<std::string, Change>>& changes)
{
    std::optional<raycast::Scene> scene;
    if (!right_one.mesh.triangles.empty())
        scene.emplace(right_one.mesh);
    return std::ranges::count_if(changes,
                                 [&](const auto& one)
                                 {
                                     const auto& [name, change] = one;
                                     const Diagnosis found = diagnose_after(right_one, scene ? &*scene : nullptr, change);
                                     return !shown(found.findings.empty(), name, found);
                                 });
}

}  // namespace

TEST_CASE("mistakes made on purpose in a generated room are named", "[scan.inspect]")
{
    if (recordings::room() == nullptr)
        return;
    const Looked room = look_at_generated(*recordings::room());
    CHECK(share_named(room, sample(named()), "whole") >= 0.95);
    CHECK(share_named(room, sample(named()), "part", crop({0, 0, 0}, {0.5F, 1, 1})) >= 0.95);
    CHECK(share_named(room, named_by_edges(), "whole") == 1);
}

TEST_CASE("other mistakes are not passed over, and no name is guessed", "[scan.inspect]")
{
    if (recordings::room() == nullptr)
        return;
    const Looked room = look_at_generated(*recordings::room());
    const raycast::Scene scene(room.mesh);
    const auto on_depth_camera = [](const auto& change) { return on_views([change](View& view) { change(view.depth.depth); }); };
    const std::vector<std::pair<std::string, Change>> others{
        {"another room", on_poses(
                             [](RigidTransform& pose) {
                                 pose.translation += {0.9, 2.4, -0.9};
                             })},
        {"positions negated", on_poses([](RigidTransform& pose) { pose.translation = pose.translation * -1; })},
        {"a principal point too low", on_depth_camera([](Intrinsics& k) { k.cy += 0.12 * k.height; })},
        {"a focal length too long in one direction", on_depth_camera([](Intrinsics& k) { k.fy *= 1.35; })}};
    for (const auto& [name, change] : others)
    {
        const Diagnosis found = diagnose_after(room, &scene, change);
        INFO(name << ": " << told(found));
        CHECK(found.assumption == Assumption{});
        CHECK_FALSE(found.findings.empty());
        // Agreement in part ends no run.
        for (const Finding& finding : found.findings)
            CHECK(finding.certain == (finding.cause == "unexplained"));
    }
}

TEST_CASE("a generated room that is right gives no alarm", "[scan.inspect]")
{
    if (recordings::room() == nullptr)
        return;
    CHECK(false_alarms(look_at_generated(*recordings::room()), right()) == 0);
}

TEST_CASE("an object in a hall gives no alarm, and its mistakes are named", "[scan.inspect]")
{
    if (recordings::hall() == nullptr)
        return;
    Looked hall = look_at_generated(*recordings::hall());
    const auto object = crop({0.3F, 0.3F, 0.02F}, {0.7F, 0.7F, 0.4F});
    const auto one_camera = one_camera_recording();
    CHECK(false_alarms(hall, {{"an object in a hall", object},
                              {"an object in a hall, one camera", both(one_camera, object)},
                              {"the near part of a hall", crop({0, 0, 0}, {0.4F, 0.4F, 0.6F})},
                              {"the near part of a hall, one camera", both(one_camera, crop({0, 0, 0}, {0.4F, 0.4F, 0.6F}))}}) ==
          0);
    one_camera(hall);
    object(hall);
    late_poses(2.4)(hall);
    const raycast::Scene scene(hall.mesh);
    const Diagnosis late = diagnose(&scene, hall.views, testing::TestRun(2));
    INFO(told(late));
    CHECK(causes_of(late) == std::vector<std::string>{"pose_lag"});
}

namespace
{

/// Frames among themselves.
Looked look_without_mesh(const recordings::Recording& recording)
{
    Looked right;
    for (const Chosen& chosen : chosen_frames(*recording.frames, 12, false, recording.depth))
        right.views.push_back(view_of(*recording.frames, chosen, recording.depth, recording.images.get()));
    return right;
}

/// Right subsets of a recording.
std::vector<std::pair<std::string, Change>> right_subsets()
{
    std::vector<std::pair<std::string, Change>> all;
    for (const auto& [name, change] : right())
        for (const char* subset : {"as recorded", "1 % of noise", "one frame", "two frames", "depth to 2 m", "little depth",
                                   "depth on the left only", "no pictures", "focal lengths off by 1.5 %"})
            if (name == subset)
                all.emplace_back(name, change);
    return all;
}

void check_without_mesh(const recordings::Recording* recording, const std::vector<Case>& cases, const std::string& where,
                        double least = 0.9)
{
    if (recording == nullptr)
        return;
    const Looked right = look_without_mesh(*recording);
    const auto is_named = [](const Case& made, const std::vector<std::string>& causes) {
        return std::ranges::any_of(causes,
                                   [&](const std::string& cause) { return family(cause) == family(made.causes.front()); });
    };
    CHECK(share_named(right, nullptr, cases, where, is_named) >= least);
    CHECK(false_alarms(right, right_subsets()) == 0);
}

}  // namespace

TEST_CASE("without a mesh, mistakes are named by how frames agree with each other", "[scan.inspect]")
{
    // Shifts in time show only where the motion changes: two of eleven.
    check_without_mesh(recordings::walk(), sample(named_without_mesh()), "a walk through a generated room", 0.8);
}

TEST_CASE("mistakes made on purpose in real recordings are named, and right ones give no alarm", "[.real]")
{
    check_without_mesh(recordings::hololens(), named_without_mesh(), "HoloLens");
    check_without_mesh(recordings::teddy(), named_without_mesh(), "TUM");
    if (recordings::kitchen() == nullptr)
        return;
    const Looked kitchen = look_at(*recordings::kitchen(), 12);
    CHECK(share_named(kitchen, named(), "whole") >= 0.95);
    CHECK(share_named(kitchen, named_by_edges(), "whole") >= 0.8);
    CHECK(false_alarms(kitchen, right()) == 0);
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
