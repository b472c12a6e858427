#include "channels.h"

#include "verdict.h"

#include <fresco/evaluation/statistics.h>

#include <array>
#include <cmath>

namespace fresco::inspect
{
namespace
{

constexpr double clear_correlation = 0.3;
constexpr std::size_t fewest_pixels = 200;

struct Pairs
{
    std::vector<double> picture;
    std::vector<double> mesh;

    void add(double of_picture, double of_mesh)
    {
        picture.push_back(of_picture);
        mesh.push_back(of_mesh);
    }
    double correlation() const { return evaluation::pearson(picture, mesh); }
};

std::array<double, 3> color_at(const Mesh& mesh, const raycast::Hit& hit)
{
    std::array<double, 3> color{};
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t c = 0; c < 3; ++c)
            color[c] += hit.weights[corner] * mesh.colors[mesh.triangles[hit.triangle][corner]][c];
    return color;
}

}  // namespace

bool channels_exchanged(const raycast::Scene& scene, const std::vector<View>& views, const std::vector<Camera>& cameras)
{
    const Mesh& mesh = scene.mesh();
    if (mesh.colors.empty())
        return false;
    Pairs green;
    Pairs red_minus_blue;
    std::vector<double> as_recorded;
    std::vector<double> exchanged;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        Pairs of_frame;
        for (const ColorSample& sample : views[i].colors)
        {
            const std::array direction{cameras[i].ray(static_cast<double>(sample.x), static_cast<double>(sample.y))};
            std::array<raycast::Hit, 1> hit;
            scene.cast(cameras[i].world_from_camera.translation, direction, hit);
            if (!hit[0].found())
                continue;
            const auto color = color_at(mesh, hit[0]);
            green.add(sample.color[1], color[1]);
            red_minus_blue.add(sample.color[0] - sample.color[2], color[0] - color[2]);
            of_frame.add(sample.color[0] - sample.color[2], color[0] - color[2]);
        }
        if (const double correlation = of_frame.correlation(); std::isfinite(correlation))
        {
            as_recorded.push_back(correlation);
            exchanged.push_back(-correlation);
        }
    }
    return green.picture.size() >= fewest_pixels && green.correlation() > clear_correlation &&
           red_minus_blue.correlation() < -clear_correlation && gains(as_recorded, exchanged);
}

}  // namespace fresco::inspect
