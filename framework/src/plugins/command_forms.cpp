#include "plugins/command_forms.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/hash.h>
#include <fresco/mesh.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <optional>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

constexpr std::string_view png = "png";

template <class T>
std::shared_ptr<const T> loaded(const ArtifactFolder& stored, const Artifact* value)
{
    if (value == nullptr)
        return T::load(stored);
    const auto* typed = dynamic_cast<const T*>(value);
    if (typed == nullptr)
        throw Error("the reader did not make " + std::string(T::artifact_name));
    // Owned by whoever gave it, for longer than this.
    return {std::shared_ptr<const T>(), typed};
}

const ImageIo& codec(const ImageIo* images)
{
    if (images == nullptr)
        throw Error("no picture codec for 'as: png'; set the option images");
    return *images;
}

void write_picture(const Image& image, const CommandPort& port, const fs::path& folder, const ImageIo* images)
{
    if (port.as == png)
        write_file(folder / "image.png", codec(images).encode_png(image.pixels));
    else
        image.save({folder, {}});
}

Image read_picture(const CommandPort& port, const fs::path& folder, const ImageIo* images)
{
    if (port.as == png)
        return Image(codec(images).read_rgb(folder / "image.png"));
    return std::move(*Image::load({folder, {}}));
}

const char* picture_name(const CommandPort& port)
{
    return port.as == png ? "image.png" : "image.npy";
}

void need_file(const fs::path& file)
{
    if (!fs::is_regular_file(file))
        throw Error(file.string() + " was not written");
}

/// Every file in and below the folder, as names of an export.
void take_files(const ArtifactFolder& published)
{
    Files files;
    for (const auto& entry : fs::recursive_directory_iterator(published.path))
        if (!entry.is_directory())
            files.names.push_back(entry.path().lexically_relative(published.path).generic_string());
    std::sort(files.names.begin(), files.names.end());
    if (files.names.empty())
        throw Error(published.path.string() + ": no file was written into it");
    if (std::find(files.names.begin(), files.names.end(), "files.json") != files.names.end())
        throw Error((published.path / "files.json").string() + ": this name is taken for the list of files; write another");
    files.save(published);
}

/// The path from `folder` to `path`, whichever way each is written; nothing if it is not below.
std::optional<fs::path> below(const fs::path& path, const fs::path& folder)
{
    for (const fs::path& relative :
         {path.lexically_relative(folder), fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(folder))})
        if (!relative.empty() && *relative.begin() != "..")
            return relative;
    return std::nullopt;
}

/// As `published` refers to it. Pictures that are the user's own files are part of what the result was made from.
void take_picture(PictureFile& picture, const ArtifactFolder& published, const std::string& where, RunContext& run)
{
    picture.path = picture.path.lexically_normal();
    if (!fs::is_regular_file(picture.path))
        throw Error(where + ": no such picture: " + picture.path.string());
    if (const auto own = below(picture.path, published.path))
        picture.path = published.path / *own;
    else if (const auto stored = below(picture.path, published.store / "objects"))
        picture.path = published.store / "objects" / *stored;
    else if (below(picture.path, published.store))
        throw Error(where + ": the picture " + picture.path.string() +
                    " will be gone when the program has ended: write it into the folder of this output");
    else
    {
        run.reads_file(picture.path);
        if (picture.hash.empty())
            picture.hash = file_hash(picture.path);
    }
}

void take_frames(const ArtifactFolder& published, RunContext& run)
{
    const fs::path list = published.path / "frames.json";
    need_file(list);
    const auto frames = Frames::load(published);
    if (frames->frames.empty())
        throw Error(list.string() + ": no frames in it");
    for (Frame& frame : frames->frames)
        for (PictureFile* picture : {&frame.color_picture, &frame.depth_picture})
        {
            run.check_canceled();
            if (!picture->empty())
                take_picture(*picture, published, list.string() + ": " + frame.sequence + "/" + frame.name, run);
        }
    frames->save(published);
}

void take_uv_maps(const ArtifactFolder& published, RunContext& run)
{
    need_file(published.path / "uvmaps.json");
    const auto maps = UvMaps::load(published);
    for (std::size_t view = 0; view < maps->views.size(); ++view)
        for (std::size_t level = 0; level < maps->heights_px.size(); ++level)
        {
            run.check_canceled();
            (void)maps->load_map(view, level);
        }
    maps->save(published);
}

}  // namespace

