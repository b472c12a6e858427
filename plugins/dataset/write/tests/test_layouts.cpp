#include "catch.h"
#include "small_recording.h"
#include "stylemesh_layout.h"
#include "view_writer.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/value.h>

#include <cmath>
#include <iterator>
#include <set>
#include <sstream>

using namespace fresco;
namespace fs = std::filesystem;

TEST_CASE_METHOD(Recorded, "with pictures, transforms.json tells nerfstudio's world of the same cameras")
{
    // A quarter turn about z: columns of the camera's axes that are easy to distinguish.
    recording.frames->frames[1].color.world_from_camera.rotation.m = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    recording.maps->views[1].camera = recording.frames->frames[1].color;
    const auto names = recording.write(Value::Map{{"pictures", true}});
    const fs::path made = recording.out / "files/dataset";
    CHECK(std::ranges::count(names, "dataset/images/000001.png") == 1);
    const Value root = parse_json(read_text_file(made / "transforms.json"));
    CHECK(root.at("depth_unit_scale_factor").as_double() == 0.001);
    const auto& frames = root.at("frames").as_list();
    REQUIRE(frames.size() == 3);
    const Value& frame = frames[1];
    CHECK(frame.at("file_path").as_string() == "images/000001.png");
    CHECK(frame.at("fl_y").as_double() == 34);
    // OpenCV's x stays, y and z change their signs.
    const Value expected = Value::List{Value::List{0.0, 1.0, 0.0, 0.1}, Value::List{1.0, 0.0, 0.0, 1.0 / 3},
                                       Value::List{0.0, 0.0, -1.0, -2.0}, Value::List{0.0, 0.0, 0.0, 1.0}};
    CHECK(frame.at("transform_matrix") == expected);
    CHECK(dataset::raster_from<std::uint8_t>(read_file(made / "images/000001.png"), 40, 30, 3, "picture") ==
          load_color(recording.frames->frames[1], nullptr));
    // Depth of the mesh at the largest height, in the color camera, millimeters.
    const UvMap map = recording.maps->load_map(1, 1);
    const Raster16 depth =
        dataset::raster_from<std::uint16_t>(read_file(made / frame.at("depth_file_path").as_string()), 60, 45, 1, "depth");
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        CHECK(depth.values[i] == std::lround(1000 * map.depth.values[i]));
}

TEST_CASE("pictures that are JPEG or 8-bit RGB already are copied byte for byte, others are converted")
{
    const testing::TemporaryFolder folder;
    Frame frame;
    frame.color_picture.path = folder.path() / "a.JPEG";
    write_file(frame.color_picture.path, "\xFFthe recorder's own bytes");
    const testing::RawImages codec;
    const EncodedPicture copied = encoded_color(frame, Raster8(2, 2, 3), codec);
    CHECK(copied.extension == ".jpg");
    CHECK(copied.bytes == read_file(frame.color_picture.path));
    CHECK(codec.encoded == 0);
    // A PNG's header: 13 bytes of IHDR, of which the ninth and tenth are bits and kind of color.
    const auto png = [](char bits, char kind)
    { return "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\rIHDR\0\0\0\2\0\0\0\2", 16) + bits + kind + std::string(3, '\0'); };
    const auto jpeg = frame.color_picture.path;
    frame.color_picture.path = folder.path() / "a.png";
    write_file(frame.color_picture.path, png(8, 2));
    CHECK(encoded_color(frame, Raster8(2, 2, 3), codec).bytes == read_file(frame.color_picture.path));
    CHECK(codec.encoded == 0);
    // 16 bits, gray, a palette and RGBA are not what readers of a dataset expect.
    for (const auto& [bits, kind] : {std::pair<char, char>{16, 2}, {8, 0}, {8, 3}, {8, 6}})
    {
        write_file(frame.color_picture.path, png(bits, kind));
        CHECK(encoded_color(frame, Raster8(2, 2, 3, 7), codec).bytes == dataset::to_npy(Raster8(2, 2, 3, 7)));
    }
    frame.color_picture.path = jpeg;
    write_file(jpeg, "RIFF....WEBP");
    CHECK(encoded_color(frame, Raster8(2, 2, 3, 7), codec).extension == ".png");
    frame.color_picture.hash = content_hash("others");
    CHECK_THROWS_WITH(encoded_color(frame, Raster8(2, 2, 3), codec), Contains("a.JPEG: the file changed while it was read"));
    RasterF depth(4, 1);
    depth.values = {0, 1.2344F, 65.534F, 65.536F};
    CHECK(dataset::raster_from<std::uint16_t>(encoded_depth(depth, codec), 4, 1, 1, "depth").values ==
          std::vector<std::uint16_t>{0, 1234, 65534, 0});
}

