#include "formats.h"

#ifdef FRESCO_SPLATS_GLTF
#include <fresco/gltf/gltf_file.h>
#include <fresco/gltf/scene.h>
#endif

#include <algorithm>

namespace fresco::splats
{

#ifdef FRESCO_SPLATS_GLTF
namespace
{

using gltf::AccessorRows;

constexpr const char* extension = "KHR_gaussian_splatting";

double srgb(double light)
{
    return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// A multiple of a rotation's quaternion: of the rows of its product with itself, the one with the largest diagonal.
std::array<double, 4> quaternion_of(const Mat3& m)
{
    const double x = m(2, 1) - m(1, 2), y = m(0, 2) - m(2, 0), z = m(1, 0) - m(0, 1);
    const double xy = m(0, 1) + m(1, 0), xz = m(0, 2) + m(2, 0), yz = m(1, 2) + m(2, 1);
    const std::array<std::array<double, 4>, 4> rows{{{1 + m(0, 0) + m(1, 1) + m(2, 2), x, y, z},
                                                     {x, 1 + m(0, 0) - m(1, 1) - m(2, 2), xy, xz},
                                                     {y, xy, 1 - m(0, 0) + m(1, 1) - m(2, 2), yz},
                                                     {z, xz, yz, 1 - m(0, 0) - m(1, 1) + m(2, 2)}}};
    std::size_t largest = 0;
    for (std::size_t k = 1; k < 4; ++k)
        largest = rows[k][k] > rows[largest][largest] ? k : largest;
    return rows[largest];
}

/// Appends the Gaussians of a primitive, placed as its node is.
void append(const gltf::GltfFile& file, const tinygltf::Primitive& primitive, const gltf::Affine& place, std::size_t most,
            Splats& splats)
{
    const tinygltf::Value& form = primitive.extensions.at(extension);
    const auto word = [&](const char* key)
    { return form.Has(key) && form.Get(key).IsString() ? form.Get(key).Get<std::string>() : std::string(); };
    if (form.Has("extensions") || word("kernel") != "ellipse" || primitive.mode != TINYGLTF_MODE_POINTS)
        throw Error("its splats are compressed or of another kernel than \"ellipse\"; \"splat-transform IN.glb OUT.ply\" "
                    "writes a PLY");
    const auto rows = [&](const std::string& name, std::size_t components)
    {
        const auto found = primitive.attributes.find(name);
        if (found == primitive.attributes.end())
            throw Error("a primitive with splats lacks the attribute " + name);
        return gltf::accessor_rows(file.model, found->second, components, components);
    };
    const auto own = [&](const char* name, std::size_t components)
    { return rows(std::string(extension) + ":" + name, components); };
    const AccessorRows centers = rows("POSITION", 3), turns = own("ROTATION", 4), scales = own("SCALE", 3),
                       opacities = own("OPACITY", 1), colors = own("SH_DEGREE_0_COEF_0", 3);
    const std::size_t begin = splats.size(), count = centers.count;
    for (const std::size_t each : {turns.count, scales.count, opacities.count, colors.count})
        if (each != count)
            throw Error("the attributes of a primitive with splats have different numbers of rows");
    if (count > most - begin)
        throw Error(fmt::format("its nodes show more Gaussians than its {} bytes hold", most));
    const double size = std::cbrt(determinant(place.linear));
    const Mat3 turn = Mat3{{1 / size, 0, 0, 0, 1 / size, 0, 0, 0, 1 / size}} * place.linear;
    if (!(RigidTransform{turn, {}}.rotation_error() < 1e-4) || !(size > 0))
        throw Error("a node with splats is mirrored or stretched; apply its transform and export again");
    const auto [w, x, y, z] = quaternion_of(turn);
    const Vec3d axis{x, y, z};
    // Drafts of the extension had logarithms, of which some are negative.
    bool are_logarithms = false;
    for (std::size_t i = 0; i < count; ++i)
        are_logarithms = are_logarithms || std::min({scales.at(i, 0), scales.at(i, 1), scales.at(i, 2)}) < 0;
    resize(splats, begin + count);
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto vector = [&](const AccessorRows& of) { return Vec3d{of.at(i, 0), of.at(i, 1), of.at(i, 2)}; };
        const auto log_scale = [&](double scale) { return std::log(size) + (are_logarithms ? scale : std::log(scale)); };
        const Vec3d own_axis = vector(turns), scale = vector(scales);
        const double own_w = turns.at(i, 3);
        const Vec3d turned = own_axis * w + axis * own_w + cross(axis, own_axis);
        Vec3d color = vector(colors) * harmonic_0 + Vec3d{0.5, 0.5, 0.5};
        if (word("colorSpace").starts_with("lin"))
            color = {srgb(color.x), srgb(color.y), srgb(color.z)};
        set(splats, begin + i, vec_cast<float>(place.linear * vector(centers) + place.origin),
            {w * own_w - dot(axis, own_axis), turned.x, turned.y, turned.z},
            {log_scale(scale.x), log_scale(scale.y), log_scale(scale.z)}, std::clamp(opacities.at(i, 0), 0.0, 1.0),
            vec_cast<float>(color), "GLB");
    }
}

}  // namespace

SplatFile parse_glb(Bytes bytes, const std::string& source)
{
    SplatFile result{.format = SplatFormat::glb, .splats = {}, .files = {}};
    try
    {
        const gltf::GltfFile file = gltf::load_gltf(
            bytes,
            [](const std::string&, const std::string& place) -> std::vector<std::byte> {
                throw Error(place +
                            "uri: a GLB with splats has its buffer inside; \"splat-transform IN.glb OUT.ply\" writes a PLY");
            });
        for (const auto& [node, place] : gltf::placed_nodes(file.model))
        {
            const auto& meshes = file.model.meshes;
            const int mesh = file.model.nodes[node].mesh;
            if (mesh >= static_cast<int>(meshes.size()))
                throw Error(fmt::format("{}mesh {} of {}", gltf::entry("nodes", node), mesh, meshes.size()));
            if (mesh >= 0)
                for (const auto& primitive : meshes[static_cast<std::size_t>(mesh)].primitives)
                    if (primitive.extensions.contains(extension))
                        append(file, primitive, place, bytes.size(), result.splats);
        }
    }
    catch (const Error& error)
    {
        throw Error(source + ": " + error.what());
    }
    if (result.splats.size() == 0)
        throw Error(source + ": is GLB without KHR_gaussian_splatting, and so without splats; models are read by scan.mesh");
    return result;
}
#else
SplatFile parse_glb(Bytes, const std::string& source)
{
    throw Error(source + ": is GLB, which fresco was built without; \"splat-transform IN.glb OUT.ply\" writes a PLY");
}
#endif

}  // namespace fresco::splats
