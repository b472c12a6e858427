#include "masks.h"

#include <fresco/error.h>
#include <fresco/geometry/topology.h>
#include <fresco/wording.h>

#include <algorithm>
#include <set>

using namespace fresco;

namespace fs = std::filesystem;

namespace
{

constexpr std::size_t ambiguous = static_cast<std::size_t>(-1);

std::map<std::string, std::size_t> frames_by_name(const std::vector<Frame>& frames)
{
    std::map<std::string, std::size_t> result;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        const auto [known, fresh] = result.emplace(frames[i].name, i);
        if (!fresh)
            known->second = ambiguous;
    }
    for (std::size_t i = 0; i < frames.size(); ++i)
        result.insert_or_assign(frames[i].sequence + "_" + frames[i].name, i);
    return result;
}

std::set<fs::path> entries(const fs::path& folder)
{
    std::set<fs::path> result;
    for (const auto& entry : fs::directory_iterator(folder))
        if (!entry.path().filename().string().starts_with('.'))
            result.insert(entry.path());
    return result;
}

bool is_picture(const fs::path& file)
{
    return file.extension() == ".png" || file.extension() == ".jpg";
}

/// Whether a pixel of a mask is in its region: the mean of its channels is bright.
bool is_in_mask(const Raster8& mask, int x, int y)
{
    constexpr int half = 128;
    int sum = 0;
    for (int c = 0; c < mask.channels; ++c)
        sum += mask.at(x, y, c);
    return sum >= half * mask.channels;
}

}  // namespace

std::vector<MaskedRegion> find_masks(const fs::path& folder, const std::vector<Frame>& frames)
{
    const auto by_name = frames_by_name(frames);
    std::vector<MaskedRegion> result;
    for (const fs::path& part : entries(folder))
    {
        if (!fs::is_directory(part))
            continue;
        MaskedRegion region{part.filename().string(), {}};
        for (const fs::path& file : entries(part))
        {
            if (!is_picture(file))
                continue;
            const auto frame = by_name.find(file.stem().string());
            if (frame == by_name.end())
            {
                std::vector<std::string> names;
                for (const auto& [name, index] : by_name)
                    names.push_back(name);
                throw Error(file.string() + ": there is no frame '" + file.stem().string() + "'" +
                            suggestion(file.stem().string(), names, 4) + "; name masks after the frames on port 'frames'");
            }
            if (frame->second == ambiguous)
                throw Error(file.string() + ": several sequences have a frame '" + frame->first +
                            "': name the mask <sequence>_<frame>");
            const auto [other, fresh] = region.mask_of_frame.emplace(frame->second, file);
            if (!fresh)
                throw Error(file.string() + " and " + other->second.string() + " are masks of the same frame: remove one");
        }
        if (!region.mask_of_frame.empty())
            result.push_back(std::move(region));
    }
    if (result.empty())
        throw MissingInput(folder.string() + ": no masks; expected pictures in a folder for each region, such as " +
                           (folder / "floor" / "frame-000000.png").string());
    return result;
}

FaceMap faces_in_sight(const Mesh& mesh, FaceFinder& finder, const Camera& camera, const Progress& progress)
{
    std::vector<FaceMap> maps(1, FaceMap(camera.intrinsics.width, camera.intrinsics.height));
    finder.find(std::span(&camera, 1), progress, maps);
    const Vec3d origin = camera.world_from_camera.translation;
    for (std::uint32_t& face : maps.front().values)
        if (face != no_face)
        {
            const Vec3d corner = vec_cast<double>(mesh.positions[mesh.triangles[face][0]]);
            if (dot(geometry::area_vector(mesh, face), corner - origin) >= 0)
                face = no_face;
        }
    return std::move(maps.front());
}

void Votes::add(std::size_t region, const Raster8& mask, const FaceMap& faces)
{
    for (int y = 0; y < mask.height; ++y)
        for (int x = 0; x < mask.width; ++x)
        {
            const std::uint32_t face = faces.at(x, y);
            if (face == no_face)
                continue;
            ++seen_[region][face];
            inside_[region][face] += is_in_mask(mask, x, y) ? 1 : 0;
        }
}

std::vector<std::uint32_t> Votes::winners() const
{
    constexpr double least_share = 0.5;  // The region has most of the face.
    std::vector<std::uint32_t> result(inside_.front().size(), static_cast<std::uint32_t>(inside_.size()));
    for (std::size_t face = 0; face < result.size(); ++face)
    {
        double best = 0;
        for (std::uint32_t region = 0; region < inside_.size(); ++region)
        {
            const double share = seen_[region][face] == 0
                                     ? 0
                                     : static_cast<double>(inside_[region][face]) / static_cast<double>(seen_[region][face]);
            if (share > best && share >= least_share)
            {
                best = share;
                result[face] = region;
            }
        }
    }
    return result;
}

bool Votes::is_seen(std::size_t face) const
{
    return std::ranges::any_of(seen_, [&](const std::vector<std::uint32_t>& seen) { return seen[face] != 0; });
}
