#include "catch.h"
#include "line_field.h"
#include "samples.h"

#include <fresco/texturing/texel_faces.h>

using namespace studio;

namespace
{

/// Degrees between two lines, 0..90.
double between(Vec3f a, Vec3f b)
{
    const double cosine = std::abs(double{dot(a, b)}) / (double{length(a)} * double{length(b)});
    return std::acos(std::min(cosine, 1.0)) * 180 / std::numbers::pi;
}

Vec3f middle(const Mesh& mesh, std::size_t face)
{
    const Triangle& t = mesh.triangles[face];
    return (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0F / 3);
}

/// A quarter of a pipe around the y axis, 1 m long, 0.3 m in radius, in one chart.
Mesh pipe()
{
    Mesh mesh = testing::rectangle({}, {1, 0, 0}, {0, 1, 0}, 24, 30);
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{0.1F + 0.2F * p.x, 0.1F + 0.4F * p.y}; });
    for (Vec3f& p : mesh.positions)
    {
        const double angle = std::numbers::pi / 2 * static_cast<double>(p.x);
        p = {0.3F * static_cast<float>(std::sin(angle)), p.y, 0.3F * static_cast<float>(std::cos(angle))};
    }
    return mesh;
}

/// Median degrees between upright lines and the strokes of a painted wall, by the structure tensor over 15 x 15 texels.
double off_upright(const Texture& texture)
{
    const int size = texture.size_px();
    std::vector<double> errors;
    for (int y = 8; y + 8 < size; y += 3)
        for (int x = 8; x + 8 < size; x += 3)
        {
            if (on_wall(size, x - 8, y - 8).x < 0 || on_wall(size, x + 8, y + 8).x < 0)
                continue;
            double cosine = 0;
            double sine = 0;
            for (int j = y - 7; j <= y + 7; ++j)
                for (int i = x - 7; i <= x + 7; ++i)
                {
                    const auto light = [&](int column, int row)
                    { return static_cast<double>(luminance(color_at(texture, column, row))); };
                    const double dx = light(i + 1, j) - light(i - 1, j);
                    const double dy = light(i, j + 1) - light(i, j - 1);
                    cosine += dx * dx - dy * dy;
                    sine += 2 * dx * dy;
                }
            errors.push_back(std::abs(std::atan2(sine, cosine)) * 90 / std::numbers::pi);
        }
    REQUIRE(errors.size() > 200);
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    return errors[errors.size() / 2];
}

}  // namespace

TEST_CASE("gravity runs down walls, and on over the floor")
{
    const Prepared corner(bent_floor(std::numbers::pi / 2, 8), 0.05, {0, 0, 1});
    const LineHints hints(corner.surface, corner.upward);
    const auto slope = hints.gravity();
    const std::vector<Vec3f> lines = hints.smoothed(slope, 0.1, corner.run);
    REQUIRE(lines.size() == corner.mesh.triangles.size());
    for (std::size_t f = 0; f < lines.size(); ++f)
    {
        CAPTURE(f);
        const bool is_wall = middle(corner.mesh, f).z > 0.01F;
        CHECK(std::abs(slope[f]) == Approx(is_wall ? 1 : 0).margin(0.05));
        CHECK(length(lines[f]) == Approx(1).margin(1e-4));
        CHECK(between(lines[f], is_wall ? Vec3f{0, 0, 1} : Vec3f{0, 1, 0}) < 3);
    }
}

TEST_CASE("curvature runs along pipes")
{
    const Prepared bent(pipe(), 0.05);
    const LineHints hints(bent.surface, bent.upward);
    const std::vector<Vec3f> lines = hints.smoothed(hints.curvature(0.5), 0.05, bent.run);
    double sum = 0;
    for (const Vec3f line : lines)
    {
        CHECK(between(line, {0, 1, 0}) < 15);
        sum += between(line, {0, 1, 0});
    }
    CHECK(sum / static_cast<double>(lines.size()) < 5);
}

TEST_CASE("drawn lines lead strokes on both sides of a seam, and where nothing is drawn")
{
    for (const double degrees : {0.0, 30.0, 75.0, 120.0})
    {
        CAPTURE(degrees);
        const Prepared wall(turned_wall(0.4, 6), 0.05);
        const double angle = degrees * std::numbers::pi / 180;
        const Vec3f along{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
        // The left half of the wall only.
        Texture drawing = fresco::testing::blank_texture(256, 0.5F);
        const auto faces = texturing::find_texel_faces(wall.mesh, wall.surface.charts, 256, wall.run);
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        {
            if (!faces.covered(texel))
                continue;
            const Vec3f p = texturing::texel_position(wall.mesh, faces, texel);
            drawing.seen.values[texel] = p.x < 1;
            for (std::size_t c = 0; c < 3; ++c)
                drawing.layers[0].values[3 * texel + c] = 0.5F + 0.4F * std::sin(60 * (along.x * p.y - along.y * p.x));
        }
        const LineHints hints(wall.surface, wall.upward);
        for (const Vec3f line : hints.smoothed(hints.drawn(drawing, wall.run), 0.1, wall.run))
            CHECK(between(line, along) < 4);
        CHECK_THROWS_WITH(hints.drawn(fresco::testing::blank_texture(256, 0.5F), wall.run),
                          Catch::Contains("port 'lines' has no lines"));
    }
}

TEST_CASE("strokes are turned into the direction asked for, and as far as the picture has them only otherwise")
{
    Studio wall;
    wall.picture = brush_picture(160, 128, 21);
    const auto paint = [&](const char* direction, int threads) {
        return wall.paint({{"size_px", 256}, {"stroke_cm", 10.0}, {"up", "y"}, {"direction", direction}}, threads);
    };
    const Painted turned = paint("gravity", 2);
    CHECK(off_upright(*turned.texture) < 15);
    CHECK(off_upright(*paint("none", 2).texture) > 25);
    CHECK((turned.bytes == paint("gravity", 4).bytes));
}

TEST_CASE("turned copies are shifted by what their own pixels lack")
{
    WallTask wall([](std::uint32_t, Vec2f uv) { return Vec3f{uv.x, 0.9F, uv.y}; });
    const std::vector<Vec3f> lines(wall.mesh.triangles.size(), Vec3f{0.6F, 0.8F, 0});
    Task task = wall.task;
    task.lines = lines;
    const LevelOptions options{.side = 7, .search = {.completeness = 2, .repeat_cost = 0, .weave_cost = 0}};
    Level level(task, 0.04, 1, options, wall.run);
    level.begin(nullptr, wall.run);
    const std::vector<Vec3f> wanted = level.colors();
    level.paint_round(Round::searches, wall.run);
    std::size_t turned = 0;
    std::size_t limited = 0;
    float worst = 0;
    for (std::size_t p = 0; p < level.patches().count(); ++p)
    {
        const Match& match = level.matches()[p];
        std::array<Vec3f, 49> look;
        std::array<Vec3f, 49> copied;
        level.patches().sample(level.grid(), wanted, p, look.data());
        level.picture().turned_patch(match.at, match.turn, &copied[0].x);
        Vec3f gap;
        for (std::size_t i = 0; i < look.size(); ++i)
            gap += (look[i] - copied[i]) * (1.0F / 49);
        const Vec3f whole = gap * 0.75F;
        worst = std::max(worst, length(match.shift - whole * std::min(1.0F, 14 / length(whole))));
        turned += std::abs(match.turn.y) > 0.1F;
        limited += std::abs(length(match.shift) - 14) < 1e-3F;
    }
    CHECK(worst < 0.02F);
    CHECK(turned > level.patches().count() / 4);
    CHECK(limited > 0);
}
