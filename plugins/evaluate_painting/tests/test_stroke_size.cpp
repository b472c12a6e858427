#include "catch.h"
#include "pictures.h"
#include "stored_png.h"
#include "stroke_size.h"
#include <fresco/testing_scenes.h>

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/images/stroke_width.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

using namespace fresco;
using namespace pictures;

namespace
{
constexpr double wave_px = 14;  // Of the picture's stripes: strokes of 7 pixels.

Raster8 stripes()
{
    return testing::picture(160, 150,
                            [](int x, int y, int)
                            { return 255 * (0.5 + 0.35 * std::sin(2 * std::numbers::pi * (0.8 * x + 0.6 * y) / wave_px)); });
}

/// A wall whose left chart is twice as wide in the atlas as it should be, and so is denser than the right one.
Mesh stretched_wall()
{
    Mesh mesh = testing::two_chart_wall();
    for (Vec2f& uv : mesh.texcoords)
        uv = uv.x < 0.5F ? Vec2f{(uv.x - 0.1F) * 1.6F + 0.02F, (uv.y - 0.1F) * 0.8F + 0.1F} : Vec2f{uv.x, uv.y + 0.4F};
    return mesh;
}

/// Colors from the place on the surface.
TexturedMesh painted(Mesh mesh, int size, const std::function<Vec3f(Vec3f)>& paint)
{
    TexturedMesh result;
    result.image.pixels = Raster8(size, size, 3);
    each_texel(mesh, size, [&](int x, int y, Vec3f at) { set_color(result.image.pixels, x, y, paint(at)); });
    result.mesh = std::move(mesh);
    return result;
}

/// Soft stripes `stroke_cm(place)` wide.
TexturedMesh striped(int size, const std::function<double(Vec3f)>& stroke_cm)
{
    return painted(stretched_wall(), size,
                   [&](Vec3f p)
                   {
                       const double wave =
                           std::sin(std::numbers::pi * 100 * (0.3 * double{p.x} + 0.954 * double{p.y}) / stroke_cm(p));
                       const auto value = static_cast<float>(0.5 + 0.3 * wave);
                       return Vec3f{value, value * 0.9F, value * 0.8F};
                   });
}

/// One view that sees all of the wall; its depth is a function of the place.
std::shared_ptr<UvMaps> seen_from(const std::filesystem::path& folder, const std::function<float(Vec3f)>& depth)
{
    constexpr int size = 256;
    UvMap map{RasterF(size, size, 2), RasterF(size, size), RasterF(size, size), Raster8(size, size)};
    each_texel(stretched_wall(), size,
               [&](int x, int y, Vec3f at)
               {
                   map.uv.at(x, y, 0) = (static_cast<float>(x) + 0.5F) / size;
                   map.uv.at(x, y, 1) = 1 - (static_cast<float>(y) + 0.5F) / size;
                   map.depth.at(x, y) = depth(at);
                   map.cosine.at(x, y) = 1;
                   map.valid.at(x, y) = 1;
               });
    UvMaps maps;
    maps.heights_px = {size};
    UvMaps::View view;
    view.sequence = "s";
    view.frame = "f";
    view.camera.intrinsics = {size, size, 200, 200, size / 2.0, size / 2.0};
    view.valid_pixels = {std::count(map.valid.values.begin(), map.valid.values.end(), 1)};
    maps.views.push_back(view);
    UvMaps::write_map({folder, folder}, 0, size, map);
    maps.save({folder, folder});
    return UvMaps::load({folder, folder});
}
}  // namespace

TEST_CASE("stripes have the width that they were drawn with, on any chart and at five sizes")
{
    const Progress progress;
    for (const double stroke_cm : {2.5, 4.0, 6.0, 9.0, 13.0})
    {
        CAPTURE(stroke_cm);
        const TexturedMesh wall = striped(512, [&](Vec3f) { return stroke_cm; });
        const StrokeSize size = stroke_size(wall, stripes(), stroke_cm, nullptr, progress);
        CHECK(size.swatches > 100);
        CHECK(size.stroke_cm == Approx(stroke_cm).epsilon(0.04));
        CHECK(std::isnan(size.by_distance.correlation));
        if (stroke_cm != 6)
            continue;
        // Another size than was asked for is found out.
        CHECK(stroke_size(wall, stripes(), stroke_cm * 1.3, nullptr, progress).stroke_cm < stroke_cm * 1.3 * 0.85);
        CHECK(stroke_size(wall, stripes(), stroke_cm / 1.3, nullptr, progress).stroke_cm > stroke_cm / 1.3 * 1.15);
    }
}

