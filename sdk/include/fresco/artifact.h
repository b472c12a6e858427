#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

/// \file What stages pass to each other, as a class with save and load. Every artifact type derives from Artifact; stages name
/// them in Input and Output (port.h), and programs of the user's exchange them as files.

namespace fresco
{

class ImageIo;
class RunContext;
struct Exchange;
struct ExchangeForm;

/// Folder where an artifact is written or read. Lives as long as the call it is passed to.
struct ArtifactFolder
{
    std::filesystem::path path;  ///< The artifact's own folder; exists.
    std::filesystem::path
        store;  ///< The store's root, so that references to other results survive moving the store; may be empty.
    std::set<std::string>* references = nullptr;  ///< Receives the results that reference_to refers to; may be null.
};

/// A typed value passed along an edge of the pipeline. A type `T` derives from Artifact, can be made without arguments, and has
/// \code
///   static constexpr std::string_view artifact_name = "mesh";   // unique, snake_case
///   static constexpr int artifact_version = 1;                  // of the on-disk form
///   void save(const ArtifactFolder&) const override;            // writes documented files into the folder
///   static std::shared_ptr<T> load(const ArtifactFolder&);      // throws Error on anything unexpected
/// \endcode
/// A program of the user's reads and writes those files themselves, unless the type says otherwise by
/// \code
///   static std::vector<ExchangeForm> exchange_forms();              // the default first
///   void write_exchange(const Exchange&) const override;            // where a form is not what save writes
///   static std::shared_ptr<T> from_exchange(const Exchange&);       // where it is not what load reads; throws Error
/// \endcode
/// Files of other results are named by reference_to. What is large stays on disk: the value is then a handle that reads piece by
/// piece. Consumers share one value and must not change it. `save` is defined in a source file of the one shared library that has
/// the type: its type information is made there.
class Artifact
{
  public:
    virtual ~Artifact();
    virtual void save(const ArtifactFolder& folder) const = 0;
    /// Writes the files of a form; the default: those of save.
    virtual void write_exchange(const Exchange& to) const;
    static std::vector<ExchangeForm> exchange_forms();

  protected:
    Artifact() = default;
    Artifact(const Artifact&) = default;
    Artifact(Artifact&&) = default;
    Artifact& operator=(const Artifact&) = default;
    Artifact& operator=(Artifact&&) = default;
};

/// How an artifact names a file that may lie outside of its folder, in what it saves: "own:NAME" below its own folder,
/// "store:objects/…" in another result, or "file:PATH", a user's file. Of a result in the store, the id is noted in
/// `folder.references`: nothing but this makes the store keep and verify that result along with the artifact's own. Throws Error
/// for a file elsewhere in the store, which would be gone when the stage is done.
std::string reference_to(const std::filesystem::path& file, const ArtifactFolder& folder);
/// The file that a reference names. Throws Error for text that reference_to does not make.
std::filesystem::path referred_file(const std::string& reference, const ArtifactFolder& folder);

/// One form in which an artifact is put before a program of the user's, and taken back from it: the program gets a path.
struct ExchangeForm
{
    std::string as{};                  ///< Its name, where a type has several.
    std::vector<std::string> files{};  ///< Files that a program must write at least.
    bool is_folder = true;             ///< The program gets a folder's path; else that of the one file.
    bool taken_in_place = true;        ///< An input lies in the store, and the program reads it there; else it gets a copy.
    bool made_in_place = true;         ///< An output's files stay where the program writes them; else they are read and saved.
};

/// Folder of an exchange form's files, written by fresco or by a program.
struct Exchange
{
    std::string as;         ///< The form.
    ArtifactFolder folder;  ///< With a store where the files lie in one.
    const ImageIo* images;  ///< Null where no picture codec is given.
    RunContext& run;
};

struct ArtifactType
{
    std::string name;
    int version = 1;
    std::vector<ExchangeForm> forms;  ///< The default first.
    std::shared_ptr<const Artifact> (*load)(const ArtifactFolder&) = nullptr;
    std::shared_ptr<const Artifact> (*from_exchange)(const Exchange&) = nullptr;

    /// nullptr where it has no form of that name; an empty name: the default.
    const ExchangeForm* form(std::string_view as) const;
    /// Values of `as`; empty if there is only one form.
    std::vector<std::string> form_names() const;
};

/// Types of the SDK, and of every plugin that this process has open.
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
    {std::string(T::artifact_name), T::artifact_version, T::exchange_forms(),
     [](const ArtifactFolder& folder) -> std::shared_ptr<const Artifact> { return T::load(folder); },
     detail::taken_from_exchange<T>});

}  // namespace fresco
