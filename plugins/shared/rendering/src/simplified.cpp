#include <fresco/rendering/simplified.h>

#ifdef FRESCO_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <vector>

namespace fresco::rendering
{

TexturedMesh simplified(const TexturedMesh& textured, [[maybe_unused]] double error_m)
{
    TexturedMesh result = textured;
#ifdef FRESCO_MESHOPTIMIZER
    struct Corner
    {
        Vec3f position;
        Vec2f texcoord;
    };
    const Mesh& mesh = textured.mesh;
    std::vector<Corner> corners;
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i)
        corners.push_back({mesh.positions[mesh.triangles[i / 3][i % 3]], mesh.texcoords[i]});
    if (corners.empty())
        return result;
    std::vector<unsigned> numbers(corners.size());
    const std::size_t count =
        meshopt_generateVertexRemap(numbers.data(), nullptr, corners.size(), corners.data(), corners.size(), sizeof(Corner));
    std::vector<std::size_t> corner_of(count);
    std::vector<Corner> distinct(count);
    for (std::size_t i = 0; i < corners.size(); ++i)
    {
        corner_of[numbers[i]] = i;
        distinct[numbers[i]] = corners[i];
    }
    const float* const positions = &distinct.front().position.x;
    const float scale = meshopt_simplifyScale(positions, count, sizeof(Corner));
    std::vector<unsigned> kept(numbers.size());
    kept.resize(meshopt_simplify(kept.data(), numbers.data(), numbers.size(), positions, count, sizeof(Corner), 0,
                                 static_cast<float>(error_m) / scale, 0, nullptr));
    // A mesh no larger than the error would lose all of its faces.
    if (kept.empty())
        return result;
    result.mesh.triangles.clear();
    result.mesh.texcoords.clear();
    for (std::size_t i = 0; i < kept.size(); i += 3)
    {
        Triangle& face = result.mesh.triangles.emplace_back();
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::size_t from = corner_of[kept[i + corner]];
            face[corner] = mesh.triangles[from / 3][from % 3];
            result.mesh.texcoords.push_back(mesh.texcoords[from]);
        }
    }
#endif
    return result;
}

#ifdef FRESCO_MESHOPTIMIZER
#define FRESCO_TEXT(number) #number
#define FRESCO_TEXT_OF(macro) FRESCO_TEXT(macro)
#endif

const char* meshoptimizer_version()
{
#ifdef FRESCO_MESHOPTIMIZER
    return FRESCO_TEXT_OF(MESHOPTIMIZER_VERSION);
#else
    return "none";
#endif
}

}  // namespace fresco::rendering