TEST_CASE("a painting laid on a wall has the strokes of the picture, at its scale")
{
    const Raster8 picture = painting(300, 300, 5);
    testing::TestRun run;
    const double stroke_px = stroke_width_px(picture, run);
    for (const double stroke_cm : {3.0, 5.0})
    {
        CAPTURE(stroke_cm, stroke_px);
        const TexturedMesh wall = painted(stretched_wall(), 1024,
                                          [&](Vec3f p)
                                          {
                                              // To and fro, so that there is no seam.
                                              const auto pixel = [&](float at)
                                              {
                                                  const int i = static_cast<int>(double{at} * 100 / stroke_cm * stroke_px) % 600;
                                                  return i < 300 ? i : 599 - i;
                                              };
                                              return color_at(picture, pixel(p.x), pixel(p.y));
                                          });
        CHECK(stroke_size(wall, picture, stroke_cm, nullptr, run).stroke_cm == Approx(stroke_cm).epsilon(0.1));
    }
}

TEST_CASE("the stage judges growth by its standard error, and no growth only where there are enough places")
{
    const testing::TemporaryFolder folder;
    const auto maps = seen_from(folder.path(), [](Vec3f p) { return 1 + p.x; });
    const auto judged = [&](double narrow_cm, double broad_cm, testing::TestRun& run)
    {
        testing::TemporaryFolder out;
        const auto wall = [&](Vec3f p) { return p.x < 1 ? narrow_cm : broad_cm; };
        testing::run_stage(FRESCO_PLUGIN_FILE, "evaluate.painting", Value::Map{{"stroke_cm", (narrow_cm + broad_cm) / 2}},
                           {{"textured_mesh", std::make_shared<TexturedMesh>(striped(512, wall))},
                            {"style", std::make_shared<Image>(stripes())},
                            {"uvmaps", maps}},
                           out.path(), run, {{"image_io", std::make_shared<stored_png::Codec>()}});
        const auto files = Files::load({out.path() / "figures", out.path()});
        return parse_json(read_text_file(files->loaded_from / files->names[0]));
    };
    testing::TestRun run;
    const Value grown = judged(2.2, 2.8, run);
    const Value of_few = judged(5.2, 6.8, run);
    CHECK(of_few.at("independent_places").as_double() < 100);
    CHECK_FALSE(of_few.at("figures").at("size_by_distance").at("reached").as_bool());
    const Value& figure = grown.at("figures").at("size_by_distance");
    const double error = grown.at("size_by_distance_error").as_double();
    CHECK(error < 0.1);
    CHECK(figure.at("at_most").as_double() == Approx(0.1 + 2 * error));
    CHECK(figure.at("at_least").as_double() == Approx(-0.1 - 2 * error));
    CHECK_FALSE(figure.at("reached").as_bool());
    CHECK(grown.at("independent_places").as_double() == Approx(1 + 1 / (error * error)));
    CHECK(judged(2.5, 2.5, run).at("figures").at("size_by_distance").at("reached").as_bool());
    const Value wide = judged(13, 13, run);
    CHECK(wide.at("figures").find("size_by_distance") == nullptr);
    CHECK(std::isfinite(wide.at("size_by_distance").as_double()));
    CHECK(wide.at("independent_places").as_double() < 100);
    CHECK(run.messages.end() !=
          std::ranges::find_if(run.messages, [](const std::string& line)
                               { return line.find("small correlations are not told from chance below 100") != line.npos; }));
}

TEST_CASE("sizes that cannot be measured are not")
{
    const Progress progress;
    const TexturedMesh wall = striped(256, [](Vec3f) { return 4; });
    CHECK(std::isnan(stroke_size(wall, stripes(), 30, nullptr, progress).stroke_cm));
    CHECK_THROWS_WITH(stroke_size(wall, Raster8(90, 90, 3, 100), 4, nullptr, progress), Catch::Contains("of one color"));
    const Raster8 small = changed(Raster8(9, 9, 3), [](int x, int) { return Vec3f{x % 4 < 2 ? 1.0F : 0.0F, 0, 0}; });
    CHECK_THROWS_WITH(stroke_size(wall, small, 4, nullptr, progress), Catch::Contains("9 x 9: smaller than 5"));
    testing::TestRun single(1);
    testing::TestRun four(4);
    CHECK(stroke_size(wall, stripes(), 4, nullptr, single).stroke_cm == stroke_size(wall, stripes(), 4, nullptr, four).stroke_cm);
    four.cancel_after(3);
    CHECK_THROWS_AS(stroke_size(wall, stripes(), 4, nullptr, four), Canceled);
}

