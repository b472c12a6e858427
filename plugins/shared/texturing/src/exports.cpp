#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <span>
#include <unordered_map>

namespace fresco::texturing
{

void check_textured_mesh(const TexturedMesh& textured, std::string_view source)
{
    check_has_atlas(textured.mesh, source, "what texture.bake made");
    const Raster8& picture = textured.image.pixels;
    if (picture.empty() || picture.width != picture.height || picture.channels != 3)
        throw Error(fmt::format(
            "{} has a picture of {} x {} texels and {} channels; expected a square RGB picture, as texture.bake makes it", source,
            picture.width, picture.height, picture.channels));
}

std::string grouped(std::uint64_t number)
{
    std::string text = std::to_string(number);
    for (std::size_t at = text.size(); at > 3;)
        text.insert(at -= 3, 1, ' ');
    return text;
}

std::string file_size(std::uint64_t bytes)
{
    constexpr std::array units{"kB", "MB", "GB", "TB"};
    if (bytes < 1000)
        return fmt::format("{} bytes", bytes);
    std::size_t unit = 0;
    // Tenths of the unit, rounded once.
    std::uint64_t divisor = 100;
    while (unit + 1 < units.size() && (bytes + divisor / 2) / divisor >= 10000)
    {
        divisor *= 1000;
        ++unit;
    }
    const std::uint64_t tenths = (bytes + divisor / 2) / divisor;
    return fmt::format("{}.{} {}", tenths / 10, tenths % 10, units[unit]);
}

void tell_export(RunContext& run, const std::string& name, std::size_t bytes, std::size_t triangles, int texture_px,
                 std::size_t picture_bytes)
{
    std::string line = fmt::format("{}: {}, {} triangles", name, file_size(bytes), grouped(triangles));
    if (texture_px != 0)
        line += fmt::format(", picture of {0} x {0} in {1}", texture_px, file_size(picture_bytes));
    run.message(line);
    run.report("triangles", triangles);
    run.report("texture_px", texture_px);
    run.report("picture_bytes", picture_bytes);
    run.report("bytes", bytes);
}

ExportedMesh::ExportedMesh(Configurable* owner)
    : textured_(owner, "textured_mesh", optional, "The mesh with its picture, as texture.bake makes it"),
      mesh_(owner, "mesh", optional, "Alternatively, a mesh or atlas without a picture, with its vertex colors")
{
}

void ExportedMesh::check() const
{
    if (textured_.has_value() == mesh_.has_value())
        throw Error(textured_.has_value()
                        ? "both 'textured_mesh' and 'mesh' are wired: wire one of them"
                        : "wire 'textured_mesh' (a texture.bake stage), or 'mesh' for a mesh without a picture");
    if (has_picture())
        check_textured_mesh(*textured_, "the mesh on port 'textured_mesh'");
    else
        check_mesh(*mesh_, "the mesh on port 'mesh'");
}

namespace
{

/// The loss is invisible, at a third of the bytes of PNG.
constexpr int jpeg_quality = 92;

std::vector<std::byte> encoded_picture(const Raster8& picture, std::string_view extension, const ImageIo& images)
{
    if (extension == ".png")
        return images.encode_png(picture);
    if (extension == ".jpg" || extension == ".jpeg")
        return images.encode_jpeg(picture, jpeg_quality);
    if (extension == ".npy")
        return to_npy(picture);
    throw Error("unknown picture extension \"" + std::string(extension) + "\"; expected .png, .jpg or .npy");
}

}  // namespace

void check_path_for_names(const std::string& path)
{
    if (path.find_first_of(" \t\r\n") != std::string::npos)
        throw Error("path \"" + path + "\" must contain no spaces, where readers split names");
}

PictureEncoding::PictureEncoding(Configurable* owner, int max_texture_px)
    : max_texture_px_(owner, "max_texture_px", max_texture_px, range(0, 65536),
                      "Shrink the picture to this side, chart by chart in linear light; 0: do not shrink"),
      images_(owner, "Encodes the picture")
{
}

PictureEncoding::Encoded PictureEncoding::encoded(const TexturedMesh& textured, std::string_view extension, RunContext& run) const
{
    Encoded result;
    if (*max_texture_px_ != 0 && *max_texture_px_ < textured.image.pixels.width)
        result.smaller = smaller_picture(textured, *max_texture_px_, run);
    result.bytes = encoded_picture(result.picture(textured), extension, *images_);
    run.check_canceled();
    return result;
}

PictureEncoding::EncodedRelief PictureEncoding::encoded(const Relief& relief, const Mesh& mesh, NormalFrame frame,
                                                        std::string_view extension, RunContext& run) const
{
    check_atlas(relief.atlas, mesh, "the relief on port 'relief'");
    const ReliefMaps maps = frame == NormalFrame::tangent ? tangent_maps(relief, mesh, *max_texture_px_, run)
                                                          : world_maps(relief, *max_texture_px_, run);
    run.check_canceled();
    return {encoded_picture(maps.normals, extension, *images_), encoded_picture(maps.roughness, extension, *images_)};
}

void PictureEncoding::write(const TexturedMesh& textured, const std::filesystem::path& folder, const std::string& name,
                            RunContext& run) const
{
    const Encoded image = encoded(textured, std::filesystem::path(name).extension().string(), run);
    const int side = image.picture(textured).width;
    write_file(folder / name, image.bytes);
    run.message(fmt::format("{}: {}, {} x {} texels", name, file_size(image.bytes.size()), side, side));
    run.report("texture_px", side);
    run.report("picture_bytes", image.bytes.size());
}

PictureOptions::PictureOptions(Configurable* owner)
    : PictureEncoding(owner), image_format_(owner, "image_format", "png", one_of({"png", "jpeg"}), "How the picture is stored")
{
}

std::string PictureOptions::extension() const
{
    return *image_format_ == "jpeg" ? ".jpg" : ".png";
}

namespace
{
/// A corner's position, texcoord and color.
using CornerKey = std::array<float, 6>;

/// Hash of the values' bits; -0 counts as 0.
struct CornerHash
{
    std::size_t operator()(const CornerKey& values) const
    {
        std::uint64_t hash = 0x9e3779b97f4a7c15U;
        for (const float v : values)
        {
            hash ^= std::bit_cast<std::uint32_t>(v + 0.0F);
            hash *= 0xff51afd7ed558ccdU;
            hash ^= hash >> 32U;
        }
        return static_cast<std::size_t>(hash);
    }
};
}  // namespace

WeldedMesh weld(const Mesh& mesh, bool with_colors)
{
    const std::vector<Vec3f> normals = smooth_normals(mesh);
    std::unordered_map<CornerKey, std::uint32_t, CornerHash> numbers;
    numbers.reserve(mesh.positions.size());
    const bool keeps_colors = with_colors && !mesh.colors.empty();
    WeldedMesh welded;
    welded.indices.reserve(mesh.triangles.size() * 3);
    for (std::size_t corner = 0; corner < mesh.triangles.size() * 3; ++corner)
    {
        const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
        const Vec3f p = mesh.positions[vertex];
        const Vec2f uv = mesh.texcoords.empty() ? Vec2f{} : mesh.texcoords[corner];
        const Rgb8 color = keeps_colors ? mesh.colors[vertex] : Rgb8{};
        const auto color_number = static_cast<float>(color[0] << 16U | color[1] << 8U | color[2]);
        const auto [entry, is_new] = numbers.try_emplace(CornerKey{p.x, p.y, p.z, uv.x, uv.y, color_number},
                                                         static_cast<std::uint32_t>(welded.positions.size()));
        if (is_new)
        {
            welded.positions.push_back(p);
            if (!mesh.texcoords.empty())
                welded.texcoords.push_back(uv);
            if (keeps_colors)
                welded.colors.push_back(color);
            // Straight up where the faces around cancel or have no area.
            welded.normals.push_back(normals[vertex] == Vec3f{} ? Vec3f{0, 0, 1} : normals[vertex]);
        }
        welded.indices.push_back(entry->second);
    }
    return welded;
}

namespace
{

/// Twice the signed area of a face's texcoords.
double turn_of(const WeldedMesh& mesh, std::size_t face)
{
    const auto uv = [&](std::size_t i)
    {
        const Vec2f at = mesh.texcoords[mesh.indices[3 * face + i]];
        return Vec2d{double{at.x}, double{at.y}};
    };
    return cross(uv(1) - uv(0), uv(2) - uv(0));
}

Vec3d square_to(Vec3d normal, Vec3d v)
{
    return normalized(v - normal * dot(normal, v));
}

/// Gives vertices one orientation, +1 or -1, and splits those that faces of both share. Returns V.
std::vector<std::int8_t> split_orientations(WeldedMesh& mesh)
{
    std::vector<std::int8_t> orientation(mesh.positions.size(), 0);
    std::unordered_map<std::uint32_t, std::uint32_t> twins;
    for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner)
    {
        const double turn = turn_of(mesh, corner / 3);
        std::uint32_t& vertex = mesh.indices[corner];
        if (turn == 0)
            continue;
        const std::int8_t sign = turn < 0 ? -1 : 1;
        if (orientation[vertex] == 0)
            orientation[vertex] = sign;
        if (orientation[vertex] == sign)
            continue;
        const auto [twin, is_new] = twins.try_emplace(vertex, static_cast<std::uint32_t>(mesh.positions.size()));
        if (is_new)
        {
            mesh.positions.push_back(mesh.positions[vertex]);
            mesh.normals.push_back(mesh.normals[vertex]);
            mesh.texcoords.push_back(mesh.texcoords[vertex]);
            if (!mesh.colors.empty())
                mesh.colors.push_back(mesh.colors[vertex]);
            orientation.push_back(sign);
        }
        vertex = twin->second;
    }
    return orientation;
}

}  // namespace

