#pragma once

#include "written_recording.h"

#include <fresco/mesh.h>
#include <fresco/random.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glob.h>
#include <ranges>
#include <span>
#include <string>
#include <vector>

/// \file What every layout must hold.

namespace fresco::testing
{

/// A mesh of `faces` triangles, at most 2, as a PLY file.
inline void write_mesh(const fs::path& file, std::size_t faces = 1, float size = 1)
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {size, size, 0}};
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
    mesh.triangles.resize(faces);
    fs::create_directories(file.parent_path());
    write_file(file, to_ply(mesh));
}

/// Checks that a recording without a mesh gives its frames and leaves the mesh out, with a warning that names what was
/// `expected`.
inline void check_no_mesh(const WrittenRecording& recording, const std::string& expected, const Value& options = Value::Map{})
{
    TestRun run;
    const auto found = recording.read(run, options);
    CHECK(found.mesh == nullptr);
    CHECK_FALSE(found.frames->frames.empty());
    REQUIRE_FALSE(run.messages.empty());
    CHECK_THAT(run.messages.front(), Catch::Contains("warning: there is no mesh; expected") && Catch::Contains(expected) &&
                                         Catch::Contains(", or set option \"mesh\". mesh.fuse makes one"));
}

/// Cuts each of `files` at 40 places, changes a byte at 100 others, and reads it each time. It must throw fresco::Error,
/// or give frames that can be used: of a cut file, nothing but frames of the whole recording, and its mesh.
inline void check_damage(const WrittenRecording& recording, const std::vector<fs::path>& files,
                         const Value& options = Value::Map{})
{
    const auto read = [&]
    {
        TestRun run(1);
        return recording.read(run, options, false);
    };
    const auto whole = read();
    REQUIRE_FALSE(whole.frames->frames.empty());
    for (const auto& file : files)
    {
        const auto good = read_file(recording.at(file));
        const auto attempt = [&](std::span<const std::byte> bytes, bool is_cut)
        {
            // write_file would wait for the disk each time.
            std::ofstream(recording.at(file), std::ios::binary)
                .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
            try
            {
                const auto found = read();
                for (const Frame& frame : found.frames->frames)
                {
                    const auto is_same = [&](const Frame& other)
                    { return frame.name == other.name && frame.color == other.color && frame.depth == other.depth; };
                    CHECK((!is_cut || std::ranges::any_of(whole.frames->frames, is_same)));
                    check_camera(frame.color, frame.name);
                    check_camera(frame.depth, frame.name);
                    load_color(frame, &recording.images);
                    if (!frame.depth_picture.empty())
                        load_depth(frame, &recording.images);
                }
                if (whole.mesh && is_cut)
                    CHECK(found.mesh->positions == whole.mesh->positions);
            }
            catch (const Error& error)
            {
                CHECK(std::strlen(error.what()) > 10);
            }
        };
        for (std::size_t i = 0; i < 40; ++i)
        {
            INFO(file << " cut to " << i << " 40ths");
            attempt(std::span(good).first(i * good.size() / 40), true);
        }
        Random random(7);
        for (int i = 0; i < 100; ++i)
        {
            auto changed = good;
            const auto at = static_cast<std::size_t>(random.below(std::ssize(changed)));
            changed[at] ^= static_cast<std::byte>(1 + random.below(255));
            INFO(file << " changed at byte " << at);
            attempt(changed, false);
        }
        write_file(recording.at(file), good);
    }
}

/// A recording with something wrong, and what the error says.
struct Flaw
{
    std::function<void(WrittenRecording&)> make;
    std::vector<std::string> said;
};

/// One flaw: a file rewritten, a part of it replaced, a file or folder removed. Paths are below the recording's.
inline std::function<void(WrittenRecording&)> writing(const fs::path& file, const std::string& text)
{
    return [=](WrittenRecording& it) { it.write(file, text); };
}
inline std::function<void(WrittenRecording&)> replacing(const fs::path& file, const std::string& from, const std::string& to)
{
    return [=](WrittenRecording& it) { it.replace(file, from, to); };
}
inline std::function<void(WrittenRecording&)> removing(const fs::path& file)
{
    return [=](WrittenRecording& it) { it.remove(file); };
}

