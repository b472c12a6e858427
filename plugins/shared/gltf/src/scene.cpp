#include <fresco/gltf/scene.h>

#include <fresco/error.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/numerics/numerics.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace fresco::gltf
{

namespace
{

template <class List>
const auto& element(const List& list, int index, const char* what)
{
    if (index < 0 || static_cast<std::size_t>(index) >= list.size())
        throw Error(fmt::format("{} {} of {}", what, index, list.size()));
    return list[static_cast<std::size_t>(index)];
}

Mat3 rotation_of(const std::vector<double>& q)
{
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(norm > 0.5) || !(norm < 2))
        throw Error("rotation: expected a quaternion of length 1");
    return numerics::rotation_of(q[3] / norm, q[0] / norm, q[1] / norm, q[2] / norm);
}

/// The nodes of the scene; without scenes those that are nobody's children.
std::vector<int> roots(const tinygltf::Model& model)
{
    const auto& scenes = model.scenes;
    if (!scenes.empty())
        return element(scenes, std::max(model.defaultScene, 0), "scene").nodes;
    std::set<int> children;
    for (const auto& node : model.nodes)
        children.insert(node.children.begin(), node.children.end());
    std::vector<int> result;
    for (int node = 0; node < static_cast<int>(model.nodes.size()); ++node)
        if (!children.contains(node))
            result.push_back(node);
    return result;
}

}  // namespace

Affine operator*(const Affine& a, const Affine& b)
{
    return {a.linear * b.linear, a.linear * b.origin + a.origin};
}

Affine place_of(const tinygltf::Node& node)
{
    const auto check = [](const std::vector<double>& values, std::size_t expected, const char* what)
    {
        bool good = values.empty() || values.size() == expected;
        for (const double value : values)
            good = good && std::isfinite(value);
        if (!good)
            throw Error(fmt::format("{}: expected {} finite numbers", what, expected));
        return !values.empty();
    };
    Affine place;
    if (check(node.matrix, 16, "matrix"))
    {
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                place.linear(row, column) = node.matrix[4 * static_cast<std::size_t>(column) + static_cast<std::size_t>(row)];
        place.origin = {node.matrix[12], node.matrix[13], node.matrix[14]};
        if (node.matrix[3] != 0 || node.matrix[7] != 0 || node.matrix[11] != 0 || node.matrix[15] != 1)
            throw Error("matrix: expected 0, 0, 0, 1 in the last row");
        return place;
    }
    if (check(node.rotation, 4, "rotation"))
        place.linear = rotation_of(node.rotation);
    if (check(node.scale, 3, "scale"))
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                place.linear(row, column) *= node.scale[static_cast<std::size_t>(column)];
    if (check(node.translation, 3, "translation"))
        place.origin = {node.translation[0], node.translation[1], node.translation[2]};
    return place;
}

std::vector<Affine> copies_of(const tinygltf::Model& model, const tinygltf::Node& node)
{
    constexpr std::size_t most_copies = 1'000'000;
    const auto instancing = node.extensions.find("EXT_mesh_gpu_instancing");
    const auto attributes = instancing != node.extensions.end() ? instancing->second.Get("attributes") : tinygltf::Value();
    constexpr std::array names{"TRANSLATION", "ROTATION", "SCALE"};
    std::array<AccessorRows, 3> rows;
    std::size_t count = 0;
    for (std::size_t i = 0; i < names.size(); ++i)
    {
        if (!attributes.Has(names[i]))
            continue;
        const std::size_t components = i == 1 ? 4 : 3;
        rows[i] = accessor_rows(model, attributes.Get(names[i]).GetNumberAsInt(), components, components);
        if (count > 0 && rows[i].count != count)
            throw Error(fmt::format("{} of {} copies; expected {}", names[i], rows[i].count, count));
        count = rows[i].count;
        if (count > most_copies)
            throw Error(fmt::format("{} copies; at most {} are read", count, most_copies));
    }
    std::vector<Affine> copies(std::max<std::size_t>(count, 1));
    for (std::size_t copy = 0; copy < count; ++copy)
    {
        tinygltf::Node place;
        const std::array values{&place.translation, &place.rotation, &place.scale};
        for (std::size_t i = 0; i < rows.size(); ++i)
            for (std::size_t k = 0; k < (rows[i].first != nullptr ? rows[i].components : 0); ++k)
                values[i]->push_back(rows[i].at(copy, k));
        copies[copy] = place_of(place);
    }
    return copies;
}

std::vector<std::pair<std::size_t, Affine>> placed_nodes(const tinygltf::Model& model)
{
    std::set<std::size_t> seen;
    std::vector<std::pair<int, Affine>> open;
    const auto push = [&](const std::vector<int>& children, const Affine& parent)
    {
        for (const int child : std::vector<int>(children.rbegin(), children.rend()))
            open.emplace_back(child, parent);
    };
    push(roots(model), {});
    std::vector<std::pair<std::size_t, Affine>> placed;
    while (!open.empty())
    {
        const auto [number, parent] = open.back();
        open.pop_back();
        const tinygltf::Node& source = element(model.nodes, number, "node");
        const auto node = static_cast<std::size_t>(number);
        if (!seen.insert(node).second)
            throw Error(entry("nodes", node) + "the node appears twice in the tree");
        try
        {
            placed.emplace_back(node, parent * place_of(source));
        }
        catch (const Error& error)
        {
            throw Error(entry("nodes", node) + error.what());
        }
        push(source.children, placed.back().second);
    }
    return placed;
}

}  // namespace fresco::gltf
