#include "artifact_files.h"

#include <fresco/artifact.h>
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/relief.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace fresco
{
namespace
{

std::map<std::string, ArtifactType, std::less<>>& known()
{
    static auto& types = *new std::map<std::string, ArtifactType, std::less<>>;
    return types;
}

}  // namespace

const ExchangeForm* ArtifactType::form(std::string_view as) const
{
    const auto found = as.empty() ? forms.begin() : std::ranges::find(forms, as, &ExchangeForm::as);
    return found == forms.end() ? nullptr : &*found;
}

std::vector<std::string> ArtifactType::form_names() const
{
    std::vector<std::string> names;
    for (const ExchangeForm& each : forms)
        if (!each.as.empty())
            names.push_back(each.as);
    return names;
}

std::vector<const ArtifactType*> artifact_types()
{
    std::vector<const ArtifactType*> types;
    for (const auto& [name, type] : known())
        types.push_back(&type);
    return types;
}

const ArtifactType* find_artifact_type(std::string_view name)
{
    const auto found = known().find(name);
    return found == known().end() ? nullptr : &found->second;
}

Artifact::~Artifact() = default;

void Artifact::write_exchange(const Exchange& to) const
{
    save(to.folder);
}

std::vector<ExchangeForm> Artifact::exchange_forms()
{
    return {{}};
}

namespace detail
{

const ArtifactType* register_artifact_type(ArtifactType type)
{
    std::string name = type.name;
    return &known().emplace(std::move(name), std::move(type)).first->second;
}

void check_exchange_files(const std::vector<ExchangeForm>& forms, const Exchange& from)
{
    const auto form = std::ranges::find(forms, from.as, &ExchangeForm::as);
    if (form == forms.end())
        throw Error("unknown exchange form '" + from.as + "'");
    for (const std::string& file : form->files)
        if (!std::filesystem::is_regular_file(from.folder.path / file))
            throw Error((from.folder.path / file).string() + " was not written");
}

}  // namespace detail

template struct RegisteredArtifact<Files>;
template struct RegisteredArtifact<Frames>;
template struct RegisteredArtifact<Image>;
template struct RegisteredArtifact<Mesh>;
template struct RegisteredArtifact<Model>;
template struct RegisteredArtifact<Relief>;
template struct RegisteredArtifact<SourceMap>;
template struct RegisteredArtifact<Table>;
template struct RegisteredArtifact<Texture>;
template struct RegisteredArtifact<TexturedMesh>;
template struct RegisteredArtifact<UvMaps>;
namespace
{
namespace fs = std::filesystem;

constexpr std::string_view own_prefix = "own:";
constexpr std::string_view store_prefix = "store:";
constexpr std::string_view file_prefix = "file:";

/// `place`: of the file, below the store's root.
void note_result(const fs::path& place, const ArtifactFolder& folder)
{
    auto part = place.begin();
    if (*part == "tmp" || *part == "checkpoints")
        throw Error((folder.store / place).string() +
                    ": will be gone when the stage is done; refer only to files in the artifact's own folder or in an input's");
    if (folder.references != nullptr && *part == "objects" && ++part != place.end())
        folder.references->insert(part->string());
}

/// A file that a reference names below a folder.
fs::path named_below(const fs::path& folder, std::string_view prefix, const std::string& reference)
{
    const fs::path name = reference.substr(prefix.size());
    if (name.empty() || name.is_absolute() || std::ranges::find(name, fs::path("..")) != name.end())
        throw Error("reference \"" + reference + "\" leads out of its folder: use \"file:\" and an absolute path");
    return folder / name;
}

}  // namespace

std::optional<std::string> detail::below(const fs::path& path, const fs::path& base)
{
    if (base.empty())
        return std::nullopt;
    const fs::path relative = path.lexically_relative(base);
    if (relative.empty() || *relative.begin() == ".." || relative == ".")
        return std::nullopt;
    return relative.generic_string();
}

std::string reference_to(const fs::path& file, const ArtifactFolder& folder)
{
    if (const auto name = detail::below(file, folder.path))
        return std::string(own_prefix) + *name;
    if (const auto place = detail::below(file, folder.store))
    {
        note_result(*place, folder);
        return std::string(store_prefix) + *place;
    }
    return std::string(file_prefix) + fs::absolute(file).string();
}

fs::path referred_file(const std::string& reference, const ArtifactFolder& folder)
{
    if (reference.starts_with(own_prefix))
        return named_below(folder.path, own_prefix, reference);
    if (reference.starts_with(store_prefix))
        return named_below(folder.store, store_prefix, reference);
    if (!reference.starts_with(file_prefix))
        throw Error("reference \"" + reference + "\" does not begin with own:, store: or file:");
    return reference.substr(file_prefix.size());
}

namespace detail
{

namespace
{

/// Throws Error naming `file` unless the raster has so many channels; 0: any from 1 to 4.
template <class T>
Raster<T> with_channels(Raster<T> raster, int channels, const std::filesystem::path& file)
{
    if (channels == 0 ? raster.channels < 1 || raster.channels > 4 : raster.channels != channels)
        throw Error(fmt::format("{}: {} channels; expected {}", file.string(), raster.channels,
                                channels == 0 ? "1 to 4" : std::to_string(channels)));
    return raster;
}

}  // namespace

template <class T>
Raster<T> read_raster(const std::filesystem::path& file, int channels)
{
    return with_channels(to_raster<T>(read_npy(file), file.string()), channels, file);
}

template <class T>
void write_packed(const std::filesystem::path& folder, const std::string& name, const Raster<T>& raster)
{
    const auto file = folder / (name + ".packed");
    write_file(file, pack_raster(raster, file.string()));
}

std::filesystem::path npy_or_packed(const std::filesystem::path& folder, const std::string& name)
{
    auto npy = folder / (name + ".npy");
    return is_file(npy) ? npy : folder / (name + ".packed");
}

template <class T>
Raster<T> read_npy_or_packed(const std::filesystem::path& folder, const std::string& name, int channels)
{
    const auto file = npy_or_packed(folder, name);
    if (file.extension() == ".npy")
        return read_raster<T>(file, channels);
    return with_channels(unpack_raster<T>(read_file(file), file.string()), channels, file);
}

JsonFile::JsonFile(const std::filesystem::path& file)
    : value_(parse_json(read_text_file(file, std::size_t{1} << 30U), file.string())), root_(value_, file.string())
{
}

template Raster8 read_raster(const std::filesystem::path& file, int channels);
template Raster16 read_raster(const std::filesystem::path& file, int channels);
template RasterF read_raster(const std::filesystem::path& file, int channels);
template void write_packed(const std::filesystem::path& folder, const std::string& name, const Raster8& raster);
template void write_packed(const std::filesystem::path& folder, const std::string& name, const Raster16& raster);
template void write_packed(const std::filesystem::path& folder, const std::string& name, const RasterF& raster);
template Raster8 read_npy_or_packed(const std::filesystem::path& folder, const std::string& name, int channels);
template Raster16 read_npy_or_packed(const std::filesystem::path& folder, const std::string& name, int channels);
template RasterF read_npy_or_packed(const std::filesystem::path& folder, const std::string& name, int channels);

}  // namespace detail
}  // namespace fresco
