#include <fresco/evaluation/posed_pictures.h>

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <string>
#include <string_view>

namespace fresco::evaluation
{
namespace
{

namespace fs = std::filesystem;

using Extensions = std::span<const std::string_view>;

std::vector<fs::path> listed(const Files& views)
{
    std::vector<fs::path> files;
    for (const std::string& name : views.names)
        files.push_back(views.loaded_from / name);
    return files;
}

/// The files of a folder, which is then noted as read by `extensions`; sorted.
std::vector<fs::path> listed(const fs::path& folder, Extensions extensions, RunContext& run)
{
    for (const std::string_view extension : extensions)
        run.reads_folder(folder, "*" + std::string(extension));
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file())
            files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
}

/// The files that end in one of `extensions`, by their names without folder and extension.
std::map<std::string, fs::path> by_stem(const std::vector<fs::path>& files, Extensions extensions)
{
    std::map<std::string, fs::path> result;
    for (const fs::path& file : files)
        if (std::ranges::find(extensions, file.extension().string()) != extensions.end())
            if (const auto [place, is_new] = result.emplace(file.stem().string(), file); !is_new)
                throw Error(fmt::format("{} and {} show the same view: keep one of them", file.string(), place->second.string()));
    return result;
}

std::map<std::string, fs::path> named_pictures(const Files* views, const fs::path& folder, RunContext& run, Extensions extensions)
{
    if ((views != nullptr) != folder.empty())
        throw Error("set either port 'views' (what render.views made) or option 'folder' (pictures made elsewhere)");
    return by_stem(views != nullptr ? listed(*views) : listed(folder, extensions, run), extensions);
}

}  // namespace

std::vector<PosedPicture> posed_pictures(const Frames& frames, const Files* views, const fs::path& folder, RunContext& run,
                                         Extensions extensions)
{
    const auto pictures = named_pictures(views, folder, run, extensions);
    std::vector<PosedPicture> result;
    std::set<std::string> names;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const std::string name = frames.frames[i].sequence + "_" + frames.frames[i].name;
        if (!names.insert(name).second)
            throw Error("two frames are named " + name + ": rename the scan's sequences so that they differ");
        const auto picture = pictures.find(name);
        if (picture == pictures.end())
            continue;
        if (views == nullptr)
            run.reads_file(picture->second);
        result.push_back({i, picture->second});
    }
    if (result.empty())
        throw Error(fmt::format("none of the {} pictures {} belongs to one of the {} frames; expected files named {}.png or .jpg",
                                pictures.size(), views != nullptr ? "on port 'views'" : "in " + folder.string(),
                                frames.frames.size(), names.empty() ? "<sequence>_<frame>" : *names.begin()));
    return result;
}

const Mesh& shown_mesh(const TexturedMesh* textured, const Mesh* plain)
{
    if ((textured != nullptr) == (plain != nullptr))
        throw Error("wire one of the ports 'textured_mesh' and 'mesh': depth is cast from it");
    const Mesh& mesh = plain != nullptr ? *plain : textured->mesh;
    check_mesh(mesh, plain != nullptr ? "the mesh on port 'mesh'" : "the mesh on port 'textured_mesh'");
    return mesh;
}

Camera camera_of_picture(const Frame& frame, int width, int height, const fs::path& file)
{
    check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
    const Intrinsics& k = frame.color.intrinsics;
    const double aspect = static_cast<double>(width) * k.height / (static_cast<double>(height) * k.width);
    if (std::abs(aspect - 1) > 0.01)
        throw Error(fmt::format("{}: is {}x{}; the color camera of {}/{} has {}x{}: pictures must show the camera's whole view",
                                file.string(), width, height, frame.sequence, frame.name, k.width, k.height));
    Camera camera = frame.color;
    camera.intrinsics = k.scaled_to(width, height);
    return camera;
}

}  // namespace fresco::evaluation
