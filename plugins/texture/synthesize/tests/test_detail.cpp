#include "catch.h"
#include "samples.h"

#include <map>

using namespace samples;

namespace
{

constexpr double spacing_m = 0.035;

SynthesisOptions with_detail(double detail)
{
    return {.size_px = 128,
            .stroke_m = 8 * spacing_m,
            .painterly = 0,
            .detail = detail,
            .patch_px = 7,
            .levels_count = 1,
            .rounds_count = 2,
            .checkpoint_seconds = 0};
}

LevelOptions level_options(double least_missing)
{
    return {.side = 7, .least_missing = least_missing, .search = {.repeat_cost = 22.5F, .weave_cost = 4}};
}

/// Mean squared difference of a painting from the start, on texels of one half of the wall.
double distance_from_start(const WallTask& wall, const Painting& painting, std::uint32_t chart)
{
    const int size = painting.texture.size_px();
    double sum = 0;
    double count = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            if (painting.texture.seen.at(x, y) == 0 || (x >= size / 2) != (chart == 1))
                continue;
            const Vec3f away = color_at(painting.texture, x, y) - wall.start(chart, texcoord(size, x, y));
            sum += static_cast<double>(dot(away, away));
            ++count;
        }
    return sum / count;
}

/// A texel of a texture of 128: more than a patch to the left of the right half. The left chart is turned by 0.4 about its
/// middle.
bool is_far_from_stripes(int x, int y)
{
    const double u = (x + 0.5) / 128 - 0.25;
    const double v = 0.75 - (y + 0.5) / 128;
    return u < 0.2 && u * std::cos(0.4) + v * std::sin(0.4) < 0.3 * (0.5 - 8 * spacing_m);
}

}  // namespace

TEST_CASE("finer strokes go where the painting lacks what the start shows, and nowhere else")
{
    WallTask wall(striped(0.25F), 24);
    Level broad(wall.task, spacing_m, 0.9, level_options(0), wall.run);
    broad.begin(nullptr, wall.run);
    broad.paint_round(Round::searches, wall.run);
    Level fine(wall.task, spacing_m / 2, 0.9, level_options(1.5), wall.run, &broad);
    CHECK(broad.colors().capacity() == 0);
    fine.begin(nullptr, wall.run);
    fine.paint_round(Round::searches, wall.run);

    for (std::size_t t = 0; t < fine.share().size(); ++t)
        if (fine.share()[t] > 0)
        {
            REQUIRE(fine.grid().texels()[t].position.x > 1 - 8 * spacing_m);
            REQUIRE_FALSE(fine.patches().covers(t).empty());
        }
    // The plain half has no texels of this size, but near the stripes.
    const SurfaceGrid whole(wall.surface, spacing_m / 2, wall.run);
    CHECK(4 * fine.grid().texels().size() < 3 * whole.texels().size());
    for (std::size_t p = 0; p < fine.patches().count(); ++p)
        CHECK(fine.patches()[p].center.x > 1 - 8 * spacing_m);
}

TEST_CASE("what is missing is that of a plain computation")
{
    WallTask wall(striped(0.25F), 24);
    Level level(wall.task, spacing_m, 0.9, level_options(0), wall.run);
    level.begin(nullptr, wall.run);
    const std::vector<Vec3f> start = level.colors();
    level.paint_round(Round::searches, wall.run);
    const std::vector<float> found = level.missing(wall.run);

    const Window window(7);
    std::vector<float> of_patch;
    for (std::size_t p = 0; p < level.patches().count(); ++p)
    {
        std::array<Vec3f, 49> a;
        std::array<Vec3f, 49> b;
        level.patches().sample(level.grid(), start, p, a.data());
        level.patches().sample(level.grid(), level.colors(), p, b.data());
        const auto mean = [&](const auto& value)
        {
            auto sum = value(0) * 0;
            float weights = 0;
            for (std::size_t i = 0; i < 49; ++i)
            {
                const float weight = window({static_cast<float>(i % 7) - 3, static_cast<float>(i / 7) - 3});
                sum += value(i) * weight;
                weights += weight;
            }
            return sum * (1 / weights);
        };
        const Vec3f mean_a = mean([&](std::size_t i) { return a[i]; });
        const Vec3f mean_b = mean([&](std::size_t i) { return b[i]; });
        const float variance = mean([&](std::size_t i) { return dot(a[i] - mean_a, a[i] - mean_a); });
        const float covariance = mean([&](std::size_t i) { return dot(a[i] - mean_a, b[i] - mean_b); });
        const float slope = variance > 0 ? std::clamp(covariance / variance, 0.0F, 1.0F) : 0;
        const float rest = mean(
            [&](std::size_t i)
            {
                const Vec3f left = b[i] - mean_b - (a[i] - mean_a) * slope;
                return dot(left, left);
            });
        of_patch.push_back(variance > 1e-9F ? std::sqrt(variance) * (1 - slope) * variance / (variance + rest) : 0);
    }
    float worst = 0;
    float most = 0;
    for (std::size_t t = 0; t < found.size(); ++t)
    {
        float sum = 0;
        float weights = 0;
        for (const std::uint32_t patch : level.patches().covers(t))
        {
            const float weight = window(level.patches().offset(patch, level.grid().texels()[t].position));
            sum += weight * of_patch[patch];
            weights += weight;
        }
        worst = std::max(worst, std::abs(sum / weights - found[t]));
        most = std::max(most, found[t]);
    }
    CHECK(worst < 0.01F);
    CHECK(most > 3);
}

TEST_CASE("detail shows what broad strokes dissolve, in smaller copies of the picture, and changes nothing elsewhere")
{
    WallTask wall(striped(0.25F), 24);
    const Painting broad = fresco::synthesize::synthesize(wall.task, with_detail(0), nullptr, wall.run);
    const Painting fine = fresco::synthesize::synthesize(wall.task, with_detail(0.75), nullptr, wall.run);
    CHECK(distance_from_start(wall, fine, 1) < 0.8 * distance_from_start(wall, broad, 1));
    std::map<float, int> scales;
    bool is_same = true;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x)
            if (const auto place = fine.source.place(x, y))
            {
                ++scales[place->scale];
                if (is_far_from_stripes(x, y))
                    is_same = is_same && color_at(fine.texture, x, y) == color_at(broad.texture, x, y);
            }
    CHECK(is_same);
    CHECK(scales.size() == 3);
    CHECK(scales[1] > 300);
    CHECK(scales[2] + scales[4] > 300);
    WallTask plain(striped(0), 24);
    CHECK(fresco::synthesize::synthesize(plain.task, with_detail(1), nullptr, wall.run).texture.layers ==
          fresco::synthesize::synthesize(plain.task, with_detail(0), nullptr, wall.run).texture.layers);
}
