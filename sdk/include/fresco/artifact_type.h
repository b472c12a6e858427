#pragma once

#include <fresco/artifact.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// \file Types of artifacts by their names: for whoever gets one named by a pipeline.

namespace fresco
{

struct ArtifactType
{
    std::string name;
    int version = 1;
    bool has_preview = false;         ///< Values bring something for the page of a run.
    std::string parts_file;           ///< T::parts_file; empty where values have no named parts.
    std::vector<ExchangeForm> forms;  ///< The default first.
    std::shared_ptr<const Artifact> (*load)(const ArtifactFolder&) = nullptr;
    std::shared_ptr<const Artifact> (*from_exchange)(const Exchange&) = nullptr;

    /// nullptr where it has no form of that name; an empty name: the default.
    const ExchangeForm* form(std::string_view as) const;
    /// What `as` may say; empty where there is one form only.
    std::vector<std::string> form_names() const;
};

/// Those of the SDK, and of every plugin that this process has open.
std::vector<const ArtifactType*> artifact_types();
/// nullptr for other names.
const ArtifactType* find_artifact_type(std::string_view name);

/// Makes `T` one of artifact_types as soon as the library that uses it is opened. Each Input<T> and Output<T> does.
template <class T>
struct RegisteredArtifact
{
    static const ArtifactType& type;
};

namespace detail
{
/// The first registration of a name counts. A pointer: GCC takes a reference for one to the argument.
const ArtifactType* register_artifact_type(ArtifactType type);
/// Throws Error unless the program wrote the files of the form.
void check_exchange_files(const std::vector<ExchangeForm>& forms, const Exchange& from);

template <class T>
std::string parts_file_of()
{
    if constexpr (requires { T::parts_file; })
        return std::string(T::parts_file);
    return {};
}

template <class T>
std::shared_ptr<const Artifact> taken_from_exchange(const Exchange& from)
{
    check_exchange_files(T::exchange_forms(), from);
    if constexpr (requires { T::from_exchange(from); })
        return T::from_exchange(from);
    else
        return T::load(from.folder);
}
}  // namespace detail

template <class T>
const ArtifactType& RegisteredArtifact<T>::type = *detail::register_artifact_type(
    {std::string(T::artifact_name), T::artifact_version, has_preview<T>, detail::parts_file_of<T>(), T::exchange_forms(),
     [](const ArtifactFolder& folder) -> std::shared_ptr<const Artifact> { return T::load(folder); },
     detail::taken_from_exchange<T>});

}  // namespace fresco
