#include "house.h"
#include "house_cameras.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>

namespace
{

namespace fs = std::filesystem;

/// 4 000 steps a meter.
constexpr double depth_unit_m = 0.00025;

class ScanMatterport3d final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the house, with undistorted_camera_parameters and the pictures in it"};
    fresco::Option<int> region{this, "region", -1, fresco::range(-1, 100'000),
                               "Take this room alone: its mesh, and the pictures taken in it; -1: the whole house"};
    fresco::Option<fresco::InputFile> mesh_file{this, "mesh", fresco::InputFile{},
                                                "Mesh in the poses' world; empty: the region's, or the house's"};
    fresco::Option<std::string> image_origin{
        this, "image_origin", "bottom_left", fresco::one_of({"bottom_left", "top_left"}),
        "Where the intrinsics count rows from: the data set says bottom_left; programs that wrote the file anew may not"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th picture"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The undistorted pictures with their depth"};
    fresco::Output<fresco::Mesh> mesh{this, "mesh", "The surface of the region or the house"};

    void run(fresco::RunContext& run) override
    {
        const auto& folder = path->path;
        const auto camera_file = matterport3d::camera_file(folder);
        run.reads_folder(camera_file.parent_path(), "*.conf");
        run.reads_file(camera_file);
        const std::string house = camera_file.stem().string();
        const auto cameras = matterport3d::parse_cameras(fresco::read_text_file(camera_file), camera_file.string());
        auto views = listed_views(cameras, house, run);
        fresco::recordings::keep_every(views, *every);
        mesh = fresco::read_mesh(surface(house, run));
        frames = fresco::recordings::registered_frames(views, *images, frames.folder().path, run);
        for (const auto& view : views)
        {
            run.reads_file(view.color);
            run.reads_file(view.depth);
        }
        run.report("house", house);
        run.report("frames", views.size());
        run.report("house_frames", cameras.views.size());
        run.message(house + ": " + std::to_string(views.size()) + " of " + std::to_string(cameras.views.size()) + " pictures");
    }

    std::vector<fresco::recordings::RegisteredView> listed_views(const matterport3d::HouseCameras& cameras,
                                                                 const std::string& house, fresco::RunContext& run) const
    {
        std::map<std::string, int> regions;
        const auto house_file = path->path / "house_segmentations" / (house + ".house");
        if (*region >= 0)
        {
            run.reads_file(house_file);
            regions = matterport3d::parse_regions(fresco::read_text_file(house_file), house_file.string());
        }
        std::vector<fresco::recordings::RegisteredView> views;
        fresco::ImageHeader size;
        for (std::size_t i = 0; i < cameras.views.size(); ++i)
        {
            const auto& listed = cameras.views[i];
            if (*region >= 0)
            {
                const auto at = regions.find(listed.panorama);
                if (at == regions.end())
                    throw fresco::Error(house_file.string() + ": panorama " + listed.panorama + " of " + listed.source +
                                        " is not there; expected the files of one house");
                if (at->second != *region)
                    continue;
            }
            fresco::recordings::RegisteredView view;
            fresco::recordings::name_by_picture(view, fs::path(house) / listed.color);
            view.number = static_cast<long>(i);
            view.color = path->path / cameras.color_folder / listed.color;
            view.depth = path->path / cameras.depth_folder / listed.depth;
            if (views.empty())
                size = images->header(view.color);
            view.camera = matterport3d::camera_of(listed, size.width, size.height,
                                                  *image_origin == "top_left" ? matterport3d::ImageOrigin::top_left
                                                                              : matterport3d::ImageOrigin::bottom_left);
            view.world_from_camera = listed.world_from_camera;
            view.depth_unit_m = depth_unit_m;
            view.source = listed.source;
            views.push_back(std::move(view));
        }
        if (views.empty())
            throw fresco::Error(house_file.string() + ": no picture was taken in region " + std::to_string(*region) +
                                "; choose one that a line P of that file names");
        return views;
    }

    fs::path surface(const std::string& house, fresco::RunContext& run) const
    {
        if (!mesh_file->empty())
            return mesh_file->path;
        std::string names;
        for (const auto& candidate : matterport3d::mesh_candidates(path->path, house, *region))
        {
            const auto parent = candidate.parent_path();
            if (fs::is_directory(parent))
                run.reads_folder(parent, candidate.filename().string());
            else
                run.reads_folder(path->path, parent.filename().string());
            if (fs::is_regular_file(candidate))
            {
                run.reads_file(candidate);
                return candidate;
            }
            names += (names.empty() ? "" : " or ") + candidate.string();
        }
        throw fresco::MissingInput("the mesh is missing; expected " + names + ", or option mesh");
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.01, .per_face = 5e-7},
                .parallel_share = 0.5,
                .memory_mb = {.fixed = 20, .per_face = 1e-4},
                .disk_mb = {.per_face = 2.1e-5},
                .frames = {.files = "path", .pattern = "undistorted_color_images/*.jpg", .divided_by = {"every"}},
                .faces = {.number = 1e6}};
    }
};

}  // namespace

FRESCO_STAGE("scan.matterport3d", ScanMatterport3d,
             "Undistorted pictures and mesh of a Matterport3D house, or of one of its rooms")
