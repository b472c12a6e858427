#include "labeled_surface.h"

#include <fresco/error.h>
#include <fresco/geometry/surface_search.h>
#include <fresco/geometry/topology.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/value.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

using namespace fresco;

namespace
{

/// The class of an NYU40 id, 1 to 40, as in ScanNet's `.labels.ply`; nullopt for others.
std::optional<std::string_view> nyu40_name(std::int64_t id)
{
    constexpr std::array<std::string_view, 40> names{"wall",       "floor",          "cabinet",        "bed",
                                                     "chair",      "sofa",           "table",          "door",
                                                     "window",     "bookshelf",      "picture",        "counter",
                                                     "blinds",     "desk",           "shelves",        "curtain",
                                                     "dresser",    "pillow",         "mirror",         "floor mat",
                                                     "clothes",    "ceiling",        "books",          "refrigerator",
                                                     "television", "paper",          "towel",          "shower curtain",
                                                     "box",        "whiteboard",     "person",         "night stand",
                                                     "toilet",     "sink",           "lamp",           "bathtub",
                                                     "bag",        "otherstructure", "otherfurniture", "otherprop"};
    if (id < 1 || id > static_cast<std::int64_t>(names.size()))
        return std::nullopt;
    return names[static_cast<std::size_t>(id - 1)];
}

/// Numbers names by their first use.
class Names
{
  public:
    std::uint32_t label(const std::string& name)
    {
        const auto [known, fresh] = label_of_.try_emplace(name, static_cast<std::uint32_t>(names_.size()));
        if (fresh)
            names_.push_back(name);
        return known->second;
    }
    std::vector<std::string> take() { return std::move(names_); }

  private:
    std::map<std::string, std::uint32_t> label_of_;
    std::vector<std::string> names_;
};

std::vector<std::uint32_t> voted(const Mesh& mesh, const std::vector<std::uint32_t>& of_vertex)
{
    std::vector<std::uint32_t> result;
    result.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        result.push_back(of_vertex[b] == of_vertex[c] ? of_vertex[b] : of_vertex[a]);
    return result;
}

std::vector<std::uint32_t> labels_of(const std::vector<std::int64_t>& numbers, Naming naming, Names& names)
{
    const auto label_of = [&](std::int64_t number)
    {
        if (naming == Naming::numbers)
            return number < 0 ? no_label : names.label(std::to_string(number));
        const auto name = nyu40_name(number);
        return name ? names.label(std::string(*name)) : no_label;
    };
    std::vector<std::uint32_t> result(numbers.size());
    std::ranges::transform(numbers, result.begin(), label_of);
    return result;
}

}  // namespace

LabeledSurface surface_from_ply(std::span<const std::byte> bytes, const std::string& source, const std::string& property,
                                Naming naming, const Mesh* moved)
{
    PlyIntegers integers{.property = property, .of_vertex = {}, .of_face = {}};
    LabeledSurface result;
    result.mesh = parse_ply(bytes, source, {}, nullptr, nullptr, &integers);
    Names names;
    if (!integers.of_face.empty())
        result.label_of_face = labels_of(integers.of_face, naming, names);
    else
        result.label_of_face = voted(result.mesh, labels_of(integers.of_vertex, naming, names));
    result.names = names.take();
    if (result.names.empty())
        throw Error(fmt::format("{}: the property '{}' labels nothing{}", source, property,
                                naming == Naming::nyu40 ? "; for labels other than NYU40's, set naming: numbers" : ""));
    if (moved == nullptr)
    {
        check_mesh(result.mesh, source);
        return result;
    }
    if (moved->positions.size() != result.mesh.positions.size())
        throw Error(fmt::format("{} has {} vertices, the mesh on port 'labeled' {}: these are labels of another mesh", source,
                                result.mesh.positions.size(), moved->positions.size()));
    result.mesh.positions = moved->positions;
    return result;
}

LabeledSurface surface_from_segments(const std::string& groups, const std::string& groups_source, const std::string& segments,
                                     const std::string& segments_source, const Mesh& mesh)
{
    const Value root = parse_json(groups, groups_source);
    Names names;
    std::map<std::int64_t, std::uint32_t> label_of_segment;
    for (const Value& group : root.at("segGroups").as_list())
    {
        const std::uint32_t label = names.label(group.at("label").as_string());
        for (const Value& segment : group.at("segments").as_list())
            label_of_segment[segment.as_int()] = label;
    }
    const Value indices = parse_json(segments, segments_source);
    const Value::List& segment_of = indices.at("segIndices").as_list();
    const bool are_of_faces = segments_source.ends_with(".fsegs.json");
    const std::size_t expected = are_of_faces ? mesh.triangles.size() : mesh.positions.size();
    if (segment_of.size() != expected)
        throw Error(
            fmt::format("{} has the segments of {} {}, the mesh on port 'labeled' has {}: these are labels of another mesh",
                        segments_source, segment_of.size(), are_of_faces ? "faces" : "vertices", expected));
    std::vector<std::uint32_t> labels;
    labels.reserve(expected);
    for (const Value& segment : segment_of)
    {
        const auto found = label_of_segment.find(segment.as_int());
        labels.push_back(found == label_of_segment.end() ? no_label : found->second);
    }
    LabeledSurface result{mesh, names.take(), are_of_faces ? std::move(labels) : voted(mesh, labels)};
    if (std::ranges::all_of(result.label_of_face, [](std::uint32_t label) { return label == no_label; }))
        throw Error(groups_source + " names none of the segments of " + segments_source + ": they belong to different scans");
    return result;
}

LabeledSurface surface_from_materials(const Model& model)
{
    Names names;
    LabeledSurface result;
    result.mesh = model.mesh;
    result.label_of_face.reserve(model.material_of_face.size());
    for (const std::uint32_t material : model.material_of_face)
    {
        const std::string& name = model.materials[material].name;
        result.label_of_face.push_back(name.empty() ? no_label : names.label(name));
    }
    result.names = names.take();
    if (result.names.empty())
        throw Error("no material of the model on port 'model' has a name: name them in the program that made it");
    return result;
}

CarriedLabels carried_labels(const LabeledSurface& from, const Mesh& to, double within_m, const Progress& progress)
{
    const auto corner = [](const Mesh& mesh, std::uint32_t vertex) { return vec_cast<double>(mesh.positions[vertex]); };
    const geometry::SurfaceSearch search(from.mesh);

    CarriedLabels result;
    result.label_of_face.assign(to.triangles.size(), no_label);
    std::vector<double> distances(to.triangles.size());
    constexpr std::size_t faces_per_piece = 4096;
    parallel_items(to.triangles.size(), faces_per_piece, progress,
                   [&](std::size_t f)
                   {
                       const auto& [a, b, c] = to.triangles[f];
                       const auto middle = (corner(to, a) + corner(to, b) + corner(to, c)) * (1.0 / 3);
                       const auto closest = search.nearest(middle, within_m);
                       distances[f] =
                           closest.found() ? std::sqrt(closest.squared_distance) : std::numeric_limits<double>::infinity();
                       if (closest.found())
                           result.label_of_face[f] = from.label_of_face[closest.face];
                   });
    double covered = 0;
    double total = 0;
    for (std::size_t f = 0; f < distances.size(); ++f)
    {
        const double area = length(geometry::area_vector(to, f)) / 2;
        total += area;
        if (std::isfinite(distances[f]))
        {
            covered += area;
            result.mean_distance_m += area * distances[f];
        }
    }
    result.covered_share = total > 0 ? covered / total : 0;
    result.mean_distance_m = covered > 0 ? result.mean_distance_m / covered : 0;
    return result;
}
