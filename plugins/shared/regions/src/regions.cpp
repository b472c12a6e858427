#include <fresco/regions/regions.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/value.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace fresco
{
namespace
{

constexpr std::size_t most_names = 0xffff;

void check_names(const Regions& regions, std::string_view source)
{
    const std::set<std::string> unique(regions.names.begin(), regions.names.end());
    if (regions.names.empty() || unique.size() != regions.names.size() || unique.contains(""))
        throw Error(std::string(source) + ": expected the names of one or more regions, each once");
    for (std::size_t f = 0; f < regions.label_of_face.size(); ++f)
        if (regions.label_of_face[f] >= regions.names.size())
            throw Error(std::string(source) + ": face " + std::to_string(f) + " has the label " +
                        std::to_string(regions.label_of_face[f]) + "; expected less than " +
                        std::to_string(regions.names.size()));
}

}  // namespace

Regions::~Regions() = default;

void Regions::save(const ArtifactFolder& folder) const
{
    write_file(folder.path / "regions.json",
               to_json(Value::Map{{"atlas", atlas}, {"names", Value::List(names.begin(), names.end())}}, 1));
    const std::vector<std::size_t> shape{label_of_face.size()};
    write_file(folder.path / "labels.npy", to_npy(NpyType::uint16, shape, std::as_bytes(std::span(label_of_face))));
}

std::shared_ptr<Regions> Regions::load(const ArtifactFolder& folder)
{
    const auto file = folder.path / "regions.json";
    const Value root = parse_json(read_text_file(file), file.string());
    auto result = std::make_shared<Regions>();
    result->atlas = root.at("atlas").as_string();
    for (const Value& name : root.at("names").as_list())
        result->names.push_back(name.as_string());
    const auto labels_file = folder.path / "labels.npy";
    const NpyArray labels = read_npy(labels_file);
    if (labels.shape.size() != 1)
        throw Error(labels_file.string() + ": expected one label per face, uint16");
    const auto values = labels.as<std::uint16_t>();
    result->label_of_face.assign(values.begin(), values.end());
    check_names(*result, folder.path.string());
    return result;
}

void check_regions(const Regions& regions, const Mesh& mesh, std::string_view source, std::string_view mesh_source)
{
    const std::size_t count = regions.label_of_face.size();
    if (count != mesh.triangles.size() || (!regions.atlas.empty() && regions.atlas != atlas_id(mesh)))
        throw Error(std::string(source) + " are of another mesh: they label " + std::to_string(count) + " faces, " +
                    std::string(mesh_source) + " has " + std::to_string(mesh.triangles.size()) +
                    (count == mesh.triangles.size() ? " with other vertices or texcoords" : "") +
                    "; wire the regions.* stage to the same mesh");
    check_names(regions, source);
}

Regions regions_from(const Mesh& mesh, const std::vector<std::string>& names, const std::vector<std::uint32_t>& label_of_face)
{
    std::vector<std::string> wanted = names;
    const auto other = static_cast<std::uint32_t>(std::ranges::find(wanted, other_region) - wanted.begin());
    if (other == wanted.size())
        wanted.emplace_back(other_region);
    std::vector<std::uint32_t> renumbered(wanted.size(), 0);
    const auto settled = [&](std::uint32_t label) { return label < names.size() ? label : other; };
    for (const std::uint32_t label : label_of_face)
        renumbered[settled(label)] = 1;
    Regions regions;
    regions.atlas = atlas_id(mesh);
    for (std::size_t i = 0; i < wanted.size(); ++i)
        if (renumbered[i] != 0)
        {
            renumbered[i] = static_cast<std::uint32_t>(regions.names.size());
            regions.names.push_back(wanted[i]);
        }
    if (regions.names.size() > most_names)
        throw Error("there are " + std::to_string(regions.names.size()) + " regions; the limit is " + std::to_string(most_names));
    regions.label_of_face.reserve(label_of_face.size());
    for (const std::uint32_t label : label_of_face)
        regions.label_of_face.push_back(static_cast<std::uint16_t>(renumbered[settled(label)]));
    return regions;
}

void report_regions(const Regions& regions, const Mesh& mesh, RunContext& run)
{
    std::vector<double> areas(regions.names.size(), 0.0);
    double total = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto& [a, b, c] = mesh.triangles[f];
        const auto edge = [&, a = a](std::uint32_t v) { return vec_cast<double>(mesh.positions[v] - mesh.positions[a]); };
        const double area = length(cross(edge(b), edge(c))) / 2;
        areas[regions.label_of_face[f]] += area;
        total += area;
    }
    Value::Map shares;
    std::string text;
    for (std::size_t i = 0; i < areas.size(); ++i)
    {
        const double share = total > 0 ? areas[i] / total : 0;
        shares.emplace_back(regions.names[i], share);
        text += fmt::format("{}{} {:.1f}%", i == 0 ? "" : ", ", regions.names[i], 100 * share);
    }
    run.report("area_share", std::move(shares));
    run.message("share of the surface: " + text);
}

}  // namespace fresco