namespace
{
constexpr double side_m = 0.2;

/// Smooth noise on a plane: values at the nodes of a grid, linear between them.
class SmoothField
{
  public:
    SmoothField(double spacing_m, Random& random) : spacing_(spacing_m)
    {
        for (double& value : nodes_)
            value = random.normal();
    }

    double at(Vec3f p) const
    {
        const double x = double{p.x} / spacing_;
        const double y = double{p.y} / spacing_;
        const int i = static_cast<int>(x);
        const int j = static_cast<int>(y);
        return (node(i, j) * (1 - x + i) + node(i + 1, j) * (x - i)) * (1 - y + j) +
               (node(i, j + 1) * (1 - x + i) + node(i + 1, j + 1) * (x - i)) * (y - j);
    }

  private:
    static constexpr int side = 64;
    double node(int i, int j) const { return nodes_[static_cast<std::size_t>(j * side + i)]; }

    double spacing_;
    std::vector<double> nodes_ = std::vector<double>(std::size_t{side} * side);
};

/// Squares all over a floor of 8 x 8 m.
std::vector<PlacedSize> floor_of(std::size_t count, Random& random, const std::function<double(Vec3f)>& distance,
                                 const std::function<ColoredSize(Vec3f, double)>& strokes)
{
    std::vector<PlacedSize> places;
    for (std::size_t i = 0; i < count; ++i)
    {
        const Vec3f p{static_cast<float>(8 * random.uniform()), static_cast<float>(8 * random.uniform()), 0};
        places.push_back({p, distance(p), strokes(p, distance(p))});
    }
    return places;
}

ColoredSize gray(double size)
{
    return {{50, 0, 0}, size};
}
}  // namespace

TEST_CASE("size by distance: chance takes the correlation as far as its standard error says")
{
    // Neither field knows of the other. Squares overlap, and distances change slowly: 1000 squares are no 1000 samples.
    constexpr int draws = 150;
    for (const double spacing_m : {0.15, 0.6})
    {
        CAPTURE(spacing_m);
        Random random(5);
        double squares = 0;
        double variances = 0;
        for (int draw = 0; draw < draws; ++draw)
        {
            const SmoothField distance(1.5, random);
            const SmoothField size(spacing_m, random);
            const auto places = floor_of(
                300, random, [&](Vec3f p) { return 3 + distance.at(p); }, [&](Vec3f p, double) { return gray(size.at(p)); });
            const SizeByDistance found = size_by_distance(places, {gray(0)}, side_m);
            squares += found.correlation * found.correlation / draws;
            variances += found.standard_error * found.standard_error / draws;
        }
        CHECK(std::sqrt(variances / squares) == Approx(1).margin(0.25));
        if (spacing_m > 0.5)  // The error of independent samples is far too small there.
            CHECK(squares > 2.5 / 300);
    }
}

TEST_CASE("size by distance: broad strokes where their colors fit are not growth")
{
    // The picture's light parts have broad strokes, and what is far away is light.
    Random random(4);
    std::vector<ColoredSize> picture;
    for (int i = 0; i < 500; ++i)
    {
        const double light = 20 + 60 * random.uniform();
        picture.push_back({{static_cast<float>(light), 0, 0}, light / 100 + 0.1 * random.normal()});
    }
    const SmoothField field(1.5, random);
    const auto distance = [&](Vec3f p) { return 3 + field.at(p); };
    const auto places = [&](double growth)
    {
        return floor_of(
            1000, random, distance,
            [&](Vec3f, double d)
            {
                const double light = std::clamp(50 + 15 * (d - 3) + 10 * random.normal(), 20.0, 80.0);
                return ColoredSize{{static_cast<float>(light), 0, 0}, light / 100 + growth * d + 0.1 * random.normal()};
            });
    };
    const auto chosen = places(0);
    CHECK(size_by_distance(chosen, {gray(0)}, side_m).correlation > 0.3);
    CHECK(std::abs(size_by_distance(chosen, picture, side_m).correlation) < 0.1);
    CHECK(size_by_distance(places(0.1), picture, side_m).correlation > 0.4);
}

TEST_CASE("size by distance: undefined for few places or sizes that are all equal")
{
    Random random(6);
    const auto three = floor_of(
        3, random, [](Vec3f p) { return p.x; }, [&](Vec3f, double) { return gray(random.normal()); });
    CHECK(std::isnan(size_by_distance(three, {gray(0)}, side_m).correlation));
    const auto equal = floor_of(
        20, random, [](Vec3f p) { return p.x; }, [](Vec3f, double) { return gray(0.5); });
    CHECK(std::isnan(size_by_distance(equal, {gray(0)}, side_m).correlation));
}