const std::vector<ExchangeForm>& exchange_forms()
{
    static const std::vector<ExchangeForm> forms{{Mesh::artifact_name, Mesh::artifact_version, {}},
                                                 {Image::artifact_name, Image::artifact_version, {"npy", png}},
                                                 {TexturedMesh::artifact_name, TexturedMesh::artifact_version, {"npy", png}},
                                                 {Texture::artifact_name, Texture::artifact_version, {}},
                                                 {Table::artifact_name, Table::artifact_version, {}},
                                                 {Frames::artifact_name, Frames::artifact_version, {}},
                                                 {UvMaps::artifact_name, UvMaps::artifact_version, {}},
                                                 {Files::artifact_name, Files::artifact_version, {}}};
    return forms;
}

const ExchangeForm* exchange_form(std::string_view artifact)
{
    const auto& forms = exchange_forms();
    const auto found =
        std::find_if(forms.begin(), forms.end(), [&](const ExchangeForm& form) { return form.artifact == artifact; });
    return found == forms.end() ? nullptr : &*found;
}

fs::path hand_over(const CommandPort& port, const ArtifactFolder& stored, const Artifact* value, const fs::path& folder,
                   const ImageIo* images)
{
    const ArtifactFolder exchange{folder, {}};
    if (port.artifact == Mesh::artifact_name)
    {
        loaded<Mesh>(stored, value)->save(exchange);
        return folder / "mesh.ply";
    }
    if (port.artifact == Image::artifact_name)
    {
        write_picture(*loaded<Image>(stored, value), port, folder, images);
        return folder / picture_name(port);
    }
    if (port.artifact == TexturedMesh::artifact_name)
    {
        const auto textured = loaded<TexturedMesh>(stored, value);
        textured->mesh.save(exchange);
        write_picture(textured->image, port, folder, images);
        return folder;
    }
    if (port.artifact == Texture::artifact_name)
    {
        loaded<Texture>(stored, value)->save(exchange);
        return folder;
    }
    if (port.artifact == Table::artifact_name)
    {
        loaded<Table>(stored, value)->save(exchange);
        return folder / "table.json";
    }
    if (port.artifact == Frames::artifact_name)
    {
        // Without a store every reference becomes a plain path.
        loaded<Frames>(stored, value)->save(exchange);
        return folder;
    }
    if (value != nullptr)
        throw Error("an artifact of the type " + port.artifact +
                    " can be handed to a program only from another stage, not from a file");
    return stored.path;
}

fs::path place_for(const CommandPort& port, const fs::path& scratch, const fs::path& published)
{
    if (port.artifact == Mesh::artifact_name)
        return scratch / "mesh.ply";
    if (port.artifact == Image::artifact_name)
        return scratch / picture_name(port);
    if (port.artifact == Table::artifact_name)
        return scratch / "table.json";
    const bool stays =
        port.artifact == Frames::artifact_name || port.artifact == UvMaps::artifact_name || port.artifact == Files::artifact_name;
    return stays ? published : scratch;
}

void take_back(const CommandPort& port, const fs::path& path, const ArtifactFolder& published, const ImageIo* images,
               RunContext& run)
{
    const ArtifactFolder written{path.extension().empty() ? path : path.parent_path(), {}};
    if (port.artifact == Mesh::artifact_name)
    {
        need_file(path);
        Mesh::load(written)->save(published);
    }
    else if (port.artifact == Image::artifact_name)
    {
        need_file(path);
        read_picture(port, written.path, images).save(published);
    }
    else if (port.artifact == TexturedMesh::artifact_name)
    {
        need_file(path / "mesh.ply");
        need_file(path / picture_name(port));
        TexturedMesh textured;
        textured.mesh = std::move(*Mesh::load(written));
        if (textured.mesh.texcoords.empty())
            throw Error((path / "mesh.ply").string() + ": a textured mesh needs texcoords: a list property texcoord per face");
        textured.image = read_picture(port, path, images);
        textured.save(published);
    }
    else if (port.artifact == Texture::artifact_name)
    {
        need_file(path / "texture.json");
        Texture::load(written)->save(published);
    }
    else if (port.artifact == Table::artifact_name)
    {
        need_file(path);
        Table::load(written)->save(published);
    }
    else if (port.artifact == Frames::artifact_name)
        take_frames(published, run);
    else if (port.artifact == UvMaps::artifact_name)
        take_uv_maps(published, run);
    else
        take_files(published);
}

}  // namespace fresco::host
