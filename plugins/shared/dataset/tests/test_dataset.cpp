#include "catch.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/dataset/manifest.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <cmath>
#include <functional>
#include <limits>

using namespace fresco;
using Catch::Contains;

namespace
{

constexpr const char* hash = "0123456789abcdef0123456789abcdef";

dataset::Manifest small_manifest()
{
    dataset::Manifest manifest;
    manifest.uv = dataset::UvType::uint16;
    manifest.heights_px = {6, 12};
    manifest.has_style = true;
    dataset::View view;
    view.sequence = "seq-01";
    view.frame = "frame-000008";
    view.number = 8;
    view.color.intrinsics = {16, 12, 10.5, 11, 8, 6};
    view.color.world_from_camera.translation = {0.1, -2, 3};
    view.depth = view.color;
    view.depth.intrinsics.width = 8;
    view.depth_unit_m = 0.001;
    view.sharpness = 151.25;
    view.valid_pixels = {48, 0};
    manifest.views.push_back(view);
    for (const int height : manifest.heights_px)
        for (const char* quantity : {"uv", "depth", "cosine", "valid", "color"})
            manifest.files[dataset::map_name(0, quantity, height)] = {100, hash};
    for (const std::string& name : {std::string(dataset::mesh_name), std::string(dataset::style_name), dataset::picture_name(0),
                                    dataset::sensor_depth_name(0)})
        manifest.files[name] = {7, hash};
    return manifest;
}

/// What is said of the manifest once `change` was made to it.
std::string error_of(const std::function<void(Value&)>& change)
{
    Value root = parse_json(dataset::to_text(small_manifest()));
    change(root);
    return fresco::testing::error_of([&] { dataset::parse_manifest(to_json(root), "room/dataset.json"); });
}

Value& first_view(Value& root)
{
    return root.find("views")->as_list().front();
}

Value& first_file(Value& root)
{
    return root.find("files")->as_list().front();
}

}  // namespace

TEST_CASE("a manifest reads back as it was written")
{
    const auto manifest = small_manifest();
    const std::string text = dataset::to_text(manifest);
    const auto read = dataset::parse_manifest(text, "dataset.json");
    CHECK(read.writer.empty());
    auto named = manifest;
    named.writer = "fresco 9.8";
    CHECK(dataset::parse_manifest(dataset::to_text(named), "dataset.json").writer == "fresco 9.8");
    CHECK(read.uv == dataset::UvType::uint16);
    CHECK(read.heights_px == manifest.heights_px);
    CHECK(read.has_style);
    CHECK_FALSE(read.agreement);
    named.agreement = dataset::Agreement{0.25, 0.125, 7, 11.5};
    CHECK(dataset::parse_manifest(dataset::to_text(named), "dataset.json").agreement == named.agreement);
    REQUIRE(read.views.size() == 1);
    CHECK(read.views[0].color == manifest.views[0].color);
    CHECK(read.views[0].depth == manifest.views[0].depth);
    CHECK(read.views[0].depth_unit_m == 0.001);
    CHECK(read.views[0].number == 8);
    CHECK(read.views[0].valid_pixels == manifest.views[0].valid_pixels);
    CHECK(read.files == manifest.files);
    CHECK(dataset::to_text(read) == text);
}

TEST_CASE("names follow the view and the height")
{
    CHECK(dataset::map_name(12, "uv", 256) == "views/000012/uv_256.npy");
    CHECK(dataset::picture_name(0) == "views/000000/color.npy");
    CHECK(dataset::sensor_depth_name(1234567) == "views/1234567/sensor_depth.npy");
}

TEST_CASE("a manifest that is not as described is refused by file and entry")
{
    CHECK(error_of([](Value&) {}).empty());
    const auto set = [](const char* key, const Value& value) { return error_of([&](Value& root) { root.set(key, value); }); };
    CHECK(set("format", "zip") == "room/dataset.json: format: not a fresco dataset, whose format is \"fresco.dataset\"");
    CHECK_THAT(set("version", 2), Contains("version: 2; this fresco reads version 1"));
    CHECK_THAT(set("uv", "float16"), Contains("uv: expected float32 or uint16"));
    CHECK_THAT(set("heights_px", Value::List{12, 6}), Contains("heights_px: expected numbers from 1"));
    CHECK_THAT(set("heights_px", Value::List{}), Contains("at least one height"));
    CHECK_THAT(set("heights_px", Value::List{6}), Contains("valid_pixels: 2 numbers; expected one per height, 1"));
    CHECK_THAT(set("views", Value::List{}), Contains("views: expected at least one"));
    CHECK_THAT(set("has_style", 1), Contains("room/dataset.json: has_style: expected"));
    CHECK_THAT(set("agreement", Value::Map{{"error_before", -1.0}}), Contains("agreement.error_before: expected a number"));
    CHECK_THAT(set("agreement", Value::Map{{"error_before", 1.0}}), Contains("agreement.error_after: missing"));
    CHECK_THAT(set("comment", "x"), Contains("unknown entry 'comment'"));
    CHECK_THAT(error_of([](Value& root) { root.find("conventions")->set("uv_origin", "upper left"); }),
               Contains("conventions.uv_origin: expected \"lower left\", got \"upper left\""));
    CHECK_THAT(error_of([](Value& root) { std::erase_if(root.as_map(), [](const auto& e) { return e.first == "uv"; }); }),
               Contains("uv: missing"));
    CHECK_THROWS_WITH(dataset::parse_manifest("{", "room/dataset.json"), Contains("room/dataset.json: not valid JSON at byte"));
    CHECK_THROWS_WITH(dataset::parse_manifest("[]", "room/dataset.json"), Contains("expected a map"));
}