/// Checks that each flaw, made in a recording of its own, is refused with an error that says what it should.
inline void check_flaws(const LayoutUnderTest& layout, const std::vector<Flaw>& flaws, const Value& options = Value::Map{})
{
    for (const auto& flaw : flaws)
    {
        WrittenRecording recording(layout);
        flaw.make(recording);
        const auto error = recording.error(options);
        INFO(flaw.said.front());
        for (const auto& said : flaw.said)
            CHECK_THAT(error, Catch::Contains(said));
    }
}

/// Flaws of the pictures of the second view.
inline std::vector<Flaw> picture_flaws(const LayoutUnderTest& layout)
{
    const std::string color = layout.color.filename().string(), depth = layout.depth.filename().string();
    const auto cut = [](const fs::path& file) { fs::resize_file(file, file_size(file) - 1); };
    const auto with = [](const fs::path& file, const auto& picture)
    { return [file, picture](WrittenRecording& it) { write_file(it.path / file, it.images.encode_png(picture)); }; };
    return {{removing(layout.color), {color, "1 file is missing"}},
            {removing(layout.may_lack_depth ? layout.color : layout.depth),
             {layout.may_lack_depth ? color : depth, "1 file is missing"}},
            {[=](auto& it) { cut(it.path / layout.color); }, {color + ": "}},
            {[=](auto& it) { cut(it.path / layout.depth); }, {depth + ": "}},
            {with(layout.color, Raster8(24, 32, 3)), {color + ": the picture is 24x32", "32x24"}},
            {with(layout.depth, Raster16(12, 16)), {depth + ": the ", "picture is 12x16"}},
            {with(layout.depth, Raster8(16, 12)), {depth + ": expected a depth picture", "8 bits"}},
            {with(layout.depth, Raster16(16, 12, 3)), {depth + ": expected a depth picture", "colors"}}};
}

/// The files and folders below the recording's that an entry of its layout's marks names.
inline std::vector<fs::path> found_entries(const fs::path& folder, const std::string& entry)
{
    std::vector<fs::path> found;
    for (const auto name : std::views::split(entry, '|'))
    {
        const std::string pattern = (folder / std::string_view(name.begin(), name.end())).string();
        ::glob_t paths{};
        ::glob(pattern.c_str(), 0, nullptr, &paths);
        found.insert(found.end(), paths.gl_pathv, paths.gl_pathv + paths.gl_pathc);
        ::globfree(&paths);
    }
    return found;
}

/// Checks the marks that a layout of folders declares: entries that the recording has, and without which it is refused.
inline void check_marks(const LayoutUnderTest& layout)
{
    const auto marks = make_from_plugin<recordings::Layout>(layout.plugin, layout.type)->marks();
    CHECK((!marks.contains.empty() || !marks.formats.empty()));
    for (const std::string& entry : marks.contains)
    {
        INFO(entry);
        const WrittenRecording recording(layout);
        const auto found = found_entries(recording.path, entry);
        CHECK_FALSE(found.empty());
        for (const auto& file : found)
            fs::remove_all(file);
        CHECK(recording.error() != "no error");
    }
}

