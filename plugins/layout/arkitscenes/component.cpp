#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/confidence.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;
using fresco::RigidTransform;

/// The data set's own programs take the pose and the camera of a picture from lines and files up to so far away.
constexpr double max_gap_s = 0.005;

/// The rotation about `axis` by its length, in radians (Rodrigues).
fresco::Mat3 rotation_about(fresco::Vec3d axis)
{
    const double angle = length(axis);
    if (angle == 0)
        return {};
    const auto k = axis * (1 / angle);
    const double s = std::sin(angle), c = 1 - std::cos(angle);
    return {{1 - c * (k.y * k.y + k.z * k.z), c * k.x * k.y - s * k.z, c * k.x * k.z + s * k.y,  //
             c * k.x * k.y + s * k.z, 1 - c * (k.x * k.x + k.z * k.z), c * k.y * k.z - s * k.x,  //
             c * k.x * k.z - s * k.y, c * k.y * k.z + s * k.x, 1 - c * (k.x * k.x + k.y * k.y)}};
}

struct TimedPose
{
    RigidTransform world_from_camera;
    std::string source;
};

/// Reads lowres_wide.traj: a time, and camera_from_world as axis times angle and translation, with OpenCV's camera axes.
std::map<double, TimedPose> parse_trajectory(std::string_view text, std::string_view source)
{
    std::map<double, TimedPose> poses;
    // A line without an end may be cut within a number.
    LineReader lines(text.substr(0, text.rfind('\n') + 1), source);
    while (const auto line = lines.next_record())
    {
        const auto v = parse_numbers(*line, 7, lines.place());
        if (!std::ranges::all_of(v, [](double number) { return std::isfinite(number); }))
            continue;  // ARKit had lost track.
        const RigidTransform camera_from_world{rotation_about({v[1], v[2], v[3]}), {v[4], v[5], v[6]}};
        poses[v[0]] = {camera_from_world.inverse(), lines.place()};
    }
    return poses;
}

/// The entry nearest to a time, unless it is too far away.
template <class T>
const T* nearest(const std::map<double, T>& entries, double time)
{
    const T* found = nullptr;
    double least = max_gap_s;
    for (auto it = entries.lower_bound(time - max_gap_s); it != entries.end() && it->first <= time + max_gap_s; ++it)
        if (const double gap = std::abs(it->first - time); gap <= least)
        {
            least = gap;
            found = &it->second;
        }
    return found;
}

class ArkitScenesLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        return {.contains = {"lowres_wide", "lowres_depth", "lowres_wide_intrinsics", "lowres_wide.traj"}};
    }

  private:
    fresco::Option<int> min_confidence = min_confidence_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto trajectory = path() / "lowres_wide.traj";
        const auto poses = parse_trajectory(recorded_text(trajectory, run), trajectory.string());
        const auto cameras = files_by_time("lowres_wide_intrinsics", ".pincam", run);
        looks_for(path() / "confidence/*.png", run);
        Recording recording{.files = "lowres_wide/ID_TIME.png, lowres_depth/ID_TIME.png, lowres_wide_intrinsics/ID_TIME.pincam "
                                     "and a line of lowres_wide.traj",
                            .meshes = {path() / "*_3dod_mesh.ply"}};
        std::size_t without_pose = 0, without_depth = 0;
        looks_for(path() / "lowres_depth/*.png", run);
        for (const auto& [time, picture] : files_by_time("lowres_wide", ".png", run))
        {
            const auto depth = path() / "lowres_depth" / picture.filename();
            const auto* pose = nearest(poses, time);
            const auto* camera = nearest(cameras, time);
            without_pose += pose ? 0 : 1;
            without_depth += pose && !fs::exists(depth) ? 1 : 0;
            if (!pose || !fs::exists(depth))
                continue;
            RecordedView view;
            name_by_picture(view, picture.lexically_relative(path()));
            view.color = picture;
            view.depth = depth;
            view.pose = camera ? *camera : path() / "lowres_wide_intrinsics" / picture.filename().replace_extension(".pincam");
            view.world_from_camera = pose->world_from_camera;
            view.source = pose->source;
            if (fs::exists(confidence_of(view)))
                run.reads_file(confidence_of(view));
            recording.views.push_back(std::move(view));
        }
        for (std::size_t i = 0; i < recording.views.size(); ++i)
            recording.views[i].number = static_cast<long>(i);
        run.report("without_pose", without_pose);
        run.report("without_depth", without_depth);
        if (without_pose + without_depth > 0)
            recording.note =
                fmt::format("; left out {} without a pose at their time and {} without depth", without_pose, without_depth);
        return recording;
    }

    /// The files ID_TIME of a folder.
    std::map<double, fs::path> files_by_time(const char* folder, const char* ending, fresco::RunContext& run) const
    {
        looks_for(path() / folder / (std::string("*") + ending), run);
        std::map<double, fs::path> files;
        std::error_code missing;
        for (const auto& entry : fs::directory_iterator(path() / folder, missing))
        {
            const auto stem = entry.path().stem().string();
            if (entry.path().extension() != ending || is_system_file(entry.path()))
                continue;
            const double time =
                number_of(stem.substr(stem.rfind('_') + 1), entry.path().string() + ": the time in the file's name");
            if (const auto [other, is_new] = files.try_emplace(time, entry.path()); !is_new)
                throw fresco::Error(
                    fmt::format("{}: a second file of this time, {}: the folder has several videos; separate them",
                                entry.path().string(), other->second.filename().string()));
        }
        return files;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const std::string text = fresco::read_text_file(view.pose), place = view.pose.string();
        const auto words = words_of(text, " \t\r\n");
        if (words.size() != 6)
            throw fresco::Error(fmt::format("{}: {} numbers; expected width, height, fx, fy, cx, cy", place, words.size()));
        const auto size = [&](std::size_t i) { return static_cast<int>(integer_of(words[i], 1, 65536, place)); };
        const auto number = [&](std::size_t i) { return number_of(words[i], place); };
        view.camera = {size(0), size(1), number(2), number(3), number(4), number(5)};
        view.source = place;
        return true;
    }

    bool unpack(RecordedView& view, const fs::path& folder) const override
    {
        return write_sure_depth(view, confidence_of(view), *min_confidence, codec(), folder);
    }

    fs::path confidence_of(const RecordedView& view) const { return path() / "confidence" / view.color.filename(); }
};

}  // namespace

FRESCO_COMPONENT("layout.arkitscenes", ArkitScenesLayout, fresco::recordings::Layout,
                 "ARKitScenes' low-resolution pictures and depth")
