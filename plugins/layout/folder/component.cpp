#include "folder_text.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/recordings/parsing.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>
#include <span>
#include <tuple>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

constexpr std::array<const char*, 6> picture_endings{".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"};

class FolderLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        return {.contains = {"images|color|rgb", "poses.txt|poses|pose", "K.txt"}, .before = {"layout.scannet"}};
    }

  private:
    fresco::Option<std::vector<double>> distortion{this, "distortion", std::vector<double>{},
                                                   "k1, k2, p1, p2, k3 as in OpenCV; empty: none"};
    fresco::Choice<PixelCenter> pixel_center = pixel_center_option(this, PixelCenter::half);
    fresco::Option<std::string> axes{this, "axes", "opencv", fresco::one_of({"opencv", "opengl"}),
                                     "Camera axes of the poses: x right, y down, z forward, or x right, y up, z backward"};
    fresco::Option<std::string> direction{
        this, "direction", "world_from_camera", fresco::one_of({"world_from_camera", "camera_from_world"}),
        "Whether a pose takes points from the camera to the world, or from the world to the camera"};

    Recording list(fresco::RunContext& run) override
    {
        camera_ = camera(run);
        Recording recording{.files =
                                "a picture in images, and in each of depth, masks and poses that exists a file of the same name",
                            .meshes = {path() / "mesh.ply"}};
        recording.views = views(run);
        add_poses(recording.views, run);
        return recording;
    }

    CameraMatrix camera(fresco::RunContext& run) const
    {
        if (const auto& k = *distortion;
            !k.empty() && (k.size() != 5 || !std::ranges::all_of(k, [](double n) { return std::isfinite(n); })))
            throw fresco::Error(fmt::format("option \"distortion\": expected 5 finite numbers, found {}", k.size()));
        const auto file = first_file({path() / "K.txt"}, "the camera's matrix", run);
        auto matrix = folder::parse_intrinsics(recorded_text(file, run), file.string());
        if (matrix.values.empty() && !distortion->empty())
            throw fresco::Error(file.string() + ": 360° pictures have no lens to undo; remove option \"distortion\"");
        return matrix;
    }

    bool has_folder(const fs::path& name, fresco::RunContext& run) const
    {
        looks_for(path() / name, run);
        return fs::is_directory(path() / name);
    }

    fs::path picture_folder(fresco::RunContext& run) const
    {
        for (const char* name : {"images", "color", "rgb"})
            if (has_folder(name, run))
                return path() / name;
        throw fresco::MissingInput(path().string() +
                                   ": there is no folder images (or color, rgb); expected the color pictures in it");
    }

    /// The files of a folder with one of these endings, by the rest of their names.
    static std::map<std::string, fs::path> files_in(const fs::path& folder, std::span<const char* const> endings,
                                                    fresco::RunContext& run)
    {
        std::map<std::string, fs::path> files;
        for (const char* ending : endings)
            looks_for(folder / ("*" + std::string(ending)), run);
        for (const auto& entry : fs::directory_iterator(folder))
        {
            const auto& file = entry.path();
            if (std::ranges::find(endings, file.extension()) == endings.end() || is_system_file(file))
                continue;
            if (const auto [other, is_new] = files.try_emplace(file.stem().string(), file); !is_new)
                throw fresco::Error(file.string() + ": a second file of this name, " + other->second.filename().string() +
                                    "; remove one");
        }
        return files;
    }

    /// A view for each name that any of the folders has; a partner that is missing has the path where it is expected.
    std::vector<RecordedView> views(fresco::RunContext& run)
    {
        const auto color_folder = picture_folder(run);
        const auto color = files_in(color_folder, picture_endings, run);
        const std::string ending = color.empty() ? ".png" : color.begin()->second.extension().string();
        std::set<std::string> names;
        for (const auto& [name, file] : color)
            names.insert(name);
        std::vector<std::tuple<fs::path, fs::path RecordedView::*, const char*>> others;
        for (const auto& [folder, place, other_ending] : {std::tuple{"depth", &RecordedView::depth, ".png"},
                                                          {"masks", &RecordedView::mask, ".png"},
                                                          {"poses", &RecordedView::pose, ".txt"},
                                                          {"pose", &RecordedView::pose, ".txt"}})
        {
            if (!has_folder(folder, run))
                continue;
            const std::array endings{other_ending};
            for (const auto& [name, file] : files_in(path() / folder, endings, run))
                names.insert(name);
            others.emplace_back(path() / folder, place, other_ending);
        }
        std::vector<RecordedView> found;
        for (const auto& name : names)
        {
            RecordedView view;
            view.color = color.contains(name) ? color.at(name) : color_folder / (name + ending);
            for (const auto& [folder, place, other_ending] : others)
                view.*place = folder / (name + other_ending);
            name_by_picture(view, view.color.filename());
            found.push_back(std::move(view));
        }
        order_by_name(found);
        return found;
    }

    /// Adds the poses of poses.txt, unless each view has a file of its own.
    void add_poses(std::vector<RecordedView>& views, fresco::RunContext& run)
    {
        if (views.empty() || !views.front().pose.empty())
            return;
        const auto list = path() / "poses.txt";
        if (!fs::is_regular_file(list))
            throw fresco::MissingInput(path().string() +
                                       ": there are no poses; expected poses.txt, or poses/NAME.txt per picture");
        auto poses = folder::parse_poses(recorded_text(list, run), list.string());
        if (poses.size() != views.size())
            throw fresco::Error(
                fmt::format("{}: {} poses for {} pictures; expected one line per picture, in the order of their names",
                            list.string(), poses.size(), views.size()));
        for (std::size_t i = 0; i < views.size(); ++i)
        {
            views[i].source = poses[i].source;
            matrices_.emplace(poses[i].source, std::move(poses[i].matrix));
        }
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        std::vector<double> matrix;
        if (view.pose.empty())
            matrix = matrices_.at(view.source);
        else
        {
            view.source = view.pose.string();
            matrix = folder::parse_pose(fresco::read_text_file(view.pose), view.source);
        }
        if (!tracked_pose(matrix, view.source))
            return false;
        view.world_from_camera = folder::pose_of(
            matrix, {.opengl = *axes == "opengl", .camera_from_world = *direction == "camera_from_world"}, view.source);
        view.is_panorama = camera_.values.empty();
        if (sized_camera_.width == 0)
        {
            const auto size = codec().header(view.color);
            sized_camera_ = view.is_panorama ? fresco::Intrinsics{.width = size.width, .height = size.height}
                                             : intrinsics_for(camera_, *pixel_center, size, view.color);
        }
        view.camera = sized_camera_;
        if (const auto& k = *distortion; !k.empty())
            view.lens = {.k1 = k[0], .k2 = k[1], .k3 = k[4], .p1 = k[2], .p2 = k[3]};
        return true;
    }

    CameraMatrix camera_;
    fresco::Intrinsics sized_camera_;
    std::map<std::string, std::vector<double>> matrices_;  ///< By their lines in poses.txt.
};

}  // namespace

FRESCO_COMPONENT("layout.folder", FolderLayout, fresco::recordings::Layout,
                 "Pictures, depth and poses in plain folders and text files, in conventions that you declare")
