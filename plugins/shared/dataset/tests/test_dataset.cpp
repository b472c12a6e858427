#include "catch.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/dataset/manifest.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <functional>

using namespace fresco;

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

/// Error of the manifest after `change`.
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
               Contains("world_from_camera: expected a list of 12"));
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
