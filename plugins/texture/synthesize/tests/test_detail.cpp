#include "catch.h"
#include "samples.h"

#include "synthesis.h"

#include <fresco/images/lab.h>

#include <map>

using namespace samples;

namespace
{

constexpr double spacing_m = 0.035;
constexpr double pattern_m = 0.14;  // Half a stroke.

/// A wall of two charts: the left one plain, the right one with stripes of a contrast.
struct StripedWall
{
    explicit StripedWall(float contrast) : stripes(contrast) {}

    /// The stripes depend only on the position of a texcoord along the turned right chart.
    Vec3f color(std::uint32_t chart, Vec2f uv) const
    {
        const double along = static_cast<double>(uv.x) * std::cos(0.4) + static_cast<double>(uv.y) * std::sin(0.4);
        const auto wave = static_cast<float>(std::sin(2 * std::numbers::pi * along / 0.3 / pattern_m));
        return Vec3f{0.5F, 0.5F, 0.4F} + Vec3f{1, 1, 1} * (chart == 1 ? stripes * wave : 0);
    }

    SynthesisOptions options(double detail) const
    {
        return {.size_px = 128,
                .stroke_m = 8 * spacing_m,
                .painterly = 0,
                .detail = detail,
                .completeness = 2,
                .patch_px = 7,
                .levels_count = 1,
                .rounds_count = 2,
                .seed = 0,
                .checkpoint_seconds = 0,
                .preview_seconds = 1e9};
    }

    LevelOptions level_options(double least_missing) const
    {
        return {.side = 7,
                .stride = 4,
                .faithfulness = 0.5,
                .unrest = 0,
                .least_missing = least_missing,
                .search = {
                    .completeness = 2, .stroke_px = 8, .variety = 0, .lift = 0, .repeat_cost = 22.5, .weave_cost = 4, .seed = 0}};
    }

    float stripes;
    testing::TestRun run;
    Mesh mesh = turned_wall(0.4, 24);
    PaintedSurface surface{mesh, run};
    Upright upward = upright(surface, Vec3f{0, 1, 0});
    Raster8 picture = brush_picture(56, 48, 11);
    Task task{surface, upward, picture, [this](std::uint32_t chart, Vec2f uv, double) { return color(chart, uv); }};
};

/// Mean squared difference of a painting from the start, on texels of one half of the wall.
double distance_from_start(const StripedWall& wall, const Painting& painting, std::uint32_t chart)
{
    const int size = painting.texture.size_px();
    double sum = 0;
    double count = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const Vec2f uv{(static_cast<float>(x) + 0.5F) / static_cast<float>(size),
                           1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size)};
            if (painting.texture.seen.at(x, y) == 0 || (uv.x > 0.5F ? 1U : 0U) != chart)
                continue;
            const float* rgb = &painting.texture.layers[0].at(x, y);
            const Vec3f away = Vec3f{rgb[0], rgb[1], rgb[2]} - wall.color(chart, uv);
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
    StripedWall wall(0.25F);
    Level broad(wall.task, spacing_m, 0.9, wall.level_options(0), wall.run);
    broad.begin(nullptr, wall.run);
    broad.paint_round(wall.run);
    Level fine(wall.task, spacing_m / 2, 0.9, wall.level_options(1.5), wall.run, &broad);
    CHECK(broad.colors().capacity() == 0);
    fine.begin(nullptr, wall.run);
    fine.paint_round(wall.run);

    double striped = 0;
    double count = 0;
    float plain = 0;
    for (std::size_t t = 0; t < fine.share().size(); ++t)
    {
        const SurfaceGrid::Texel& texel = fine.grid().texels()[t];
        if (texel.position.x > 1)
        {
            striped += static_cast<double>(fine.share()[t]);
            ++count;
        }
        else if (texel.position.x < 1 - 8 * spacing_m)
            plain = std::max(plain, fine.share()[t]);
        // A patch lies over every texel that counts.
        if (fine.share()[t] > 0)
            REQUIRE_FALSE(fine.patches().covers(t).empty());
    }
    CHECK(striped / count > 0.5);
    CHECK(plain == 0);
    // The plain half has no texels of this size, but near the stripes.
    const SurfaceGrid whole(wall.surface, spacing_m / 2, wall.run);
    CHECK(4 * fine.grid().texels().size() < 3 * whole.texels().size());
    for (std::size_t p = 0; p < fine.patches().count(); ++p)
        CHECK(fine.patches()[p].center.x > 1 - 8 * spacing_m);
}

