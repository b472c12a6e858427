// ./bootstrap bench splats [FILE]: how many pictures of a splat one core draws in a second.
#include <fresco/numerics/numerics.h>
#include <fresco/splats/render_splats.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <string>

using namespace fresco;

namespace
{

struct OneThread final : Progress
{
    int threads() const override { return 1; }
};

/// 130,000 flat Gaussians of 4 mm on a ball of 1 m.
splats::Splats ball()
{
    splats::Splats made;
    for (const Vec3d out : numerics::spread_directions(130'000))
    {
        const double w = std::sqrt((1 + out.z) / 2);  // Turns +z to `out`.
        made.centers.push_back(vec_cast<float>(out * 0.5));
        made.rotations.push_back(
            {static_cast<float>(w), static_cast<float>(-out.y / (2 * w)), static_cast<float>(out.x / (2 * w)), 0});
        made.scales.push_back({0.004F, 0.004F, 0.0005F});
        made.opacities.push_back(0.5F);
        made.colors.push_back({0.5F, 0.5F, 0.5F});
    }
    return made;
}

}  // namespace

int main(int argc, char** argv)
{
    try
    {
        const splats::Splats scene = argc > 1 ? splats::read_splats(argv[1]).splats : ball();
        Vec3d middle;
        for (const Vec3f center : scene.centers)
            middle += vec_cast<double>(center) * (1.0 / static_cast<double>(scene.size()));
        double square = 0;
        for (const Vec3f center : scene.centers)
            square +=
                dot(vec_cast<double>(center) - middle, vec_cast<double>(center) - middle) / static_cast<double>(scene.size());
        const double distance = 3 * std::sqrt(square);
        constexpr int pictures = 24;
        const std::clock_t begin = std::clock();
        double covered = 0;
        for (int i = 0; i < pictures; ++i)
        {
            const double angle = 0.2618 * i, c = std::cos(angle), s = std::sin(angle);
            const Camera camera{{640, 480, 480, 480, 320, 240},
                                {{{c, 0, s, 0, 1, 0, -s, 0, c}}, middle - Vec3d{s, 0, c} * distance}};
            const auto picture = render_splats(scene, camera, distance / 10, OneThread());
            for (const float through : picture.transmittance.values)
                covered += through < 0.5F ? 1.0 / static_cast<double>(picture.transmittance.values.size()) : 0;
        }
        const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        std::printf("%zu Gaussians, %.0f %% of the pixels covered: %.1f pictures of 640 x 480 per second and core\n",
                    scene.size(), 100 * covered / pictures, pictures / seconds);
        return 0;
    }
    catch (const std::exception& error)
    {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
