#include <fresco/artifact_type.h>
#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/frames.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/model.h>
#include <fresco/source_map.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <map>

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

void Artifact::write_exchange(const Exchange& to) const
{
    save(to.folder);
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
template struct RegisteredArtifact<SourceMap>;
template struct RegisteredArtifact<Table>;
template struct RegisteredArtifact<Texture>;
template struct RegisteredArtifact<TexturedMesh>;
template struct RegisteredArtifact<UvMaps>;

}  // namespace fresco
