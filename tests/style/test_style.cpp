// A painting, not a recoloured photograph and not a wallpaper: each of two generated styles must be found again in its own
// render, and the room must still be there.
#include "style_distance.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <iostream>

namespace
{

namespace fs = std::filesystem;
using fresco::Raster8;
using fresco::Value;
using fresco::testing::TemporaryFolder;

constexpr int height_px = 128;
constexpr int texture_px = 512;
/// Mean distance up to which renders are in a style. Paintings come to about 0.25, camera pictures to 0.65, recoloured to 0.8.
constexpr double furthest = 0.5;

fs::path library(const std::string& type)
{
    std::string name = type;
    std::ranges::replace(name, '.', '_');
    return fs::path(FRESCO_PLUGINS) / (name + ".so");
}

/// The stages in this process, results in one folder each.
class Room
{
  public:
    Room()
    {
        for (const char* type : {"image.opencv", "loss.patch_match", "texture.laplacian", "optimiser.adam"})
            factory_.add(type,
                         [type = std::string(type)]
                         {
                             auto made = fresco::testing::make_from_plugin(library(type), type);
                             return std::shared_ptr<fresco::Component>(dynamic_cast<fresco::Component*>(made.release()));
                         });
        run("scan.synthetic_room", "scan",
            Value::Map{{"frames_count", 16}, {"color_width_px", 256}, {"color_height_px", 192}, {"edge_m", 0.08}}, {});
        run("frames.hold_out", "split", Value::Map{{"every_count", 5}, {"first_count", 2}},
            {{"frames", load<fresco::Frames>("scan/frames")}});
        run("atlas.project", "atlas", Value::Map{{"size_px", texture_px}}, {{"mesh", load<fresco::Mesh>("scan/mesh")}});
        mesh = load<fresco::Mesh>("atlas/atlas");
        training = load<fresco::Frames>("split/training");
        held_out = load<fresco::Frames>("split/held_out");
        cast("training_maps", training);
        cast("held_out_maps", held_out);
        codec_ = std::dynamic_pointer_cast<fresco::ImageIo>(factory_.create("image_io", Value::Map{{"type", "image.opencv"}}));
        const auto maps = load<fresco::UvMaps>("held_out_maps/uvmaps");
        for (std::size_t i = 0; i < held_out->frames.size(); ++i)
        {
            const auto map = maps->load_map(i, 0);
            masks.push_back(map.valid);
            cameras.push_back(
                fresco::resized(fresco::load_color(held_out->frames[i], codec_.get()), map.valid.width, map.valid.height));
        }
    }

    Raster8 style(const std::string& kind)
    {
        run("picture.pattern", "picture-" + kind, Value::Map{{"kind", kind}}, {});
        return load<fresco::Image>("picture-" + kind + "/picture")->pixels;
    }

    std::vector<Raster8> painted(const std::string& kind)
    {
        return from_optimiser("painted-" + kind, kind,
                              Value::Map{{"size_px", texture_px}, {"max_steps", 80}, {"repeats_count", 8}});
    }

    /// What the painting begins as: the camera pictures on the surface, their colours moved to the style's. One step of no
    /// length.
    std::vector<Raster8> recoloured(const std::string& kind)
    {
        return from_optimiser("recoloured-" + kind, kind, Value::Map{{"size_px", texture_px}, {"max_steps", 1}, {"rate", 0.0}});
    }

    std::vector<Raster8> rendered(const std::shared_ptr<const fresco::TexturedMesh>& room, const std::string& name)
    {
        run("render.views", "views-" + name, Value::Map{{"height_px", height_px}}, {{"mesh", room}, {"frames", held_out}});
        std::vector<Raster8> views;
        for (const fresco::Frame& frame : held_out->frames)
            views.push_back(codec_->read_rgb(folder_.path() / ("views-" + name) / "views" / "views" /
                                             (frame.sequence + "_" + frame.name + ".png")));
        return views;
    }

    std::shared_ptr<const fresco::Mesh> mesh;
    std::shared_ptr<const fresco::Frames> training;
    std::shared_ptr<const fresco::Frames> held_out;
    std::vector<Raster8> cameras;
    std::vector<Raster8> masks;

  private:
    std::vector<Raster8> from_optimiser(const std::string& name, const std::string& kind, const Value& options)
    {
        run("texture.optimize", "texture-" + name, options,
            {{"uvmaps", load<fresco::UvMaps>("training_maps/uvmaps")},
             {"frames", training},
             {"style", load<fresco::Image>("picture-" + kind + "/picture")}});
        run("texture.bake", "bake-" + name, Value::Map{},
            {{"texture", load<fresco::Texture>("texture-" + name + "/texture")}, {"mesh", mesh}});
        return rendered(load<fresco::TexturedMesh>("bake-" + name + "/textured_mesh"), name);
    }

