#include "decimate_openmesh.h"

#include <fresco/error.h>
#include <fresco/geometry/topology.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

// QuadricT.hh and the decimater need the kernel's declarations before them.
#include <OpenMesh/Core/Geometry/QuadricT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace
{

struct Traits : OpenMesh::DefaultTraits
{
    VertexAttributes(OpenMesh::Attributes::Status);
    EdgeAttributes(OpenMesh::Attributes::Status);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge | OpenMesh::Attributes::Status);
    FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Quadric = OpenMesh::Geometry::QuadricT<double>;

/// How strongly a border edge resists leaving its line, relative to the surface.
constexpr double border_weight = 10;
/// Pull of each vertex toward where it was, relative to the planes: spreads collapses evenly where the surface is flat and every
/// collapse costs nothing.
constexpr double point_weight = 1e-3;
constexpr float max_turn_deg = 90;

OpenMesh::Vec3d wide(const HalfedgeMesh::Point& p)
{
    return {p[0], p[1], p[2]};
}

/// Data that a vertex accumulates: the error planes, and the color of an area.
struct VertexLoad
{
    Quadric quadric;
    double area = 0;
    OpenMesh::Vec3d color_sum{0, 0, 0};
};

/// Area-weighted quadrics with border planes; carries colors along.
class ModBorderQuadric final : public OpenMesh::Decimater::ModBaseT<HalfedgeMesh>
{
  public:
    using Base = OpenMesh::Decimater::ModBaseT<HalfedgeMesh>;
    using CollapseInfo = OpenMesh::Decimater::CollapseInfoT<HalfedgeMesh>;
    using Handle = OpenMesh::Decimater::ModHandleT<ModBorderQuadric>;
    DECIMATER_MODNAME(BorderQuadric)

    explicit ModBorderQuadric(HalfedgeMesh& mesh) : Base(mesh, false) {}

    void set_loads(std::vector<VertexLoad>* loads) { loads_ = loads; }

    float collapse_priority(const CollapseInfo& ci) override
    {
        // A component of four closed faces, or a vertex left with two neighbors, would vanish.
        if ((ci.vl.is_valid() && !mesh().is_boundary(ci.vl) && mesh().valence(ci.vl) <= 3) ||
            (ci.vr.is_valid() && !mesh().is_boundary(ci.vr) && mesh().valence(ci.vr) <= 3))
            return ILLEGAL_COLLAPSE;
        auto q = load(ci.v0).quadric;
        q += load(ci.v1).quadric;
        return static_cast<float>(std::max(q(wide(ci.p1)), 0.0));
    }

    void postprocess_collapse(const CollapseInfo& ci) override
    {
        const auto& from = load(ci.v0);
        auto& to = load(ci.v1);
        to.quadric += from.quadric;
        to.area += from.area;
        to.color_sum += from.color_sum;
    }

  private:
    VertexLoad& load(OpenMesh::VertexHandle v) { return (*loads_)[static_cast<std::size_t>(v.idx())]; }

    std::vector<VertexLoad>* loads_ = nullptr;
};

class Watch final : public OpenMesh::Decimater::Observer
{
  public:
    Watch(fresco::Progress& progress, std::size_t faces, std::size_t target)
        : Observer(2000), progress_(progress), faces_(faces), target_(target)
    {
    }
    void notify(std::size_t collapses) override
    {
        const auto total = faces_ - target_;
        progress_.progress(static_cast<double>(std::min(2 * collapses, total)), static_cast<double>(total), "faces removed");
        progress_.check_canceled();
    }

  private:
    fresco::Progress& progress_;
    std::size_t faces_;
    std::size_t target_;
};

Quadric plane(const OpenMesh::Vec3d& unit_normal, const OpenMesh::Vec3d& point)
{
    return {unit_normal[0], unit_normal[1], unit_normal[2], -(unit_normal | point)};
}

void add_face(const HalfedgeMesh& mesh, OpenMesh::FaceHandle face, std::vector<VertexLoad>& loads)
{
    const auto h = mesh.halfedge_handle(face);
    const OpenMesh::VertexHandle v[3] = {mesh.from_vertex_handle(h), mesh.to_vertex_handle(h),
                                         mesh.to_vertex_handle(mesh.next_halfedge_handle(h))};
    const OpenMesh::Vec3d p[3] = {wide(mesh.point(v[0])), wide(mesh.point(v[1])), wide(mesh.point(v[2]))};
    auto normal = (p[1] - p[0]) % (p[2] - p[0]);
    const double twice_area = normal.norm();
    if (!(twice_area > 0))
        return;
    normal /= twice_area;
    const double share = twice_area / 6;
    auto q = plane(normal, p[0]);
    q *= share;
    for (int k = 0; k < 3; ++k)
    {
        auto& load = loads[static_cast<std::size_t>(v[k].idx())];
        load.quadric += q;
        load.area += share;
    }
    auto edge = h;
    for (int k = 0; k < 3; ++k, edge = mesh.next_halfedge_handle(edge))
    {
        if (!mesh.is_boundary(mesh.opposite_halfedge_handle(edge)))
            continue;
        const auto along = p[(k + 1) % 3] - p[k];
        const double norm = along.norm();
        if (!(norm > 0))
            continue;
        auto wall = plane((along % normal) / norm, p[k]);
        wall *= border_weight * norm * norm / 2;
        loads[static_cast<std::size_t>(v[k].idx())].quadric += wall;
        loads[static_cast<std::size_t>(v[(k + 1) % 3].idx())].quadric += wall;
    }
}

std::vector<VertexLoad> initial_loads(const HalfedgeMesh& mesh, const std::vector<fresco::Rgb8>& colors)
{
    std::vector<VertexLoad> loads(mesh.n_vertices());
    for (auto& load : loads)
        load.quadric.clear();
    for (const auto face : mesh.faces())
        add_face(mesh, face, loads);
    for (const auto v : mesh.vertices())
    {
        const auto i = static_cast<std::size_t>(v.idx());
        Quadric place(wide(mesh.point(v)));
        place *= point_weight * loads[i].area;
        loads[i].quadric += place;
        if (!colors.empty())
            loads[i].color_sum = OpenMesh::Vec3d(colors[i][0], colors[i][1], colors[i][2]) * loads[i].area;
    }
    return loads;
}

HalfedgeMesh to_halfedges(const fresco::Mesh& mesh)
{
    HalfedgeMesh out;
    out.reserve(mesh.positions.size(), mesh.positions.size() + mesh.triangles.size(), mesh.triangles.size());
    for (const auto& p : mesh.positions)
        out.add_vertex({p.x, p.y, p.z});
    const auto vertex = [](std::uint32_t i) { return OpenMesh::VertexHandle(static_cast<int>(i)); };
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto& t = mesh.triangles[f];
        if (!out.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])).is_valid())
            throw fresco::Error(fmt::format("face {} does not fit a halfedge structure after the repair", f));
    }
    out.update_face_normals();
    return out;
}

