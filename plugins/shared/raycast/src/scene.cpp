#include <fresco/error.h>
#include <fresco/raycast/scene.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include FRESCO_EMBREE_HEADER

namespace fresco::raycast
{

Sight sight(const Hit& hit)
{
    if (!hit.found())
        return Sight::nothing;
    return fresco::sight(hit.front, hit.distance);
}

std::array<Vec3d, 3> corners(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    return {vec_cast<double>(mesh.positions[t[0]]), vec_cast<double>(mesh.positions[t[1]]),
            vec_cast<double>(mesh.positions[t[2]])};
}

Vec2d texcoord(const Mesh& mesh, std::uint32_t triangle, const std::array<double, 3>& weights)
{
    Vec2d uv;
    for (std::size_t corner = 0; corner < 3; ++corner)
    {
        const Vec2f c = mesh.texcoords[3 * std::size_t{triangle} + corner];
        uv = uv + Vec2d{c.x, c.y} * weights[corner];
    }
    return uv;
}

Vec2d texcoord(const Mesh& mesh, const Hit& hit)
{
    return texcoord(mesh, hit.triangle, hit.weights);
}

double texels_per_pixel(const Mesh& mesh, std::uint32_t triangle, Vec2d uv, const Camera& camera, double x, double y, int width,
                        int height)
{
    const auto plane = corners(mesh, triangle);
    const auto texels_to = [&](double px, double py)
    {
        double distance = 0;
        std::array<double, 3> weights{};
        if (!meet_plane(plane, camera.world_from_camera.translation, camera.ray(px, py), distance, weights) || distance <= 0)
            return 0.0;
        const Vec2d step = texcoord(mesh, triangle, weights) - uv;
        return length(Vec2d{step.x * width, step.y * height});
    };
    return std::max(texels_to(x + 1, y), texels_to(x, y + 1));
}

namespace
{
const char* name(RTCError error)
{
    switch (error)
    {
    case RTC_ERROR_OUT_OF_MEMORY:
        return "not enough memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
        return "this processor is not supported";
    default:
        return "internal error";
    }
}

[[noreturn]] void fail(RTCError error)
{
    throw Error(std::string("the ray caster (Embree) rejected the mesh: ") + name(error) +
                "; decimate the mesh or give the stage more memory");
}

}  // namespace

struct Scene::Embree
{
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;

    ~Embree()
    {
        if (scene)
            rtcReleaseScene(scene);
        if (device)
            rtcReleaseDevice(device);
    }

    void build(const Mesh& mesh)
    {
        // One thread: a parallel build orders equal candidates by chance, and with them the owner of a ray on a shared edge.
        device = rtcNewDevice("threads=1");
        if (!device)
            fail(rtcGetDeviceError(nullptr));
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        // Copies: Embree reads 4 bytes behind the last vertex, which a shared vector does not have.
        auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                     sizeof(Vec3f), mesh.positions.size()));
        auto* indices = static_cast<Triangle*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                       sizeof(Triangle), mesh.triangles.size()));
        if (vertices && indices)
        {
            std::copy(mesh.positions.begin(), mesh.positions.end(), vertices);
            std::copy(mesh.triangles.begin(), mesh.triangles.end(), indices);
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene, geometry);
            rtcCommitScene(scene);
        }
        rtcReleaseGeometry(geometry);
        if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
            fail(error);
    }
};

Scene::Scene(const Mesh& mesh) : mesh_(mesh), embree_(std::make_unique<Embree>())
{
    embree_->build(mesh);
}
Scene::~Scene() = default;

bool meet_plane(const std::array<Vec3d, 3>& corners, Vec3d origin, Vec3d direction, double& distance,
                std::array<double, 3>& weights)
{
    // Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997).
    const Vec3d edge1 = corners[1] - corners[0];
    const Vec3d edge2 = corners[2] - corners[0];
    const Vec3d p = cross(direction, edge2);
    const double determinant = dot(edge1, p);
    if (std::abs(determinant) < 1e-14 * length(edge1) * length(edge2) * length(direction) || determinant == 0)
        return false;
    const Vec3d from_corner = origin - corners[0];
    const Vec3d q = cross(from_corner, edge1);
    const double b1 = dot(from_corner, p) / determinant;
    const double b2 = dot(direction, q) / determinant;
    distance = dot(edge2, q) / determinant;
    weights = {1 - b1 - b2, b1, b2};
    return true;
}

