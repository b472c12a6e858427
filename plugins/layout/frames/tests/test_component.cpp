#include "layout_test.h"

#include <fresco/files_io.h>
#include <fresco/npy.h>

#include <algorithm>
#include <set>

namespace
{

const LayoutUnderTest layout{.type = "layout.frames",
                             .write =
                                 [](const Frames& frames, const fs::path& folder, const ImageIo&)
                             {
                                 Frames listed = frames;
                                 for (auto& frame : listed.frames)
                                     for (auto* picture : {&frame.color_picture, &frame.depth_picture})
                                     {
                                         const auto copy = folder / "pictures" / picture->path.filename();
                                         copy_picture(picture->path, copy);
                                         picture->path = copy;
                                     }
                                 listed.save({folder, {}});
                                 write_mesh(folder / "mesh.ply");
                                 return folder;
                             },
                             .color = "pictures/frame-000001.color.png",
                             .depth = "pictures/frame-000001.depth.png",
                             .pose_source = "frames.json: frames[1]",
                             .damaged = {"frames.json", "mesh.ply"},
                             .has_depth_camera = true,
                             .third = "seq-01 frame-000002 2",
                             .mesh_faces = 1};

const char* const list = "frames.json";

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("cameras are those of the list, and pictures are stamped", "[layout.frames]")
{
    const WrittenRecording recording(layout);
    const auto frames = recording.read().frames->frames;
    for (std::size_t i = 0; i < 3; ++i)
    {
        CHECK(frames[i].color == recording.frames.frames[i].color);
        CHECK(frames[i].depth == recording.frames.frames[i].depth);
    }
    CHECK(frames[1].color_picture.hash == file_hash(recording.path / layout.color));
    recording.remove("mesh.ply");
    check_no_mesh(recording, "mesh.ply");
    auto far = Frames::load({recording.path, {}});
    far->offset_m = {448'000, 0, -2000};
    far->save({recording.path, {}});
    const auto again = recording.read().frames;
    CHECK(again->offset_m == far->offset_m);
    CHECK(length(again->frames[1].depth.world_from_camera.translation - frames[1].depth.world_from_camera.translation) < 1e-9);
    write_mesh(recording.path / "mesh.ply");
    // A mesh that nobody asked for is left out.
    TestRun run;
    CHECK(recording.read(run).mesh == nullptr);
    const std::string expected = "mesh.ply: the mesh is 448 km from the cameras, around (0, 0, 0) and (448000, 0, -2000) m";
    CHECK(std::ranges::any_of(run.messages, [&](const std::string& text) { return text.find(expected) != std::string::npos; }));
}

TEST_CASE("pictures may be NPY files, and a mask may be either", "[layout.frames]")
{
    const WrittenRecording recording(layout);
    const auto& written = recording.frames.frames[1];
    const auto color = load_color(written, &recording.images);
    const auto steps = load_depth_steps(written, &recording.images);
    Raster8 mask(32, 24, 1, 1);
    mask.at(7, 5) = 0;
    write_npy(recording.path / "c.npy", color);
    write_npy(recording.path / "d.npy", steps);
    write_npy(recording.path / "m.npy", mask);
    const auto own = [](const char* name) { return Value(Value::Map{{"ref", std::string("own:") + name}}); };
    recording.set_in_frame(list, 1, "color_picture", own("c.npy"));
    recording.set_in_frame(list, 1, "depth_picture", own("d.npy"));
    check_same_recording(*recording.read().frames, recording.frames, recording.images);
    recording.set_in_frame(list, 1, "mask", own("m.npy"));
    const auto frames = recording.read().frames->frames;
    const auto read = load_mask(frames[1]);
    CHECK(std::ranges::count(read.values, 0) == 1);
    CHECK(read.at(7, 5) == 0);
    CHECK(frames[0].mask.empty());
    write_npy(recording.path / "m.npy", Raster8(16, 12, 1, 1));
    CHECK_THAT(recording.error(), Contains("m.npy: the mask is 16x12; the picture of") && Contains("frame 1 is 32x24"));
    write_npy(recording.path / "c.npy", mask);
    CHECK_THAT(recording.error(), Contains("c.npy: ") && Contains("uint8 of height x width x 3"));
}

TEST_CASE("the schema knows the entries that are written", "[layout.frames]")
{
    const WrittenRecording recording(layout);
    const auto schema = parse_json(read_text_file(fs::path(FRESCO_SOURCE_FOLDER) / "sdk/docs/frames.schema.json"));
    const auto names = [](const Value& map)
    {
        std::set<std::string> keys;
        for (const auto& [key, value] : map.as_map())
            keys.insert(key);
        return keys;
    };
    const auto frame = recording.json(list).at("frames").as_list().at(0);
    const std::vector<std::pair<const char*, Value>> parts{
        {"frame", frame}, {"camera", frame.at("color_camera")}, {"picture", frame.at("color_picture")}};
    for (const auto& [part, written] : parts)
    {
        INFO(part);
        const Value& known = schema.at("$defs").at(part);
        CHECK(names(known.at("properties")) == names(written));
    }
}

TEST_CASE("a list that cannot be used is refused by frame and entry", "[layout.frames]")
{
    const auto set = [](std::size_t frame, const char* key, Value value)
    { return [=](const WrittenRecording& it) { it.set_in_frame(list, frame, key, value); }; };
    check_flaws(
        layout,
        {{removing("frames.json"), {"frames.json"}},
         {writing("frames.json", "{}"), {"frames.json: frames: missing"}},
         {set(2, "lens", 1), {"frames.json: frames[2]: unknown entry 'lens'"}},
         {replacing("frames.json", "\"fx\"", "\"k1\": 0.1, \"fx\""), {"frames.json: frames[0].color_camera: unknown entry 'k1'"}},
         {replacing("frames.json", "\"depth_unit_m\"", "\"unit\""), {"frames[0]: unknown entry 'unit'"}},
         {set(1, "name", "a/b"), {"frames[1].name: \"a/b\" cannot be part of a file's name"}},
         {set(1, "name", "frame-000000"), {"frames[1]: seq-01/frame-000000 appears twice"}},
         {set(1, "number", "1"), {"frames[1].number: "}},
         {set(1, "depth_unit_m", 1000), {"frames[1].depth_unit_m: expected meters per step"}},
         {set(1, "color_picture", Value::Map{{"ref", "a.png"}}), {"frames[1].color_picture: reference \"a.png\""}},
         {set(1, "color_picture", Value::Map{{"ref", "own:pictures/../../a.png"}}),
          {"frames[1].color_picture: reference \"own:pictures/../../a.png\" leads out of its folder: use \"file:\""}},
         {set(1, "color_picture", Value()), {"frame 1: \"color_picture\" is null"}},
         {set(1, "color_picture", Value::Map{{"ref", "own:pictures/frame-000000.color.png"}, {"hash", "00"}}),
          {"frame-000000.color.png: its contents differ from the hash in"}}});
}
