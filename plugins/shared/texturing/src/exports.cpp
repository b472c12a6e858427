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
#include <cstring>
#include <fmt/format.h>
#include <span>
#include <unordered_map>

namespace fresco::texturing
{

void check_textured_mesh(const TexturedMesh& textured, std::string_view source)
{
    check_mesh(textured.mesh, source);
    if (textured.mesh.texcoords.empty())
        throw Error(std::string(source) + " has no texcoords: wire what texture.bake made");
    const Raster8& picture = textured.image.pixels;
    if (picture.empty() || picture.width != picture.height || picture.channels != 3)
        throw Error(fmt::format(
            "{} has a picture of {} x {} texels and {} channels; expected a square RGB picture, as texture.bake makes it", source,
            picture.width, picture.height, picture.channels));
}

void check_written_mesh(const Mesh& found, const Mesh& meant)
{
    const auto expect = [](bool good, const std::string& what)
    {
        if (!good)
            throw Error("the written file differs from what was to be written: " + what);
    };
    expect(found.positions == meant.positions, "the positions differ");
    expect(found.colors == meant.colors, "the vertex colors differ");
    expect(found.texcoords.size() == (meant.texcoords.empty() ? 0 : 3 * found.triangles.size()),
           "the number of texcoords differs");
    std::size_t next = 0;
    for (std::size_t face = 0; face < meant.triangles.size(); ++face)
    {
        const Triangle& t = meant.triangles[face];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            continue;
        const std::string name = fmt::format("triangle {}", face);
        expect(next < found.triangles.size() && found.triangles[next] == t, name + " is missing or differs");
        for (std::size_t i = 0; i < 3 && !meant.texcoords.empty(); ++i)
            expect(found.texcoords[3 * next + i] == meant.texcoords[3 * face + i], name + " has a different texcoord");
        ++next;
    }
    expect(next == found.triangles.size(), "more triangles");
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

std::string valid_line(std::string_view name, std::uint64_t bytes, std::string_view what)
{
    return std::string(name) + ": " + file_size(bytes) + (what.empty() ? "" : ", " + std::string(what)) + ", valid";
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

bool is_jpeg(std::string_view extension)
{
    return extension == ".jpg" || extension == ".jpeg";
}

std::array<std::size_t, 3> shape_of(const Raster8& picture)
{
    return {static_cast<std::size_t>(picture.height), static_cast<std::size_t>(picture.width),
            static_cast<std::size_t>(picture.channels)};
}

bool holds(const NpyArray& array, const Raster8& picture)
{
    const auto shape = shape_of(picture);
    if (array.shape != std::vector<std::size_t>(shape.begin(), shape.end()))
        return false;
    return std::ranges::equal(array.as<std::uint8_t>(), picture.values);
}

/// `jpeg_quality`: for .jpg and .jpeg.
std::vector<std::byte> encoded_picture(const Raster8& picture, std::string_view extension, int jpeg_quality,
                                       const ImageIo& images)
{
    if (extension == ".png")
        return images.encode_png(picture);
    if (is_jpeg(extension))
        return images.encode_jpeg(picture, jpeg_quality);
    if (extension == ".npy")
        return to_npy(NpyType::uint8, shape_of(picture), std::as_bytes(std::span(picture.values)));
    throw Error("unknown picture extension \"" + std::string(extension) + "\"; expected .png, .jpg or .npy");
}

}  // namespace

void check_path_for_names(const std::string& path)
{
    if (path.find_first_of(" \t\r\n") != std::string::npos)
        throw Error("path \"" + path + "\" must contain no spaces, where readers split names");
}

PictureEncoding::PictureEncoding(Configurable* owner, int max_texture_px)
    : jpeg_quality_(owner, "jpeg_quality", 92, range(1, 100), "Quality if the picture is JPEG"),
      max_texture_px_(owner, "max_texture_px", max_texture_px, range(0, 65536),
                      "Shrink the picture to this side, chart by chart in linear light; 0: do not shrink"),
      images_(owner, "Encodes the picture and reads it back")
{
}

PictureEncoding::Encoded PictureEncoding::encoded(const TexturedMesh& textured, std::string_view extension, RunContext& run) const
{
    Encoded result;
    if (*max_texture_px_ != 0 && *max_texture_px_ < textured.image.pixels.width)
        result.smaller = smaller_picture(textured, *max_texture_px_, run);
    result.bytes = encoded_picture(result.picture(textured), extension, *jpeg_quality_, *images_);
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
    return {encoded_picture(maps.normals, extension, *jpeg_quality_, *images_),
            encoded_picture(maps.roughness, extension, *jpeg_quality_, *images_)};
}

void PictureEncoding::check(const std::filesystem::path& file, const Raster8& picture) const
{
    const std::string extension = file.extension().string();
    bool good = false;
    if (extension == ".npy")
        good = holds(read_npy(file), picture);
    else if (is_jpeg(extension))
    {
        const ImageHeader header = images_->check(file);
        good = header.width == picture.width && header.height == picture.height;
    }
    else
        good = images_->read_rgb(file) == picture;
    if (!good)
        throw Error(file.string() + ": the written picture differs from what was to be written");
}

PictureOptions::PictureOptions(Configurable* owner)
    : PictureEncoding(owner), image_format_(owner, "image_format", "png", one_of({"png", "jpeg"}), "How the picture is stored")
{
}

std::string PictureOptions::extension() const
{
    return *image_format_ == "jpeg" ? ".jpg" : ".png";
}

std::string PictureOptions::write(const TexturedMesh& textured, const std::filesystem::path& folder, const std::string& mesh_path,
                                  RunContext& run) const
{
    const std::string name = std::filesystem::path(mesh_path).replace_extension(extension()).generic_string();
    const Encoded image = encoded(textured, extension(), run);
    const Raster8& picture = image.picture(textured);
    write_file(folder / name, image.bytes);
    check(folder / name, picture);
    run.message(valid_line(name, image.bytes.size(), fmt::format("{0} x {0} texels", picture.width)));
    run.report("texture_px", picture.width);
    run.report("picture_bytes", image.bytes.size());
    return name;
}

namespace
{
/// A corner's position, texcoord and color.
using CornerKey = std::array<float, 6>;

/// Of the values' bits; -0 counts as 0.
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

/// The normal of each vertex that stands for all at its position; straight up where the faces around cancel or have no area.
std::vector<Vec3f> position_normals(const Mesh& mesh, const std::vector<std::uint32_t>& welded_vertex)
{
    std::vector<Vec3d> sums(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
    {
        const Vec3d a = vec_cast<double>(mesh.positions[t[0]]);
        const Vec3d twice_area = cross(vec_cast<double>(mesh.positions[t[1]]) - a, vec_cast<double>(mesh.positions[t[2]]) - a);
        for (const std::uint32_t v : t)
            sums[welded_vertex[v]] += twice_area;
    }
    std::vector<Vec3f> normals;
    normals.reserve(sums.size());
    for (const Vec3d sum : sums)
        normals.push_back(length(sum) > 0 ? vec_cast<float>(normalized(sum)) : Vec3f{0, 0, 1});
    return normals;
}
}  // namespace

WeldedMesh weld(const Mesh& mesh, bool with_colors)
{
    const std::vector<std::uint32_t> welded_vertex = welded_vertices(mesh);
    const std::vector<Vec3f> normals = position_normals(mesh, welded_vertex);
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
            welded.normals.push_back(normals[welded_vertex[vertex]]);
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

namespace
{
/// Bytes as they lie in memory: fresco runs only on little-endian machines, like its NPY files.
class Bytes
{
  public:
    template <class T>
    void put(T value)
    {
        const std::size_t at = bytes_.size();
        bytes_.resize(at + sizeof(T));
        std::memcpy(&bytes_[at], &value, sizeof(T));
    }
    void put_text(const std::string& text)
    {
        const auto raw = std::as_bytes(std::span(text));
        bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    }
    void reserve(std::size_t count) { bytes_.reserve(count); }
    std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
};

/// V: the texcoord that all corners of a vertex share.
std::vector<Vec2f> vertex_texcoords(const Mesh& mesh)
{
    std::vector<Vec2f> result(mesh.positions.size());
    for (std::size_t corner = 0; corner < mesh.texcoords.size(); ++corner)
        result[mesh.triangles[corner / 3][corner % 3]] = mesh.texcoords[corner];
    return result;
}

constexpr std::string_view ply_beginning = "ply\nformat binary_little_endian 1.0\n";

std::vector<std::byte> split_ply(const Mesh& mesh, const std::string& comment)
{
    Bytes out;
    out.put_text(fmt::format("{}{}element vertex {}\n"
                             "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n{}"
                             "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                             ply_beginning, comment, mesh.positions.size(),
                             mesh.colors.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n",
                             mesh.triangles.size()));
    out.reserve(1024 + mesh.positions.size() * 23 + mesh.triangles.size() * 13);
    const std::vector<Vec2f> texcoords = vertex_texcoords(mesh);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        out.put(mesh.positions[v]);
        out.put(texcoords[v]);
        if (!mesh.colors.empty())
            out.put(mesh.colors[v]);
    }
    for (const Triangle& t : mesh.triangles)
    {
        out.put(std::uint8_t{3});
        out.put(t);
    }
    return out.take();
}
}  // namespace

Mesh arranged(const Mesh& mesh, const std::vector<Rgb8>& colors, PlyTexcoords texcoords)
{
    Mesh result;
    if (texcoords != PlyTexcoords::vertex)
    {
        result.positions = mesh.positions;
        result.triangles = mesh.triangles;
        result.colors = colors;
        if (texcoords == PlyTexcoords::face)
            result.texcoords = mesh.texcoords;
        return result;
    }
    WeldedMesh welded = weld(mesh);
    result.positions = std::move(welded.positions);
    result.texcoords = mesh.texcoords;
    if (!colors.empty())
        result.colors.resize(result.positions.size());
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        result.triangles.push_back({welded.indices[3 * face], welded.indices[3 * face + 1], welded.indices[3 * face + 2]});
        for (std::size_t i = 0; i < 3 && !colors.empty(); ++i)
            result.colors[result.triangles[face][i]] = colors[mesh.triangles[face][i]];
    }
    return result;
}

std::vector<std::byte> textured_ply(const Mesh& mesh, PlyTexcoords texcoords, const std::string& picture)
{
    const std::string comment = picture.empty() ? "" : "comment TextureFile " + picture + "\n";
    if (texcoords == PlyTexcoords::vertex)
        return split_ply(mesh, comment);
    auto ply = to_ply(mesh);
    const auto text = std::as_bytes(std::span(comment));
    ply.insert(ply.begin() + ply_beginning.size(), text.begin(), text.end());
    return ply;
}

}  // namespace fresco::texturing