TEST_CASE("views that cannot be are refused")
{
    const auto set = [](const char* key, const Value& value)
    { return error_of([&](Value& root) { first_view(root).set(key, value); }); };
    CHECK_THAT(set("sequence", "../up"), Contains("views[0].sequence: \"../up\" cannot be part of a file's name"));
    CHECK_THAT(set("frame", ".."), Contains("views[0].frame"));
    CHECK_THAT(set("frame", ""), Contains("views[0].frame"));
    CHECK_THAT(set("depth_unit_m", 0.0), Contains("above 0"));
    CHECK_THAT(set("sharpness", -1), Contains("sharpness"));
    CHECK_THAT(set("valid_pixels", Value::List{49, 0}), Contains("49 of the 48 pixels at 6 px"));
    CHECK_THAT(error_of([](Value& root) { first_view(root).find("color_camera")->set("fx", -1.0); }),
               Contains("color_camera: focal lengths"));
    CHECK_THAT(error_of([](Value& root) { first_view(root).find("color_camera")->set("width", std::int64_t{1} << 40U); }),
               Contains("color_camera.width"));
    CHECK_THAT(error_of([](Value& root) { first_view(root).find("color_camera")->set("world_from_camera", Value::List{1}); }),
               Contains("world_from_camera: expected a list of 3"));
    CHECK_THAT(error_of([](Value& root) { root.find("views")->as_list().push_back(first_view(root)); }),
               Contains("views[1]: seq-01/frame-000008 appears twice"));
}

TEST_CASE("names that lead out of the folder, or are missing, are refused")
{
    for (const char* name :
         {"../mesh.ply", "/etc/passwd", "views/../../x", "a//b", "a/./b", "", "a\\..\\b", "a/", "a\nb", "dataset.json"})
    {
        INFO(name);
        CHECK_THAT(error_of([&](Value& root) { first_file(root).set("name", name); }),
                   Contains("files[0].name:") && Contains("is not a file inside"));
    }
    CHECK_THAT(error_of([](Value& root) { first_file(root).set("name", "views/other.npy"); }),
               Contains("mesh.ply is not listed"));
    CHECK_THAT(error_of([](Value& root) { root.find("files")->as_list().pop_back(); }), Contains("valid_6.npy is not listed"));
    CHECK_THAT(error_of([](Value& root) { first_file(root).set("hash", "00"); }), Contains("files[0].hash: expected 32"));
    CHECK_THAT(error_of([](Value& root) { first_file(root).set("bytes", -1); }), Contains("files[0].bytes"));
    CHECK_THAT(error_of([](Value& root) { root.find("files")->as_list().push_back(first_file(root)); }),
               Contains("mesh.ply appears twice"));
}

TEST_CASE("texcoords as uint16 are off by half a step of 1/65535 at most, and exact at both ends")
{
    RasterF uv(1000, 1, 2);
    for (std::size_t i = 0; i < uv.values.size(); ++i)
        uv.values[i] = static_cast<float>(i) / static_cast<float>(uv.values.size() - 1);
    const RasterF back = dataset::restored(dataset::quantized(uv));
    for (std::size_t i = 0; i < uv.values.size(); ++i)
        CHECK(std::abs(back.values[i] - uv.values[i]) <= 0.5 / 65535 + 1e-7);
    CHECK(back.values.front() == 0);
    CHECK(back.values.back() == 1);
    uv.values = {-1e-6F, 1 + 1e-6F};
    CHECK(dataset::quantized(uv).values[0] == 0);
    CHECK(dataset::quantized(uv).values[1] == 65535);
}

TEST_CASE("rasters read back from NPY, and only as what they are")
{
    Raster8 picture(3, 2, 3);
    picture.at(2, 1, 2) = 9;
    const auto npy = dataset::to_npy(picture);
    CHECK(dataset::raster_from<std::uint8_t>(npy, 3, 2, 3, "a.npy") == picture);
    CHECK(dataset::picture_from(npy, "a.npy") == picture);
    CHECK_THROWS_WITH(dataset::raster_from<std::uint8_t>(npy, 2, 3, 3, "a.npy"),
                      "a.npy: an array of 2 x 3 x 3; expected 3 x 2 x 3");
    CHECK_THROWS_WITH(dataset::raster_from<std::uint8_t>(npy, 3, 2, 1, "a.npy"), Contains("expected 2 x 3"));
    CHECK_THROWS_WITH(dataset::raster_from<float>(npy, 3, 2, 3, "a.npy"), "a.npy: wrong array type; expected float32");
    const RasterF depth(4, 2, 1, 1.5F);
    CHECK(dataset::raster_from<float>(dataset::to_npy(depth), 4, 2, 1, "d.npy") == depth);
    CHECK_THROWS_WITH(dataset::picture_from(dataset::to_npy(depth), "d.npy"), Contains("d.npy: expected a picture, uint8"));
    CHECK_THROWS_WITH(dataset::picture_from(dataset::to_npy(Raster8(0, 0)), "d.npy"), Contains("1 to 200 million pixels"));
}
