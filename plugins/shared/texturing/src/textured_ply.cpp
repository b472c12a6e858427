#include <fresco/texturing/textured_ply.h>

#include <fresco/mesh_io.h>
#include <fresco/texturing/welded_mesh.h>

#include <cstring>
#include <fmt/format.h>
#include <span>

namespace fresco::texturing
{
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

std::vector<std::byte> split_ply(const Mesh& mesh, const std::string& comment)
{
    Bytes out;
    out.put_text(fmt::format("ply\nformat binary_little_endian 1.0\n{}element vertex {}\n"
                             "property float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n{}"
                             "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                             comment, mesh.positions.size(),
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

std::vector<std::byte> with_comment(const std::vector<std::byte>& ply, const std::string& comment)
{
    const std::string first_lines = "ply\nformat binary_little_endian 1.0\n";
    std::vector<std::byte> result(ply.begin(), ply.begin() + static_cast<std::ptrdiff_t>(first_lines.size()));
    const auto raw = std::as_bytes(std::span(comment));
    result.insert(result.end(), raw.begin(), raw.end());
    result.insert(result.end(), ply.begin() + static_cast<std::ptrdiff_t>(first_lines.size()), ply.end());
    return result;
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
    return texcoords == PlyTexcoords::vertex ? split_ply(mesh, comment) : with_comment(to_ply(mesh), comment);
}

}  // namespace fresco::texturing
