#include "report_parts.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/numerics/greedy_cover.h>
#include <fresco/page/page.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/viewer.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <string>

using namespace fresco;

namespace
{

template <class T>
class ViewerOf : public Viewer
{
  public:
    ViewerOf() : Viewer(RegisteredArtifact<T>::type) {}
    void show(const Artifact& artifact, PageEntry& entry) const final { show_value(dynamic_cast<const T&>(artifact), entry); }

  protected:
    virtual void show_value(const T& value, PageEntry& entry) const = 0;
    Slot<ImageIo> images{this, "Reads and encodes pictures"};
};

class ImageViewer final : public ViewerOf<Image>
{
    void show_value(const Image& image, PageEntry& entry) const override
    {
        if (!image.pixels.empty())
            page::add_picture(entry, *images, "", image.pixels);
    }
};

class FilesViewer final : public ViewerOf<Files>
{
    std::vector<std::string> extensions() const override { return all_extensions(picture_formats()); }

    void show_value(const Files& files, PageEntry& entry) const override
    {
        // A file that cannot be shown does not hide the others.
        const auto attempt = [&](auto act)
        {
            try
            {
                act();
            }
            catch (const Error& error)
            {
                entry.note(error.what());
            }
        };
        const auto is_in = [](const auto& list, const std::string& name) { return std::ranges::find(list, name) != list.end(); };
        std::vector<std::string> pictures;
        std::ranges::copy_if(files.names, std::back_inserter(pictures),
                             [&](const std::string& name) {
                                 return entry.names.empty() ? is_in(extensions(), lower_extension(name))
                                                            : is_in(entry.names, name);
                             });
        for (const std::size_t i : numerics::evenly_spread(std::min(entry.most_pictures, pictures.size()), pictures.size()))
            attempt([&] { page::add_picture(entry, *images, pictures[i], images->read_rgb(files.loaded_from / pictures[i])); });
        if (entry.names.empty())
            for (const std::string& name : files.names)
                if (is_in(std::vector<std::string>{".mp4", ".webm"}, lower_extension(name)))
                    attempt([&] { page::add_video(entry, name, files.loaded_from / name); });
    }
};

/// Draws the slider between camera pictures and renders.
constexpr PageScripts views_scripts{.css = views_css, .js = views_js};

/// Draws the room, and the controls around it.
const PageScripts& room_and_controls()
{
    static const PageScripts& room = page::room_scripts();
    static const std::string css = std::string(room.css) + room_css;
    static const std::string js = std::string(room.js) + room_js;
    static const PageScripts all{.css = css, .library = room.library, .js = js};
    return all;
}

class FramesViewer final : public ViewerOf<Frames>
{
    void show_value(const Frames& frames, PageEntry& entry) const override
    {
        std::map<std::string, const Frame*> recorded;
        for (const Frame& frame : frames.frames)
            if (!frame.color_picture.empty())
                recorded.emplace(frame.sequence + "_" + frame.name, &frame);
        std::vector<const Frame*> shown;
        for (const std::string& name : entry.names)
            if (const auto found = recorded.find(std::filesystem::path(name).stem().string()); found != recorded.end())
            {
                shown.push_back(found->second);
                recorded.erase(found);  // Several stages may have made pictures of it.
            }
        if (frames.frames.empty() || (shown.empty() && !entry.last))
            return;
        entry.value.set("cameras", page::cameras(frames));
        entry.scripts = &views_scripts;
        for (const Frame* frame : shown)
            page::add_picture(entry, *images, frame->sequence + "_" + frame->name, load_color(*frame, &*images),
                              {{"pose", page::pose(frame->color)}});
    }
};

class TexturedMeshViewer final : public ViewerOf<TexturedMesh>
{
    void show_value(const TexturedMesh& room, PageEntry& entry) const override
    {
        constexpr std::size_t most_triangles = 800'000;  // About 11 MB in the page.
        constexpr int texture_px = 2048;
        constexpr int texture_quality = 88;
        if (!entry.last)
            return;
        const Raster8& pixels = room.image.pixels;
        page::add_picture(entry, *images, fmt::format("{} × {} texels", pixels.width, pixels.height), pixels,
                          {{"section", "The atlas"}});
        check_mesh(room.mesh, "the room");
        if (room.mesh.texcoords.empty())
            throw Error("the room has no texcoords");
        if (room.mesh.triangles.size() > most_triangles)
            throw Error(fmt::format(
                "the room has {} faces, the page takes {} at most: open the exported file, or decimate the mesh further",
                room.mesh.triangles.size(), most_triangles));
        entry.value.set("room",
                        page::room(room.mesh, images->encode_jpeg(page::small_copy(pixels, texture_px), texture_quality)));
        entry.scripts = &room_and_controls();
    }
};

}  // namespace

FRESCO_COMPONENT("view.image", ImageViewer, Viewer, "Shows a picture in the report")
FRESCO_COMPONENT("view.files", FilesViewer, Viewer, "Shows pictures and videos among files in the report")
FRESCO_COMPONENT("view.frames", FramesViewer, Viewer, "Shows what the cameras saw in the report")
FRESCO_COMPONENT("view.textured_mesh", TexturedMeshViewer, Viewer, "Shows the atlas and the room in the report")