namespace
{
void clamp_inside(std::array<double, 3>& weights)
{
    double sum = 0;
    for (double& w : weights)
    {
        w = std::max(w, 0.0);
        sum += w;
    }
    for (double& w : weights)
        w /= sum;
}

Hit refine(const Mesh& mesh, Vec3d origin, Vec3d direction, std::uint32_t triangle, float far, float u, float v)
{
    Hit hit;
    hit.triangle = triangle;
    const auto triangle_corners = corners(mesh, triangle);
    if (!meet_plane(triangle_corners, origin, direction, hit.distance, hit.weights))
    {
        hit.distance = double{far};
        hit.weights = {1.0 - double{u} - double{v}, double{u}, double{v}};
    }
    clamp_inside(hit.weights);
    const Vec3d face_normal = cross(triangle_corners[1] - triangle_corners[0], triangle_corners[2] - triangle_corners[0]);
    hit.front = dot(face_normal, direction) < 0;
    return hit;
}

/// Rays from one origin through neighboring pixels.
void intersect(RTCScene scene, const int* valid, RTCRayHit16& rays)
{
#if RTC_VERSION_MAJOR == 3
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, &rays);
#else
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &rays, &arguments);
#endif
}

/// Embree's answer for a packet of rays from one origin.
class Packet
{
  public:
    Packet(Vec3d origin, std::span<const Vec3d> directions)
    {
        const Vec3f start = vec_cast<float>(origin);
        for (std::size_t i = 0; i < Scene::packet_size; ++i)
        {
            valid_[i] = i < directions.size() ? -1 : 0;
            const Vec3f direction = valid_[i] ? vec_cast<float>(directions[i]) : Vec3f{0, 0, 1};
            rays_.ray.org_x[i] = start.x;
            rays_.ray.org_y[i] = start.y;
            rays_.ray.org_z[i] = start.z;
            rays_.ray.dir_x[i] = direction.x;
            rays_.ray.dir_y[i] = direction.y;
            rays_.ray.dir_z[i] = direction.z;
            rays_.ray.tnear[i] = 0;
            rays_.ray.tfar[i] = std::numeric_limits<float>::infinity();
            rays_.ray.time[i] = 0;
            rays_.ray.mask[i] = ~0u;
            rays_.ray.id[i] = 0;
            rays_.ray.flags[i] = 0;
            rays_.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            rays_.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
    }

    void intersect(RTCScene scene) { fresco::raycast::intersect(scene, valid_.data(), rays_); }

    Hit hit(std::size_t i, const Mesh& mesh, Vec3d origin, Vec3d direction) const
    {
        return rays_.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                   ? Hit{}
                   : refine(mesh, origin, direction, rays_.hit.primID[i], rays_.ray.tfar[i], rays_.hit.u[i], rays_.hit.v[i]);
    }

  private:
    alignas(64) std::array<int, Scene::packet_size> valid_;
    alignas(64) RTCRayHit16 rays_;
};

/// The direction turned by a millionth of a radian, micrometers on a wall.
Vec3d nudged(Vec3d direction)
{
    return direction + Vec3d{0.53, 0.31, 0.79} * (1e-6 * length(direction));
}
}  // namespace

void Scene::cast(Vec3d origin, std::span<const Vec3d> directions, std::span<Hit> hits) const
{
    Packet packet(origin, directions);
    packet.intersect(embree_->scene);
    std::array<Vec3d, packet_size> again;
    std::array<std::size_t, packet_size> ray;
    std::size_t missed = 0;
    for (std::size_t i = 0; i < directions.size(); ++i)
    {
        hits[i] = packet.hit(i, mesh_, origin, directions[i]);
        if (hits[i].found())
            continue;
        again[missed] = nudged(directions[i]);
        ray[missed++] = i;
    }
    if (missed == 0)
        return;
    // Embree is watertight along edges, but a ray that meets a vertex to the last bit can miss all faces around it.
    Packet second(origin, std::span(again).first(missed));
    second.intersect(embree_->scene);
    for (std::size_t i = 0; i < missed; ++i)
        hits[ray[i]] = second.hit(i, mesh_, origin, directions[ray[i]]);
}

void Scene::cast_rows(const Camera& camera, int first_row, int end_row, std::span<Hit> hits) const
{
    // A packet's rays go through a block of 4 x 4 pixels, smaller at the borders.
    constexpr int side = 4;
    const int width = camera.intrinsics.width;
    std::array<Vec3d, packet_size> directions;
    std::array<std::size_t, packet_size> places;
    std::array<Hit, packet_size> found;
    const Vec3d across = camera.world_from_camera.direction({1 / camera.intrinsics.fx, 0, 0});
    for (int block_y = first_row; block_y < end_row; block_y += side)
        for (int block_x = 0; block_x < width; block_x += side)
        {
            std::size_t count = 0;
            for (int y = block_y; y < std::min(block_y + side, end_row); ++y)
            {
                const Vec3d first = camera.ray(block_x + 0.5, y + 0.5);
                for (int x = block_x; x < std::min(block_x + side, width); ++x, ++count)
                {
                    directions[count] = first + across * static_cast<double>(x - block_x);
                    places[count] =
                        static_cast<std::size_t>(y - first_row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                }
            }
            cast(camera.world_from_camera.translation, std::span(directions).first(count), std::span(found).first(count));
            for (std::size_t i = 0; i < count; ++i)
                hits[places[i]] = found[i];
        }
}

const char* embree_version()
{
    return RTC_VERSION_STRING;
}

}  // namespace fresco::raycast
