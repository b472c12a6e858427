#include "decimations.h"

#include "decimate.h"
#include "peer_blender.h"
#include "vertex_clustering.h"

#ifdef FRESCO_HAS_OPENMESH
#include "decimate_openmesh.h"
#endif

namespace bench
{

#ifndef FRESCO_HAS_CGAL
std::vector<Decimation> cgal_decimations()
{
    return {};
}
#endif
#ifndef FRESCO_HAS_MESHOPTIMIZER
std::vector<Decimation> meshoptimizer_decimations()
{
    return {};
}
#endif

const std::vector<Decimation>& decimations()
{
    static const std::vector<Decimation> all = []
    {
        std::vector<Decimation> found{{"mesh.decimate",
                                       [](const fresco::Mesh& mesh, std::size_t target, fresco::Progress& progress)
                                       { return decimated(mesh, {.max_faces = target}, progress); }}};
        for (const auto& library : {meshoptimizer_decimations(), cgal_decimations()})
            found.insert(found.end(), library.begin(), library.end());
#ifdef FRESCO_HAS_OPENMESH
        found.push_back({"mesh.decimate_openmesh", decimated_openmesh});
#endif
        if (has_blender())
            found.push_back(blender_decimation());
        found.push_back({"vertex clustering", [](const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
                         { return clustered(mesh, target); }});
        return found;
    }();
    return all;
}

}  // namespace bench