TEST_CASE("what is missing is that of a plain computation")
{
    StripedWall wall(0.25F);
    const LevelOptions options = wall.level_options(0);
    Level level(wall.task, spacing_m, 0.9, options, wall.run);
    level.begin(nullptr, wall.run);
    const std::vector<Vec3f> start = level.colors();
    level.paint_round(wall.run);
    const std::vector<float> found = level.missing(wall.run);

    const auto window = [](double x, double y) {
        return static_cast<double>(Window(7)({static_cast<float>(x), static_cast<float>(y)}));
    };
    std::vector<double> of_patch;
    for (std::size_t p = 0; p < level.patches().count(); ++p)
    {
        std::array<std::array<Vec3f, 49>, 2> samples;
        level.patches().sample(level.grid(), start, p, samples[0].data());
        level.patches().sample(level.grid(), level.colors(), p, samples[1].data());
        // Weighted sums of start and painting, of all three values: a regression.
        double weights = 0;
        std::array<Vec3d, 2> mean;
        for (int i = 0; i < 49; ++i)
        {
            const double w = window(i % 7 - 3, i / 7 - 3);
            weights += w;
            for (std::size_t k = 0; k < 2; ++k)
                mean[k] += vec_cast<double>(samples[k][static_cast<std::size_t>(i)]) * w;
        }
        double variance = 0;
        double covariance = 0;
        for (int i = 0; i < 49; ++i)
        {
            const double w = window(i % 7 - 3, i / 7 - 3) / weights;
            const Vec3d a = vec_cast<double>(samples[0][static_cast<std::size_t>(i)]) - mean[0] * (1 / weights);
            const Vec3d b = vec_cast<double>(samples[1][static_cast<std::size_t>(i)]) - mean[1] * (1 / weights);
            variance += w * dot(a, a);
            covariance += w * dot(a, b);
        }
        const double slope = variance > 0 ? std::clamp(covariance / variance, 0.0, 1.0) : 0;
        double rest = 0;
        for (int i = 0; i < 49; ++i)
        {
            const double w = window(i % 7 - 3, i / 7 - 3) / weights;
            const Vec3d a = vec_cast<double>(samples[0][static_cast<std::size_t>(i)]) - mean[0] * (1 / weights);
            const Vec3d b = vec_cast<double>(samples[1][static_cast<std::size_t>(i)]) - mean[1] * (1 / weights);
            rest += w * dot(b - a * slope, b - a * slope);
        }
        of_patch.push_back(variance > 1e-9 ? std::sqrt(variance) * (1 - slope) * variance / (variance + rest) : 0);
    }
    double worst = 0;
    double most = 0;
    for (std::size_t t = 0; t < found.size(); ++t)
    {
        double sum = 0;
        double weights = 0;
        for (const std::uint32_t patch : level.patches().covers(t))
        {
            const Vec2f offset = level.patches().offset(patch, level.grid().texels()[t].position);
            const double w = window(static_cast<double>(offset.x), static_cast<double>(offset.y));
            sum += w * of_patch[patch];
            weights += w;
        }
        const double expected = weights > 0 ? sum / weights : 0;
        worst = std::max(worst, std::abs(expected - static_cast<double>(found[t])));
        most = std::max(most, expected);
    }
    CHECK(worst < 0.01);
    CHECK(most > 3);
}

TEST_CASE("detail shows what broad strokes dissolve, in smaller copies of the picture")
{
    StripedWall wall(0.25F);
    const Painting broad = fresco::synthesize::synthesize(wall.task, wall.options(0), nullptr, wall.run);
    const Painting fine = fresco::synthesize::synthesize(wall.task, wall.options(0.75), nullptr, wall.run);
    CHECK(distance_from_start(wall, fine, 1) < 0.8 * distance_from_start(wall, broad, 1));
    std::map<float, int> scales;
    bool is_same = true;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x)
        {
            const auto place = fine.source.place(x, y);
            if (!place)
                continue;
            ++scales[place->scale];
            if (is_far_from_stripes(x, y))
                for (int c = 0; c < 3; ++c)
                    is_same = is_same && fine.texture.layers[0].at(x, y, c) == broad.texture.layers[0].at(x, y, c);
        }
    CHECK(is_same);
    CHECK(scales.size() == 3);
    CHECK(scales[1] > 300);
    CHECK(scales[2] + scales[4] > 300);
}

TEST_CASE("where the start has no detail, nothing changes")
{
    StripedWall wall(0);
    const Painting broad = fresco::synthesize::synthesize(wall.task, wall.options(0), nullptr, wall.run);
    const Painting fine = fresco::synthesize::synthesize(wall.task, wall.options(1), nullptr, wall.run);
    CHECK(fine.texture.layers[0] == broad.texture.layers[0]);
    CHECK(fine.source.places == broad.source.places);
}