fresco::Mesh from_halfedges(const HalfedgeMesh& mesh, const std::vector<VertexLoad>& loads,
                            const std::vector<fresco::Rgb8>& colors)
{
    fresco::Mesh out;
    std::vector<std::uint32_t> index(mesh.n_vertices(), fresco::geometry::none);
    for (const auto v : mesh.vertices())  // skips deleted ones
    {
        const auto i = static_cast<std::size_t>(v.idx());
        if (mesh.is_isolated(v))
            continue;
        index[i] = static_cast<std::uint32_t>(out.positions.size());
        const auto& p = mesh.point(v);
        out.positions.push_back({p[0], p[1], p[2]});
        if (colors.empty())
            continue;
        fresco::Rgb8 color = colors[i];
        if (loads[i].area > 0)
            for (std::size_t c = 0; c < 3; ++c)
                color[c] = static_cast<std::uint8_t>(std::lround(loads[i].color_sum[c] / loads[i].area));
        out.colors.push_back(color);
    }
    for (const auto f : mesh.faces())
    {
        fresco::Triangle t{};
        std::size_t k = 0;
        for (const auto v : mesh.fv_range(f))
            t[k++] = index[static_cast<std::size_t>(v.idx())];
        out.triangles.push_back(t);
    }
    return out;
}

}  // namespace

fresco::Mesh decimated_openmesh(const fresco::Mesh& mesh, std::size_t max_faces, fresco::Progress& progress)
{
    auto halfedges = to_halfedges(mesh);
    progress.check_canceled();
    auto loads = initial_loads(halfedges, mesh.colors);
    {
        OpenMesh::Decimater::DecimaterT<HalfedgeMesh> decimater(halfedges);
        ModBorderQuadric::Handle quadric;
        decimater.add(quadric);
        decimater.module(quadric).set_loads(&loads);
        OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle flipping;
        decimater.add(flipping);
        decimater.module(flipping).set_max_normal_deviation(max_turn_deg);
        decimater.initialize();
        Watch watch(progress, mesh.triangles.size(), max_faces);
        decimater.set_observer(&watch);
        // OpenMesh stops once the count is below its argument plus one collapse, which takes one or two faces.
        decimater.decimate_to_faces(0, max_faces);
    }
    return from_halfedges(halfedges, loads, mesh.colors);
}
