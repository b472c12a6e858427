#include "catch.h"
#include "raw_images.h"
#include "recording_checks.h"

#include <fresco/recordings/recorded_view.h>
#include <fresco/testing.h>

namespace fs = std::filesystem;
using namespace fresco::recordings;
using namespace fresco::testing;

namespace
{

struct Recording
{
    TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = tiny_recording(folder.path(), images);
    std::vector<RecordedView> views;

    Recording()
    {
        for (const auto& frame : frames.frames)
        {
            RecordedView view;
            name_by_picture(view, "run/" + frame.name + ".png");
            view.number = frame.number;
            view.color = frame.color_picture.path;
            view.depth = frame.depth_picture.path;
            view.camera = frame.color.intrinsics;
            view.world_from_camera = frame.color.world_from_camera;
            view.source = "list.txt:" + std::to_string(view.number + 1);
            views.push_back(std::move(view));
        }
    }

    fresco::Frames read(int threads = 2) const
    {
        TestRun run(threads);
        return recorded_frames(views, images, folder.path() / "out", run);
    }
    std::string error() const
    {
        return error_of([&] { read(); });
    }
};

}  // namespace

TEST_CASE("views with a lens get pictures of their own, the same for any thread count", "[recordings]")
{
    Recording recording;
    for (auto& view : recording.views)
        view.lens = {.k1 = 0.1};
    const auto read = recording.read();
    const auto out = recording.folder.path() / "out/run";
    CHECK(read.frames[2].color_picture.path == out / "frame-000002.color.jpg");
    CHECK(read.frames[2].depth_picture.path == out / "frame-000002.depth.png");
    const auto pinhole = pinhole_without({.k1 = 0.1}, recording.views[0].camera, "x");
    CHECK(pinhole.fx > recording.views[0].camera.fx);
    CHECK(read.frames[2].color.intrinsics == pinhole);
    CHECK(read.frames[2].depth.intrinsics == pinhole.scaled_to(16, 12));
    const auto expected = undistorted(fresco::load_color(recording.frames.frames[2], &recording.images),
                                      recording.views[2].camera, {.k1 = 0.1}, pinhole);
    CHECK(fresco::load_color(read.frames[2], &recording.images) == expected);
    const auto bytes = fresco::read_file(out / "frame-000001.depth.png");
    fs::remove_all(out);
    recording.read(1);
    CHECK(fresco::read_file(out / "frame-000001.depth.png") == bytes);
}

TEST_CASE("what a mask or transparency ignores is neither color nor depth, with a lens and without", "[recordings]")
{
    for (const bool by_alpha : {false, true})
        for (const double k1 : {0.0, 0.1})
        {
            CAPTURE(by_alpha, k1);
            Recording recording;
            const auto plain = recording.read();
            auto& view = recording.views[1];
            view.lens = {.k1 = k1};
            const auto file = by_alpha ? view.color : recording.folder.path() / "mask.png";
            const fresco::Raster8 rgb = recording.images.read_rgb(view.color);
            // The left half of the mask is black, some of the rest not quite; or the picture's left half has this alpha.
            const auto write = [&](int at_left)
            {
                fresco::Raster8 picture(32, 24, 4, 255);
                fresco::Raster8 mask(32, 24, 3, 255);
                for (int y = 0; y < 24; ++y)
                    for (int x = 0; x < 32; ++x)
                    {
                        for (int c = 0; c < 3; ++c)
                        {
                            picture.at(x, y, c) = rgb.at(x, y, c);
                            mask.at(x, y, c) = static_cast<std::uint8_t>(x < 16 ? at_left : x == 20 ? 1 : 255);
                        }
                        picture.at(x, y, 3) = static_cast<std::uint8_t>(x < 16 ? at_left : 255);
                    }
                fresco::write_file(file, recording.images.encode_png(by_alpha ? picture : mask));
            };
            if (!by_alpha)
                view.mask = file;
            write(by_alpha ? 249 : 0);
            TestRun run;
            std::size_t transparent = 0;
            const auto read =
                recorded_frames(recording.views, recording.images, recording.folder.path() / "out", run, {}, &transparent);
            CHECK(transparent == (by_alpha ? 1 : 0));
            CHECK(read.frames[0].mask.empty());
            const auto& frame = read.frames[1];
            CHECK(frame.mask.path == recording.folder.path() / "out/run/frame-000001.mask.npy");
            const auto kept = fresco::load_mask(frame);
            const auto depth = fresco::load_depth(frame, &recording.images);
            for (int y = 0; y < 12; ++y)
                for (int x = 0; x < 16; ++x)
                    // A lens moves the border off the pixels of depth.
                    if (k1 == 0 || x < 6 || x > 8)
                    {
                        CHECK((kept.at(2 * x, 2 * y) == 0) == (x < 8));
                        CHECK((depth.at(x, y) == 0) == (x < 8));
                    }
            CHECK(fresco::load_color(frame, &recording.images).channels == 3);
            if (k1 == 0)
                CHECK(frame.color_picture.path == view.color);
            // A mask that ignores nothing, or alpha that hides nothing, changes nothing.
            write(by_alpha ? 250 : 255);
            const auto whole = recording.read().frames[1];
            CHECK(whole.mask.empty());
            if (k1 == 0)
                CHECK(whole.depth_picture.path == plain.frames[1].depth_picture.path);
        }
}