TEST_CASE_METHOD(Recorded, "layout stylemesh has the folders that the released code lists, with equally many files in each")
{
    const auto names = recording.write(Value::Map{{"layout", "stylemesh"}, {"path", "data"}});
    CHECK(names.back() == "data/manifest.json");
    const fs::path root = recording.out / "files/data";
    const fs::path scene = root / "train/images/scene0000_00";
    // Files are named by the recorder's numbers; the released code lists each folder.
    std::set<std::string> expected{"scene0000_00.txt"};
    for (const std::string number : {"0", "10", "20"})
        for (const char* file : {"color/%.png", "pose/%.txt", "depth/%.png", "uv/%.angle.npy", "uv_12/%.npy", "uv_45/%.npy"})
            expected.insert(std::string(file).replace(std::string(file).find('%'), 1, number));
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(scene))
        if (entry.is_regular_file())
            found.insert(fs::relative(entry.path(), scene).string());
    CHECK(found == expected);

    const UvMap coarse = recording.maps->load_map(1, 0);
    const UvMap fine = recording.maps->load_map(1, 1);
    const RasterF uv = dataset::raster_from<float>(read_file(scene / "uv_45/10.npy"), 60, 45, 2, "uv");
    for (std::size_t i = 0; i < fine.valid.values.size(); ++i)
    {
        const bool seen = fine.valid.values[i] != 0;
        CHECK(uv.values[2 * i] == fine.uv.values[2 * i]);
        CHECK(uv.values[2 * i + 1] == (seen ? 1 - fine.uv.values[2 * i + 1] : 0));
    }
    const NpyArray angle = read_npy(scene / "uv/10.angle.npy");
    CHECK(angle.shape == std::vector<std::size_t>{12, 16, 1});
    CHECK(std::ranges::equal(angle.as<float>(), coarse.cosine.values));
    // The last frame has no depth picture: all have the mesh's depth, at the smallest height.
    const Raster16 depth = dataset::raster_from<std::uint16_t>(read_file(scene / "depth/10.png"), 16, 12, 1, "depth");
    CHECK(depth.at(8, 5) == std::lround(1000 * coarse.depth.at(8, 5)));
    std::istringstream pose(read_text_file(scene / "pose/10.txt"));
    CHECK(std::vector<double>(std::istream_iterator<double>(pose), {}) ==
          std::vector<double>{1, 0, 0, 0.1, 0, 1, 0, 1.0 / 3, 0, 0, 1, -2, 0, 0, 0, 1});
    const std::string intrinsics = read_text_file(scene / "scene0000_00.txt");
    CHECK_THAT(intrinsics, Contains("fx_color = 33.25\n") && Contains("my_color = 15.5\n") && Contains("colorWidth = 40\n") &&
                               Contains("depthHeight = 14\n"));
    CHECK(read_text_file(root / "train/scans/scene0000_00/scene0000_00.txt") == intrinsics);
    const Mesh mesh = read_mesh(root / "train/scans/scene0000_00/scene0000_00_vh_clean_decimate_500000_uvs_blender.ply");
    CHECK(mesh.texcoords == recording.mesh->texcoords);
    for (std::size_t corner = 0; corner < 6; ++corner)
        CHECK(mesh.positions[mesh.triangles.at(corner / 3)[corner % 3]] ==
              recording.mesh->positions[recording.mesh->triangles[corner / 3][corner % 3]]);
    const Value manifest = parse_json(read_text_file(root / "manifest.json"));
    CHECK(manifest.at("files").as_list().size() == names.size() - 1);
    CHECK(manifest.at("views").as_list()[2].at("number").as_int() == 20);
}

TEST_CASE_METHOD(Recorded,
                 "layout stylemesh takes the sensor's depth where every frame has it, and positions where numbers repeat")
{
    recording.frames->frames.pop_back();
    recording.maps->views.pop_back();
    recording.frames->frames[1].number = 0;
    recording.write(Value::Map{{"layout", "stylemesh"}, {"scene", "kitchen_1"}});
    const fs::path scene = recording.out / "files/dataset/train/images/kitchen_1";
    CHECK(fs::exists(scene / "color/1.png"));
    const Raster16 depth = dataset::raster_from<std::uint16_t>(read_file(scene / "depth/1.png"), 320, 240, 1, "depth");
    const Raster16 steps = load_depth_steps(recording.frames->frames[1], nullptr);
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x)
        {
            const int step = steps.at(x * 20 / 320, y * 14 / 240);
            // Two millimeters a step.
            CHECK(depth.at(x, y) == (step > 32767 ? 0 : 2 * step));
        }
}

TEST_CASE_METHOD(Recorded, "layout stylemesh refuses what it has no place for")
{
    for (const char* scene : {"kitchen", "a_b_c", "_a", "a_", "a/b_c"})
        CHECK_THROWS_WITH(recording.write(Value::Map{{"layout", "stylemesh"}, {"scene", scene}}),
                          Contains("expected two parts of letters and digits"));
    recording.frames->frames[2].color.intrinsics.fx += 1;
    recording.maps->views[2].camera = recording.frames->frames[2].color;
    CHECK_THROWS_WITH(recording.write(Value::Map{{"layout", "stylemesh"}}),
                      Contains("seq-01/frame-20 has other color intrinsics than seq-01/frame-0"));
}

TEST_CASE("what an interrupted run had finished is not made again, and the result is the same")
{
    const Value options = Value::Map{{"pictures", true}};
    SmallRecording whole;
    const auto names = whole.write(options);

    SmallRecording recording(1);
    recording.run.cancel_after(3);
    const auto codec = std::make_shared<testing::RawImages>();
    CHECK_THROWS_AS(recording.write(options, codec), Canceled);
    CHECK(codec->encoded == 4);  // two views
    recording.run.cancel_after(-1);
    CHECK(recording.write(options, codec) == names);
    CHECK(codec->encoded == 6);
    CHECK_THAT(recording.run.messages.back(), Contains("2 of 3 views were there from an interrupted run"));
    for (const std::string& name : names)
        CHECK(read_file(whole.out / "files" / name) == read_file(recording.out / "files" / name));

    // Killed while the result was published: nothing is lost.
    fs::remove_all(recording.out / "files");
    CHECK(recording.write(options, codec) == names);
    CHECK(codec->encoded == 6);
    CHECK_THAT(recording.run.messages.back(), Contains("3 of 3 views were there from an interrupted run"));
}
