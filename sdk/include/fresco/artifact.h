#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

namespace fresco
{

class Preview;

/// Where an artifact is written or read. Lives as long as the call it is passed to.
struct ArtifactFolder
{
    std::filesystem::path path;  ///< The artifact's own folder; exists.
    std::filesystem::path
        store;  ///< The store's root, so that references to other results survive moving the store; may be empty.
};

/// A typed value passed along an edge of the pipeline. A type `T` derives from Artifact and has
/// \code
///   static constexpr std::string_view artifact_name = "mesh";   // unique, snake_case
///   static constexpr int artifact_version = 1;                  // of the on-disk form
///   void save(const ArtifactFolder&) const;                     // writes documented files into the folder
///   static std::shared_ptr<T> load(const ArtifactFolder&);      // throws Error on anything unexpected
/// \endcode
/// What is large stays on disk: the value is then a handle that reads piece by piece. Consumers share one value and must not
/// change it. The type's out-of-line destructor lives in the one shared library that defines the type.
class Artifact
{
  public:
    virtual ~Artifact();
    /// Gives the page of a run what there is to look at (fresco/preview.h); the default gives nothing, and then the host does not
    /// load the artifact for it. Throws Error for what cannot be shown: the page says so, and keeps what was given before.
    virtual void preview(Preview& page) const;

  protected:
    Artifact() = default;
    Artifact(const Artifact&) = default;
    Artifact(Artifact&&) = default;
    Artifact& operator=(const Artifact&) = default;
    Artifact& operator=(Artifact&&) = default;
};

/// Whether values of the type bring something for the page of a run.
template <class T>
inline constexpr bool has_preview = !std::is_same_v<decltype(&T::preview), decltype(&Artifact::preview)>;

}  // namespace fresco
