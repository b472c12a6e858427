#include <fresco/mesh_io.h>

#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string>

namespace fresco
{
namespace
{

class PlyWriter
{
  public:
    explicit PlyWriter(std::vector<std::byte>& bytes, std::size_t offset) : next_(bytes.data() + offset) {}

    template <class T>
    void put(T value)
    {
        auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
        if constexpr (std::endian::native == std::endian::big)
            std::reverse(raw.begin(), raw.end());
        std::memcpy(next_, raw.data(), sizeof(T));
        next_ += sizeof(T);
    }

  private:
    std::byte* next_;
};

std::string header_of(const Mesh& mesh)
{
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    if (!mesh.texcoords.empty() && mesh.texture_px > 0)
        text += fmt::format("comment texture_px {}\n", mesh.texture_px);
    text += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.positions.size());
    if (!mesh.colors.empty())
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", mesh.triangles.size());
    if (!mesh.texcoords.empty())
        text += "property list uchar float texcoord\n";
    if (!mesh.charts.empty())
        text += "property int chart\n";
    return text + "end_header\n";
}

void check_fits_int(const Mesh& mesh)
{
    constexpr std::uint32_t greatest = std::numeric_limits<std::int32_t>::max();
    if (mesh.positions.size() > greatest)
        throw Error(fmt::format("a PLY file holds at most {} vertices, not {}", greatest, mesh.positions.size()));
    for (const std::uint32_t chart : mesh.charts)
        if (chart > greatest)
            throw Error(fmt::format("a PLY file holds chart numbers up to {}, not {}", greatest, chart));
}

}  // namespace

std::vector<std::byte> to_ply(const Mesh& mesh)
{
    check_mesh(mesh, "mesh to be written as PLY");
    check_fits_int(mesh);
    const std::string header = header_of(mesh);
    const std::size_t vertex_bytes = 12 + (mesh.colors.empty() ? 0U : 3U);
    const std::size_t face_bytes = 13 + (mesh.texcoords.empty() ? 0U : 25U) + (mesh.charts.empty() ? 0U : 4U);
    std::vector<std::byte> bytes(header.size() + mesh.positions.size() * vertex_bytes + mesh.triangles.size() * face_bytes);
    std::memcpy(bytes.data(), header.data(), header.size());

    PlyWriter out(bytes, header.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        out.put(mesh.positions[i].x);
        out.put(mesh.positions[i].y);
        out.put(mesh.positions[i].z);
        if (!mesh.colors.empty())
            for (const std::uint8_t channel : mesh.colors[i])
                out.put(channel);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        out.put(std::uint8_t{3});
        for (const std::uint32_t corner : mesh.triangles[i])
            out.put(corner);
        if (!mesh.texcoords.empty())
        {
            out.put(std::uint8_t{6});
            for (std::size_t corner = 3 * i; corner < 3 * i + 3; ++corner)
            {
                out.put(mesh.texcoords[corner].x);
                out.put(mesh.texcoords[corner].y);
            }
        }
        if (!mesh.charts.empty())
            out.put(mesh.charts[i]);
    }
    return bytes;
}

}  // namespace fresco