/// Everything that each layout must hold.
inline void check_layout(const LayoutUnderTest& layout)
{
    check_marks(layout);
    {
        const WrittenRecording recording(layout);
        TestRun run(1);
        const auto result = recording.read(run);
        const auto& frames = result.frames->frames;
        check_same_recording(*result.frames, recording.frames, recording.images, layout.depth_step_m);
        CHECK(run.reported.at("frames").as_int() == 3);
        CHECK(run.reported.at("has_depth").as_bool());
        if (!layout.third.empty())
            CHECK(frames.at(2).sequence + " " + frames[2].name + " " + std::to_string(frames[2].number) == layout.third);
        CHECK((result.mesh ? result.mesh->triangles.size() : 0) == layout.mesh_faces);
        if (layout.files_read > 0)
            CHECK(run.files_read.size() == layout.files_read);

        // Files that systems leave beside a recorder's change nothing.
        std::vector<fs::path> files;
        if (fs::is_directory(recording.path))
            for (const auto& entry : fs::recursive_directory_iterator(recording.path))
                if (entry.is_regular_file())
                    files.push_back(entry.path());
        for (const auto& file : files)
            for (const auto& name : {"._" + file.filename().string(), std::string(".DS_Store")})
                write_file(file.parent_path() / name, std::string_view("Mac OS X"));

        const auto text = read_text_file(recording.out() / "frames/frames.json");
        recording.read();
        CHECK(read_text_file(recording.out() / "frames/frames.json") == text);
        const auto scaled = recording.read(Value::Map{{"unit_m", 2.0}, {"depth_unit_m", 0.004}}).frames->frames[1];
        CHECK(scaled.color.world_from_camera.translation == frames[1].color.world_from_camera.translation * 2);
        CHECK(scaled.depth.world_from_camera.translation == frames[1].depth.world_from_camera.translation * 2);
        CHECK(scaled.depth_unit_m == 0.004);
        TestRun second;
        const auto chosen = recording.read(second, Value::Map{{"every", 2}}).frames->frames;
        REQUIRE(chosen.size() == 2);
        CHECK(chosen[1].name == frames[2].name);
        CHECK(chosen[1].number == frames[2].number);
        const auto count = [](const TestRun& of, const fs::path& file) {
            return std::ranges::count(of.files_read, file.lexically_normal(), [](const auto& f) { return f.lexically_normal(); });
        };
        for (const auto& file : {layout.color, layout.depth})
            if (!file.empty())
            {
                CHECK(count(run, recording.path / file) == 1);
                CHECK(count(second, recording.path / file) == 0);
            }

        TestRun stopped;
        stopped.cancel_after(2);
        CHECK_THROWS_AS(recording.read(stopped), Canceled);
    }
    {
        WrittenRecording empty(layout);
        const bool is_file = fs::is_regular_file(empty.path);
        fs::remove_all(empty.path);
        if (is_file)
            write_file(empty.path, "");
        else
            fs::create_directory(empty.path);
        CHECK_THAT(empty.error(), Catch::Contains(empty.path.string()));
        if (!is_file)
            CHECK_THROWS_AS(empty.read(), MissingInput);
    }
    {
        WrittenRecording turned(layout);
        turned.images.orientation = 6;
        CHECK_THAT(turned.error(), Catch::Contains("its EXIF data rotates it (orientation 6)"));
    }
    const std::vector<std::pair<std::string, std::function<void(Frame&)>>> edits{
        {"rotation", [](Frame& frame) { frame.color.world_from_camera.rotation.m[0] += 0.5; }},
        {"more than 1e7 m", [](Frame& frame) { frame.color.world_from_camera.translation.y = -2e7; }}};
    for (const auto& [said, edit] : edits)
    {
        const WrittenRecording posed(layout,
                                     [&](Frames& frames)
                                     {
                                         edit(frames.frames[1]);
                                         frames.frames[1].depth.world_from_camera = frames.frames[1].color.world_from_camera;
                                     });
        CHECK_THAT(posed.error(), Catch::Contains(said) && Catch::Contains(layout.pose_source));
    }
    const WrittenRecording outside(layout,
                                   [](Frames& frames)
                                   {
                                       for (auto& frame : frames.frames)
                                           frame.color.intrinsics.cx = 640;
                                   });
    CHECK_THAT(outside.error(), Catch::Contains("the principal point (640.0, 12.5) is outside"));
    if (!layout.color.empty())
    {
        WrittenRecording missing(layout);
        missing.remove(layout.color);
        CHECK_THROWS_AS(missing.read(), MissingInput);
        check_flaws(layout, picture_flaws(layout));
    }
    auto files = layout.damaged;
    for (const auto& picture : {layout.color, layout.depth})
        if (!picture.empty())
            files.push_back(picture);
    check_damage(WrittenRecording(layout), files);
}

}  // namespace fresco::testing