    template <class T>
    std::shared_ptr<const T> load(const std::string& place) const
    {
        return T::load({folder_.path() / place, folder_.path()});
    }

    void cast(const std::string& name, const std::shared_ptr<const fresco::Frames>& frames)
    {
        run("uvmaps.raycast", name, Value::Map{{"heights_px", Value::List{height_px}}}, {{"mesh", mesh}, {"frames", frames}});
    }

    void run(const std::string& type, const std::string& name, const Value& options,
             const std::map<std::string, std::shared_ptr<const fresco::Artifact>>& inputs)
    {
        const auto made = fresco::testing::make_from_plugin(library(type), type);
        fresco::testing::TestRun context;
        // As the host does, slots that the options leave out get their declared defaults.
        Value complete = options;
        const Value declaration = made->describe();
        for (const Value& option : declaration.at("options").as_list())
            if (option.at("kind").as_string().starts_with("component") && complete.find(option.at("name").as_string()) == nullptr)
            {
                const Value* rule = option.find("auto");
                complete.set(option.at("name").as_string(), rule != nullptr ? rule->at("if_empty") : option.at("default"));
            }
        fresco::testing::run_stage(dynamic_cast<fresco::Stage&>(*made), complete, inputs, folder_.path() / name, context,
                                   factory_);
    }

    TemporaryFolder folder_;
    fresco::testing::TestFactory factory_;
    std::shared_ptr<fresco::ImageIo> codec_;
};

struct Verdict
{
    bool own_style = true;  ///< Every style's renders are nearer to it than to the other.
    double distance = 0;    ///< Mean distance of the renders to their own style.
    double content = 0;     ///< Mean gradient correlation with the camera pictures.
    bool in_style() const { return own_style && distance <= furthest; }
    bool is_the_room() const { return content >= 0.25; }
};

/// renders[s][view] against styles[s].
Verdict judge(const Room& room, const std::array<std::vector<Raster8>, 2>& renders, const std::array<Raster8, 2>& styles)
{
    Verdict verdict;
    const std::array<std::vector<double>, 2> wanted{style_test::statistics(styles[0], {}), style_test::statistics(styles[1], {})};
    for (std::size_t s = 0; s < 2; ++s)
        for (std::size_t i = 0; i < renders[s].size(); ++i)
        {
            const auto found = style_test::statistics(renders[s][i], room.masks[i]);
            const double own = style_test::distance(found, wanted[s]);
            const double other = style_test::distance(found, wanted[1 - s]);
            const double content = style_test::gradient_correlation(room.cameras[i], renders[s][i], room.masks[i]);
            std::cout << "style " << s << " view " << i << ": own " << own << " other " << other << " content " << content
                      << '\n';
            verdict.own_style = verdict.own_style && own < other;
            verdict.distance += own / static_cast<double>(2 * renders[s].size());
            verdict.content += content / static_cast<double>(2 * renders[s].size());
        }
    return verdict;
}

/// The painting as wallpaper: repeated over the atlas, four times along each side.
std::shared_ptr<const fresco::TexturedMesh> tiled(const Room& room, const Raster8& style)
{
    auto result = std::make_shared<fresco::TexturedMesh>();
    result->mesh = *room.mesh;
    const Raster8 tile = fresco::resized(style, texture_px / 4, texture_px / 4);
    result->image.pixels = Raster8(texture_px, texture_px, 3);
    for (int y = 0; y < texture_px; ++y)
        for (int x = 0; x < texture_px; ++x)
            for (int c = 0; c < 3; ++c)
                result->image.pixels.at(x, y, c) = tile.at(x % tile.width, y % tile.height, c);
    return result;
}

}  // namespace

TEST_CASE("Each painted room is in its own picture's style, and still the room")
{
    Room room;
    REQUIRE(room.cameras.size() >= 2);
    const std::array<Raster8, 2> styles{room.style("strokes"), room.style("mosaic")};
    const std::array<std::vector<Raster8>, 2> renders{room.painted("strokes"), room.painted("mosaic")};
    const Verdict painted = judge(room, renders, styles);
    CHECK(painted.in_style());
    CHECK(painted.is_the_room());

    // What must not pass, each for its own reason. The camera texture with the style's colours is the room, but in no style.
    const Verdict recoloured = judge(room, {room.recoloured("strokes"), room.recoloured("mosaic")}, styles);
    CHECK(recoloured.distance > furthest);
    CHECK(recoloured.is_the_room());
    // So are the camera pictures; and the painting as wallpaper is not the room.
    CHECK(judge(room, {room.cameras, room.cameras}, styles).distance > furthest);
    CHECK_FALSE(
        judge(room, {room.rendered(tiled(room, styles[0]), "tiled-0"), room.rendered(tiled(room, styles[1]), "tiled-1")}, styles)
            .is_the_room());
}