void add_tangents(WeldedMesh& mesh)
{
    const std::vector<std::int8_t> orientation = split_orientations(mesh);
    std::vector<Vec3d> sums(mesh.positions.size());
    for (std::size_t face = 0; face < mesh.indices.size() / 3; ++face)
    {
        const std::uint32_t* const v = &mesh.indices[3 * face];
        const double turn = turn_of(mesh, face);
        const auto side = [&](std::size_t from, std::size_t to)
        { return vec_cast<double>(mesh.positions[v[to]]) - vec_cast<double>(mesh.positions[v[from]]); };
        const auto rise = [&](std::size_t to) { return double{mesh.texcoords[v[to]].y} - double{mesh.texcoords[v[0]].y}; };
        // Along growing u, as v stays.
        const Vec3d along = (side(0, 1) * rise(2) - side(0, 2) * rise(1)) * (turn < 0 ? -1 : 1);
        for (std::size_t i = 0; i < 3 && turn != 0; ++i)
        {
            const Vec3d normal = vec_cast<double>(mesh.normals[v[i]]);
            const double cosine = dot(square_to(normal, side(i, (i + 1) % 3)), square_to(normal, side(i, (i + 2) % 3)));
            sums[v[i]] += square_to(normal, along) * std::acos(std::clamp(cosine, -1.0, 1.0));
        }
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
    {
        const Vec3d normal = vec_cast<double>(mesh.normals[i]);
        Vec3d tangent = square_to(normal, sums[i]);
        if (!(length(tangent) > 0.5))
            tangent = square_to(normal, std::abs(normal.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
        mesh.tangents.push_back({static_cast<float>(tangent.x), static_cast<float>(tangent.y), static_cast<float>(tangent.z),
                                 orientation[i] < 0 ? -1.0F : 1.0F});
    }
}

Mesh split_at_seams(const Mesh& mesh)
{
    Mesh result;
    result.offset_m = mesh.offset_m;
    if (mesh.texcoords.empty())
    {
        result.positions = mesh.positions;
        result.triangles = mesh.triangles;
        result.colors = mesh.colors;
        return result;
    }
    WeldedMesh welded = weld(mesh);
    result.positions = std::move(welded.positions);
    result.texcoords = mesh.texcoords;
    if (!mesh.colors.empty())
        result.colors.resize(result.positions.size());
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        result.triangles.push_back({welded.indices[3 * face], welded.indices[3 * face + 1], welded.indices[3 * face + 2]});
        for (std::size_t i = 0; i < 3 && !mesh.colors.empty(); ++i)
            result.colors[result.triangles[face][i]] = mesh.colors[mesh.triangles[face][i]];
    }
    return result;
}

std::vector<std::byte> textured_ply(const Mesh& mesh, const std::string& picture, bool in_world)
{
    const bool is_double = in_world && mesh.offset_m != Vec3d{};
    const std::vector<Vec3d> world = is_double ? world_positions(mesh) : std::vector<Vec3d>{};
    if (mesh.texcoords.empty() && !is_double)
        return to_ply(mesh);
    std::string comment = picture.empty() ? "" : "comment TextureFile " + picture + "\n";
    if (const Vec3d o = mesh.offset_m; !is_double && o != Vec3d{})
        comment += fmt::format("comment offset_m {} {} {}\n", o.x, o.y, o.z);
    const std::string header = fmt::format(
        "ply\nformat binary_little_endian 1.0\n{0}element vertex {1}\n"
        "property {2} x\nproperty {2} y\nproperty {2} z\n{3}{4}"
        "element face {5}\nproperty list uchar int vertex_indices\nend_header\n",
        comment, mesh.positions.size(), is_double ? "double" : "float",
        mesh.texcoords.empty() ? "" : "property float s\nproperty float t\n",
        mesh.colors.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n", mesh.triangles.size());
    std::vector<std::byte> out;
    out.reserve(1024 + mesh.positions.size() * 35 + mesh.triangles.size() * 13);
    // As they lie in memory: fresco runs only on little-endian machines, like its NPY files.
    const auto put = [&](const auto& values)
    {
        const auto bytes = std::as_bytes(std::span(values));
        out.insert(out.end(), bytes.begin(), bytes.end());
    };
    put(header);
    std::vector<Vec2f> texcoords(mesh.positions.size());  // All corners of a vertex share one.
    for (std::size_t corner = 0; corner < mesh.texcoords.size(); ++corner)
        texcoords[mesh.triangles[corner / 3][corner % 3]] = mesh.texcoords[corner];
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        is_double ? put(std::span(&world[v], 1)) : put(std::span(&mesh.positions[v], 1));
        if (!mesh.texcoords.empty())
            put(std::span(&texcoords[v], 1));
        if (!mesh.colors.empty())
            put(mesh.colors[v]);
    }
    for (const Triangle& t : mesh.triangles)
    {
        out.push_back(std::byte{3});
        put(t);
    }
    return out;
}

}  // namespace fresco::texturing