TEST_CASE("masks and transparent pictures that cannot be used are refused, also by load_color", "[recordings]")
{
    Recording recording;
    auto& view = recording.views[1];
    const auto mask = recording.folder.path() / "mask.npy", picture = recording.folder.path() / "mask.png";
    const auto opaque = fresco::read_file(view.color);
    fresco::Raster8 rgba(32, 24, 4, 255);
    rgba.at(3, 2, 3) = 0;
    fresco::write_file(view.color, recording.images.encode_png(rgba));
    fresco::Frame frame = recording.read().frames[1];
    // Neither no mask nor one of its own shows what is transparent.
    fresco::write_npy(mask, fresco::Raster8(32, 24, 1, 255));
    for (const auto& given : {fresco::PictureFile{}, fresco::PictureFile{mask, ""}})
    {
        frame.mask = given;
        CHECK_THROWS_WITH(fresco::load_color(frame, &recording.images),
                          Contains(view.color.string()) && Contains("transparent pixels") && Contains("scan.recording"));
    }
    view.mask = mask;
    CHECK(fresco::load_mask(recording.read().frames[1]).at(3, 2) == 0);
    fresco::write_file(view.color, recording.images.encode_png(fresco::Raster8(32, 24, 4, 249)));
    CHECK(recording.error() == view.color.string() + ": is transparent everywhere; save it without an alpha channel");
    fresco::write_file(view.color, opaque);
    view.mask = picture;
    fresco::write_file(picture, recording.images.encode_png(fresco::Raster8(32, 24, 4, 0)));
    CHECK_THAT(recording.error(), Contains("mask.png: the mask has transparent pixels"));
    fresco::write_file(picture, recording.images.encode_png(fresco::Raster8(16, 12, 3, 255)));
    CHECK_THAT(recording.error(), Contains("mask.png: the mask is 16x12; the picture of list.txt:") && Contains("is 32x24"));
}

TEST_CASE("a panorama gives six frames, with depth and masks", "[recordings]")
{
    Recording recording;
    make_panoramas(recording.frames, recording.images);
    for (auto& view : recording.views)
    {
        view.is_panorama = true;
        view.camera = {.width = 64, .height = 32};
    }
    const auto read = recording.read();
    check_panoramas(read, recording.frames, recording.images);
    const auto out = recording.folder.path() / "out";
    CHECK(read.frames[16].color_picture.path == out / "run_down/frame-000001.color.jpg");
    CHECK(read.frames[16].mask.empty());

    // The quarter to the right is ignored.
    fresco::Raster8 mask(64, 32, 3, 255);
    for (int y = 0; y < 32; ++y)
        for (int x = 41; x < 55; ++x)
            for (int c = 0; c < 3; ++c)
                mask.at(x, y, c) = 0;
    const auto file = recording.folder.path() / "mask.png";
    fresco::write_file(file, recording.images.encode_png(mask));
    recording.views[1].mask = file;
    const auto masked = recording.read();
    const auto right = fresco::load_mask(masked.frames[4]);
    // Its first two columns see columns 39 and 40, the third a part of column 41.
    CHECK((right.at(11, 11) == 0 && right.at(2, 11) == 0 && right.at(1, 11) == 255));
    for (const std::size_t unmasked : {1U, 3U, 7U, 10U})
        CHECK(masked.frames[unmasked].mask.empty());
    // Up, what lies to the right of the pole is ignored.
    const auto up = fresco::load_mask(masked.frames[13]);
    CHECK((up.at(20, 11) == 0 && up.at(2, 11) == 255));
    const auto steps = fresco::load_depth_steps(masked.frames[4], &recording.images);
    CHECK((steps.at(5, 5) == 0 && steps.at(0, 5) > 0));
    CHECK(fresco::load_depth_steps(masked.frames[1], &recording.images).at(5, 5) > 0);

    fresco::write_file(recording.views[1].depth, recording.images.encode_png(fresco::Raster16(32, 24)));
    CHECK_THAT(recording.error(), Contains("frame-000001.depth.png: 32x24 pixels; a 360° picture"));
    recording.views[0].sequence = "run_left";
    recording.views[0].name = "frame-000001";
    recording.views[0].is_panorama = false;
    CHECK_THAT(recording.error(), Contains("list.txt:2: the view run_left/frame-000001 appears twice, first at list.txt:1"));
}

TEST_CASE("views are named and ordered by their pictures", "[recordings]")
{
    std::vector<RecordedView> views(4);
    const char* const names[] = {"a/f10.jpg", "./a/f9.jpg", "../b x/.f1.png", "f3.png"};
    for (std::size_t i = 0; i < 4; ++i)
        name_by_picture(views[i], names[i]);
    order_by_name(views);
    const auto shown = [&](std::size_t i)
    { return views[i].sequence + "/" + views[i].name + "/" + std::to_string(views[i].number); };
    CHECK(shown(0) == "_._b_x/_f1/1");
    CHECK(shown(1) == "a/f9/9");
    CHECK(shown(2) == "a/f10/10");
    CHECK(shown(3) == "scan/f3/3");
    // Numbers that are not unique in a sequence count for none.
    name_by_picture(views[3], "a/g9.png");
    order_by_name(views);
    CHECK(shown(3) == "a/g9/3");
}

// check_layout shows the other refusals, for every layout.
TEST_CASE("views that cannot be used are refused by name", "[recordings]")
{
    Recording recording;
    recording.views[1].camera.width = 640;
    CHECK_THAT(recording.error(), Contains("frame-000001.color.png: ") && Contains("(list.txt:2) is for pictures of 640x24"));
    recording.views[1].camera.width = 32;
    fresco::write_file(recording.views[1].depth, recording.images.encode_png(fresco::Raster16(12, 16)));
    CHECK_THAT(recording.error(), Contains("frame-000001.depth.png: ") && Contains("list.txt:2 is 32x24"));
    // A pixel is left to rounding.
    fresco::write_file(recording.views[1].depth, recording.images.encode_png(fresco::Raster16(10, 7)));
    CHECK(recording.error().empty());
}
