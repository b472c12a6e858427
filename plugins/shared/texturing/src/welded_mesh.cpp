#include <fresco/texturing/welded_mesh.h>

#include <bit>
#include <cstddef>
#include <unordered_map>

namespace fresco::texturing
{
namespace
{
/// Of the values' bits; -0 counts as 0.
template <std::size_t N>
struct FloatsHash
{
    std::size_t operator()(const std::array<float, N>& values) const
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

/// Numbers equal keys equally, by first use.
template <std::size_t N>
class Numbering
{
  public:
    explicit Numbering(std::size_t expected) { numbers_.reserve(expected); }
    std::uint32_t number(const std::array<float, N>& key)
    {
        return numbers_.try_emplace(key, static_cast<std::uint32_t>(numbers_.size())).first->second;
    }

  private:
    std::unordered_map<std::array<float, N>, std::uint32_t, FloatsHash<N>> numbers_;
};

/// V: the mesh's vertices with equal positions share a number.
std::vector<std::uint32_t> position_numbers(const Mesh& mesh)
{
    Numbering<3> numbering(mesh.positions.size());
    std::vector<std::uint32_t> numbers;
    numbers.reserve(mesh.positions.size());
    for (const Vec3f p : mesh.positions)
        numbers.push_back(numbering.number({p.x, p.y, p.z}));
    return numbers;
}

/// One normal per position number; straight up where the faces around cancel or have no area.
std::vector<Vec3f> position_normals(const Mesh& mesh, const std::vector<std::uint32_t>& numbers)
{
    std::vector<Vec3d> sums(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
    {
        const Vec3d a = vec_cast<double>(mesh.positions[t[0]]);
        const Vec3d twice_area = cross(vec_cast<double>(mesh.positions[t[1]]) - a, vec_cast<double>(mesh.positions[t[2]]) - a);
        for (const std::uint32_t v : t)
            sums[numbers[v]] += twice_area;
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
    const std::vector<std::uint32_t> numbers = position_numbers(mesh);
    const std::vector<Vec3f> normals = position_normals(mesh, numbers);
    Numbering<6> numbering(mesh.positions.size());
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
        const std::uint32_t index = numbering.number({p.x, p.y, p.z, uv.x, uv.y, color_number});
        if (index == welded.positions.size())
        {
            welded.positions.push_back(p);
            if (!mesh.texcoords.empty())
                welded.texcoords.push_back(uv);
            if (keeps_colors)
                welded.colors.push_back(color);
            welded.normals.push_back(normals[numbers[vertex]]);
        }
        welded.indices.push_back(index);
    }
    return welded;
}

}  // namespace fresco::texturing
